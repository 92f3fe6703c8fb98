//! A baked animation as GLB: one morph target a frame, which any viewer plays.

use std::path::Path;

use glam::{Quat, Vec3};
use serde_json::{Map, Value, json};

use super::glb::{Builder, Shape, Use, materials, too_large};
use crate::{
    Error, Result,
    asset::{Model, Primitive},
};

/// Baked frames of a model.
#[derive(Clone, Copy, Debug)]
pub struct MorphAnimation<'a> {
    /// Deformation method, kept in `extras`.
    pub method: &'a str,
    /// Clip, the animation's name.
    pub clip: &'a str,
    /// Rotation of the mesh's node, unit: turns the frames' space to glTF's, whose y points up.
    pub upright: Quat,
    /// Frames in order of time, at least one.
    pub frames: &'a [MorphFrame<'a>],
}

/// One baked frame; rows as in [`Model::positions`].
#[derive(Clone, Copy, Debug)]
pub struct MorphFrame<'a> {
    /// Time of the key, seconds, from 0.
    pub seconds: f32,
    /// Positions, model space.
    pub positions: &'a [Vec3],
    /// Unit normals, model space.
    pub normals: &'a [Vec3],
}

/// Writes the frames as morph targets whose weights are keyed one-hot with linear interpolation.
///
/// The mesh itself is the first frame, so that a viewer without animation shows it, and every frame has a target with
/// differences of positions and normals; between two keys their two targets are blended, exactly the linear blend of the
/// two frames. Size: 24 bytes a vertex and frame, and 4 a pair of frames. glTF sets no limit on targets, but some engines
/// do (Filament and Bevy: 256).
///
/// # Errors
/// [`Error::Argument`] where a frame's rows are not the model's, a number is not finite or times do not rise from 0;
/// [`Error::Asset`] where the file would pass 4 GiB; [`Error::File`] where it cannot be written.
pub fn write_glb_morph(path: &Path, model: &Model, animation: &MorphAnimation<'_>) -> Result<()> {
    let frames = animation.frames;
    check(model, frames)?;
    let (rows, count) = (model.positions.len() as u64, frames.len() as u64);
    let estimate = 24 * rows * (count + 1) + 4 * count * count;
    if estimate > u64::from(u32::MAX) {
        return Err(too_large(path, estimate));
    }
    let mut builder = Builder::default();
    let primitives = model.primitives.iter().enumerate();
    let primitives: Vec<Value> = primitives
        .map(|(row, primitive)| build_primitive(&mut builder, model, frames, row, primitive))
        .collect();
    let times: Vec<f32> = frames.iter().map(|frame| frame.seconds).collect();
    let input = builder.times(&times);
    let output = builder.array(Shape::Scalar, Use::Other, &one_hot(frames.len()));
    let names: Vec<String> = (0..frames.len())
        .map(|row| format!("frame_{row:04}"))
        .collect();
    let extras = json!({ "method": animation.method, "clip": animation.clip });
    let mut mesh = json!({
        "primitives": primitives,
        "weights": vec![0.0; frames.len()],
        "extras": extras,
    });
    mesh["extras"]["targetNames"] = names.into();
    let clip = json!({
        "name": animation.clip,
        "samplers": [{ "input": input, "output": output, "interpolation": "LINEAR" }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
        "extras": extras,
    });
    let mut root = Map::new();
    root.insert("scene".into(), 0.into());
    root.insert("scenes".into(), json!([{ "nodes": [0] }]));
    let rotation = animation.upright.to_array();
    root.insert(
        "nodes".into(),
        json!([{ "name": "skin", "mesh": 0, "rotation": rotation }]),
    );
    root.insert("meshes".into(), json!([mesh]));
    root.insert("materials".into(), materials(&model.primitives));
    root.insert("animations".into(), json!([clip]));
    builder.write(path, root)
}

fn check(model: &Model, frames: &[MorphFrame<'_>]) -> Result<()> {
    let fail = |row: usize, reason: String| Err(Error::argument(format!("frame {row}"), reason));
    if frames.is_empty() || model.primitives.is_empty() {
        return Err(Error::argument("frames", "nothing to write"));
    }
    let mut before = f32::NEG_INFINITY;
    for (row, frame) in frames.iter().enumerate() {
        let rows = (frame.positions.len(), frame.normals.len());
        let count = model.positions.len();
        if rows != (count, count) {
            return fail(row, format!("{rows:?} rows, the model has {count}"));
        }
        if !(frame.seconds.is_finite() && frame.seconds >= 0.0 && frame.seconds > before) {
            return fail(row, format!("time {} does not rise from 0", frame.seconds));
        }
        before = frame.seconds;
        let both = frame.positions.iter().zip(frame.normals);
        if let Some(vertex) = both
            .clone()
            .position(|(p, n)| !p.is_finite() || !n.is_finite())
        {
            return fail(row, format!("vertex {vertex} is not finite"));
        }
    }
    Ok(())
}

fn build_primitive(
    builder: &mut Builder,
    model: &Model,
    frames: &[MorphFrame<'_>],
    row: usize,
    primitive: &Primitive,
) -> Value {
    let range = primitive.vertices.clone();
    let base = &frames[0];
    let (positions, normals) = (&base.positions[range.clone()], &base.normals[range.clone()]);
    let triangles = &model.triangles[primitive.triangles.clone()];
    let targets: Vec<Value> = frames
        .iter()
        .map(|frame| {
            let moved = differences(&frame.positions[range.clone()], positions);
            let turned = differences(&frame.normals[range.clone()], normals);
            json!({ "POSITION": builder.positions(&moved), "NORMAL": builder.vectors(&turned) })
        })
        .collect();
    json!({
        "attributes": {
            "POSITION": builder.positions(positions),
            "NORMAL": builder.vectors(normals),
        },
        "indices": builder.triangles(triangles, range.start as u32),
        "material": row,
        "targets": targets,
        "extras": { "name": primitive.name },
    })
}

fn differences(rows: &[Vec3], base: &[Vec3]) -> Vec<Vec3> {
    rows.iter()
        .zip(base)
        .map(|(row, base)| row - base)
        .collect()
}

/// Weights of all targets at each key: the identity matrix.
fn one_hot(count: usize) -> Vec<f32> {
    let mut weights = vec![0.0; count * count];
    weights.iter_mut().step_by(count + 1).for_each(|w| *w = 1.0);
    weights
}
