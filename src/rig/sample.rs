//! A clip of a skinned character as a sequence of meshes.

use glam::Vec3;

use super::{Pose, Skeleton};
use crate::{
    Error, Result,
    asset::{Model, Room, Sequence},
};

/// Frames of a clip at `fps`, skinned linearly with all influences of the file; the first at 0, the last at or before the end.
///
/// # Errors
/// [`Error::Argument`] for a clip that the model has not or a rate out of range; [`Error::Joint`] or [`Error::Pose`] where
/// skeleton or keys cannot be used; [`Error::Asset`] naming a vertex without influences; [`Error::Memory`] where the
/// sequence needs more than `room`, before it is made.
pub fn sequence(model: &Model, clip: usize, fps: f32, room: Room) -> Result<Sequence> {
    if !(fps > 0.0 && fps <= 1e4) {
        return Err(Error::argument(
            "fps",
            format!("{fps}, not above 0 and at most 10000"),
        ));
    }
    let skeleton = Skeleton::from_model(model)?;
    let Some(seconds) = model.clips.get(clip).map(|clip| clip.seconds) else {
        let reason = format!("{clip} given, the file has {}", model.clips.len());
        return Err(Error::argument("clip", reason));
    };
    if let Some(vertex) = model.influences.iter().position(Vec::is_empty) {
        let element = format!("vertex {vertex}");
        return Err(Error::asset(&model.path, element, "no joint moves it"));
    }
    let count = (f64::from(seconds) * f64::from(fps) * (1.0 + 1e-6)).floor() as usize + 1;
    room.check(&model.path, model.positions.len(), count)?;
    let frame = |k: usize| {
        let pose = Pose::from_clip(model, &skeleton, clip, k as f32 / fps)?;
        let rows = model.positions.iter().zip(&model.influences);
        let skinned = rows.map(|(p, influences)| {
            let parts = influences.iter().map(|i| {
                let matrix = &pose.matrices[usize::from(i.joint)];
                i.weight * matrix.transform_point3(*p)
            });
            parts.sum::<Vec3>()
        });
        Ok(skinned.collect())
    };
    let frames: Result<Vec<Vec<Vec3>>> = (0..count).map(frame).collect();
    Ok(Sequence {
        path: model.path.clone(),
        triangles: model.triangles.clone(),
        frames: frames?,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::asset;

    #[test]
    fn a_clip_becomes_frames_that_move() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/mannequin.glb");
        let model = asset::load(&path).unwrap();
        let room = Room {
            bytes: 1 << 30,
            need: |frames| 12 * frames as u64,
        };
        let sequence = sequence(&model, 0, 10.0, room).unwrap();
        let wanted = (model.clips[0].seconds * 10.0 + 1e-3).floor() as usize + 1;
        assert_eq!(sequence.frames.len(), wanted);
        assert!(sequence.frames.iter().flatten().all(|p| p.is_finite()));
        assert_ne!(sequence.frames[0], sequence.frames[1]);
        assert!(super::sequence(&model, 99, 10.0, room).is_err());
        assert!(super::sequence(&model, 0, 0.0, room).is_err());
        let small = Room { bytes: 9, ..room };
        let error = super::sequence(&model, 0, 10.0, small).unwrap_err();
        assert!(matches!(error, Error::Memory { .. }), "{error}");
    }
}
