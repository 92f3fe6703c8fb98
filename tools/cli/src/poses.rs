//! The frames that a command plays: from a clip, a pose file, chance or the rest pose.

use dermis::{
    Error, Result,
    asset::Model,
    rig::{self, Pose, PoseFile, Skeleton},
};
use glam::{Mat3, Mat4, Quat, Vec3};

use crate::{console::Console, options::PoseOptions, session::Character};

/// One frame to play.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    /// Number in its source.
    pub(crate) number: usize,
    /// Time in its source.
    pub(crate) seconds: f32,
    pub(crate) pose: Pose,
}

/// Frames and where they come from.
#[derive(Clone, Debug)]
pub(crate) struct Frames {
    /// `clip walk`, `pose file.json`, `random seed 1` or `rest`.
    pub(crate) source: String,
    /// The clip's name, if a clip it is.
    pub(crate) clip: Option<String>,
    pub(crate) fps: f32,
    pub(crate) frames: Vec<Frame>,
    /// Whether no frame follows from the one before: then each is tracked from rest.
    pub(crate) independent: bool,
    /// Turns the frames' space upright, as the file's scene stands. A clip is in the scene's space already; the other
    /// sources are in rest space, in which many exporters lay characters down.
    pub(crate) upright: Quat,
}

/// What to play where the user names no source and the file has no clip.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Fallback {
    /// The rest pose.
    Rest,
    /// This many random poses.
    Random(u32),
}

impl Frames {
    /// Resolves the user's choice; `degrees` is the greatest random angle where the user gives none.
    pub(crate) fn choose(
        options: &PoseOptions,
        character: &Character,
        fallback: Fallback,
        degrees: f32,
        console: &Console,
    ) -> Result<Self> {
        let Character {
            model, skeleton, ..
        } = character;
        let degrees = options.degrees.unwrap_or(degrees);
        let upright = |frames: Frames| Frames {
            upright: rotation(&rig::scene_from_rest(model)),
            ..frames
        };
        if options.rest {
            return from_rest(options, skeleton).map(upright);
        }
        if let Some(count) = options.random {
            return from_chance(options, skeleton, count, degrees).map(upright);
        }
        if let Some(path) = &options.pose {
            return from_file(options, path, skeleton).map(upright);
        }
        if let Some(clip) = &options.clip {
            return from_clip(options, find_clip(model, clip)?, model, skeleton);
        }
        if let Some(first) = model.clips.first() {
            if model.clips.len() > 1 {
                console.note(format_args!(
                    "playing the first of {} clips, {:?}; --clip chooses another, --rest none",
                    model.clips.len(),
                    first.name
                ))?;
            } else {
                console.note(format_args!("playing the clip {:?}", first.name))?;
            }
            return from_clip(options, 0, model, skeleton);
        }
        match fallback {
            Fallback::Rest => from_rest(options, skeleton),
            Fallback::Random(count) => from_chance(options, skeleton, count, degrees),
        }
        .map(upright)
    }
}

fn from_rest(options: &PoseOptions, skeleton: &Skeleton) -> Result<Frames> {
    frames(options, "rest".into(), None, 1, |_| {
        Ok(Pose::rest(skeleton))
    })
}

fn from_chance(
    options: &PoseOptions,
    skeleton: &Skeleton,
    count: u32,
    degrees: f32,
) -> Result<Frames> {
    let source = format!("random ±{degrees}° seed {}", options.seed);
    frames(options, source, None, count as usize, |number| {
        let seed = options.seed.wrapping_add(number as u64);
        Pose::random(skeleton, degrees, seed)
    })
    .map(|frames| Frames {
        independent: true,
        ..frames
    })
}

fn from_file(options: &PoseOptions, path: &std::path::Path, skeleton: &Skeleton) -> Result<Frames> {
    let file = PoseFile::read(path)?;
    let source = format!("pose {}", path.display());
    frames(options, source, None, file.frames.len(), |number| {
        Pose::from_file_frame(&file, skeleton, number)
    })
}

fn from_clip(
    options: &PoseOptions,
    clip: usize,
    model: &Model,
    skeleton: &Skeleton,
) -> Result<Frames> {
    let name = model.clips[clip].name.clone();
    // The last key has a frame of its own when it falls on one, rounding aside.
    let count = (model.clips[clip].seconds * options.fps + 1e-3).floor() as usize + 1;
    let source = format!("clip {name}");
    frames(options, source, Some(name), count, |number| {
        Pose::from_clip(model, skeleton, clip, number as f32 / options.fps)
    })
}

fn frames(
    options: &PoseOptions,
    source: String,
    clip: Option<String>,
    count: usize,
    pose: impl Fn(usize) -> Result<Pose>,
) -> Result<Frames> {
    let range = options.frames.clone().unwrap_or(0..count);
    if range.end > count {
        let reason = format!(
            "{}..{} passes the end: {source} has {count} frames at {} a second",
            range.start, range.end, options.fps
        );
        return Err(Error::argument("--frames", reason));
    }
    let frame = |number| {
        let seconds = number as f32 / options.fps;
        pose(number).map(|pose| Frame {
            number,
            seconds,
            pose,
        })
    };
    Ok(Frames {
        source,
        clip,
        fps: options.fps,
        frames: range.map(frame).collect::<Result<_>>()?,
        independent: false,
        upright: Quat::IDENTITY,
    })
}

/// The turn in a matrix, without its scale and without its shift.
pub(crate) fn rotation(matrix: &Mat4) -> Quat {
    let [x, y] = [matrix.x_axis, matrix.y_axis].map(|axis| axis.truncate());
    let x = x.normalize_or(Vec3::X);
    let y = y.reject_from_normalized(x);
    match y.try_normalize() {
        Some(y) => Quat::from_mat3(&Mat3::from_cols(x, y, x.cross(y))),
        None => Quat::IDENTITY,
    }
}

/// By name, else by number.
fn find_clip(model: &Model, wanted: &str) -> Result<usize> {
    let names = || {
        let names: Vec<&str> = model.clips.iter().map(|c| c.name.as_str()).collect();
        match names.len() {
            0 => "the file has none".to_string(),
            _ => format!("the file has {}", names.join(", ")),
        }
    };
    let by_name = model.clips.iter().position(|c| c.name == wanted);
    let by_number = || {
        let number = wanted.parse().ok();
        number.filter(|&n: &usize| n < model.clips.len())
    };
    by_name
        .or_else(by_number)
        .ok_or_else(|| Error::argument("--clip", format!("no clip {wanted:?}: {}", names())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_turn_in_a_matrix_is_found_below_its_scale() {
        let turn = Quat::from_rotation_x(-1.5) * Quat::from_rotation_z(0.4);
        for scale in [Vec3::splat(0.01), Vec3::new(2.0, 3.0, 0.5)] {
            let matrix = Mat4::from_scale_rotation_translation(scale, turn, Vec3::splat(7.0));
            assert!(rotation(&matrix).angle_between(turn) < 1e-3);
        }
        assert!(rotation(&Mat4::ZERO).is_finite());
    }
}
