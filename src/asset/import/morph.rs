//! Morph-target animation as a sequence: meshes without a skin whose weights a clip drives (glTF 2.0, 3.7.2.2 and 3.11).

use std::path::Path;

use glam::{DMat4, Vec3};
use gltf::json::{
    accessor::{ComponentType, Type},
    animation::{Interpolation, Property},
    mesh::Primitive,
    validation::Checked as Parsed,
};

use super::{
    accessor::{Accessor, Format},
    document::Document,
    fault::{Checked, refuse},
    geometry,
    graph::Graph,
};
use crate::{
    Error, Result,
    asset::{Room, Sequence},
};

/// A primitive of a mesh with morph targets, at a node.
struct Part<'a> {
    node: usize,
    primitive: &'a Primitive,
    element: String,
    /// Node → scene, as the file poses it.
    world: DMat4,
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

/// Weights of a node's targets over time.
struct Track {
    node: usize,
    times: Vec<f32>,
    /// `width` a key.
    values: Vec<f32>,
    width: usize,
    step: bool,
}

/// Reads the morph-target animation of a file as frames at `fps`, the first at 0: `clip` by name or number, otherwise the
/// first. Nodes stand where the file poses them, and weights that the clip does not drive are 0. `None` where the file has
/// a skin, or no mesh with morph targets.
///
/// # Errors
/// [`Error::File`] where the file cannot be read; [`Error::Asset`] with a JSON pointer where its content is wrong;
/// [`Error::Argument`] for a clip or rate that cannot be used; [`Error::Memory`] where the sequence needs more than `room`,
/// before its targets are read.
pub fn load_morph(
    path: &Path,
    clip: Option<&str>,
    fps: f32,
    room: Room,
) -> Result<Option<Sequence>> {
    if !(fps > 0.0 && fps <= 1e4) {
        return Err(Error::argument(
            "fps",
            format!("{fps}, not above 0 and at most 10000"),
        ));
    }
    let blame = |fault: super::fault::Fault| fault.with_path(path);
    let document = Document::open(path)?;
    let parts = parts(&document).map_err(blame)?;
    if parts.is_empty() {
        return Ok(None);
    }
    let clip = choose(&document, path, clip)?;
    let tracks = tracks(&document, clip).map_err(blame)?;
    let ends = tracks.iter().filter_map(|track| track.times.last());
    let seconds = ends.fold(0.0f32, |a, b| a.max(*b));
    let count = (f64::from(seconds) * f64::from(fps) * (1.0 + 1e-6)).floor() as usize + 1;
    let vertices = parts.iter().map(|part| part.positions.len()).sum();
    room.check(path, vertices, count)?;
    let mut sequence = Sequence {
        path: path.to_owned(),
        triangles: Vec::new(),
        frames: vec![Vec::with_capacity(vertices); count],
    };
    for part in &parts {
        let from = sequence.frames[0].len() as u32;
        let moved = part.triangles.iter().map(|t| t.map(|row| row + from));
        sequence.triangles.extend(moved);
        let targets = part.targets(&document).map_err(blame)?;
        let track = tracks.iter().find(|track| track.node == part.node);
        for (k, frame) in sequence.frames.iter_mut().enumerate() {
            let weights = track.map(|track| track.at(k as f32 / fps));
            frame.extend(part.at(&targets, &weights.unwrap_or_default()));
        }
    }
    Ok(Some(sequence))
}

fn parts(document: &Document) -> Checked<Vec<Part<'_>>> {
    let nodes = &document.root.nodes;
    if nodes
        .iter()
        .any(|node| node.mesh.is_some() && node.skin.is_some())
    {
        return Ok(Vec::new());
    }
    let graph = Graph::new(document)?;
    let mut parts = Vec::new();
    for (node, raw) in nodes.iter().enumerate() {
        let Some(mesh) = raw.mesh.map(|mesh| mesh.value()) else {
            continue;
        };
        let primitives = document.root.meshes[mesh].primitives.iter();
        for (number, primitive) in primitives.enumerate().filter(|(_, p)| p.targets.is_some()) {
            let element = format!("/meshes/{mesh}/primitives/{number}");
            let read = geometry::read(document, primitive, &element, &mut Vec::new())?;
            let Ok(geometry) = read else {
                continue;
            };
            parts.push(Part {
                node,
                primitive,
                element,
                world: graph.world()[node],
                positions: geometry.positions,
                triangles: geometry.triangles,
            });
        }
    }
    Ok(parts)
}

/// Row of the animation.
fn choose(document: &Document, path: &Path, clip: Option<&str>) -> Result<usize> {
    let clips = &document.root.animations;
    if clips.is_empty() {
        return Err(Error::asset(path, "/animations", "the file has no clip"));
    }
    let Some(wanted) = clip else {
        return Ok(0);
    };
    let named = clips.iter().position(|c| c.name.as_deref() == Some(wanted));
    let numbered = || wanted.parse().ok().filter(|&row| row < clips.len());
    named.or_else(numbered).ok_or_else(|| {
        let reason = format!("{wanted:?} is none of the file's {}", clips.len());
        Error::argument("clip", reason)
    })
}

fn tracks(document: &Document, clip: usize) -> Checked<Vec<Track>> {
    let animation = &document.root.animations[clip];
    let mut tracks = Vec::new();
    for (number, channel) in animation.channels.iter().enumerate() {
        if !matches!(
            channel.target.path,
            Parsed::Valid(Property::MorphTargetWeights)
        ) {
            continue;
        }
        let element = format!("/animations/{clip}/channels/{number}");
        let Some(sampler) = animation.samplers.get(channel.sampler.value()) else {
            return refuse(format!("{element}/sampler"), "there is no such sampler");
        };
        let scalars = [Format::float(Type::Scalar)];
        let read = |row, formats: &[Format], role| {
            Accessor::new(document, row)?
                .expect(formats, role)?
                .floats()
        };
        let times = read(sampler.input.value(), &scalars, "key times")?;
        if times.is_empty() || times.windows(2).any(|w| w[0] >= w[1]) {
            return refuse(element, "its key times do not rise");
        }
        let normalized = |component| Format {
            shape: Type::Scalar,
            component,
            normalized: true,
        };
        let formats = [
            Format::float(Type::Scalar),
            normalized(ComponentType::U8),
            normalized(ComponentType::U16),
            normalized(ComponentType::I8),
            normalized(ComponentType::I16),
        ];
        let values = read(sampler.output.value(), &formats, "weights")?;
        let (values, each) = match sampler.interpolation {
            // Tangents in, value, tangents out: the values alone, joined by lines, are exact at the keys.
            Parsed::Valid(Interpolation::CubicSpline) => middle(&values, times.len()),
            _ => (values, times.len()),
        };
        if values.is_empty() || !values.len().is_multiple_of(each) {
            return refuse(
                element,
                format!("{} weights for {} keys", values.len(), times.len()),
            );
        }
        tracks.push(Track {
            node: channel.target.node.value(),
            width: values.len() / times.len(),
            step: matches!(sampler.interpolation, Parsed::Valid(Interpolation::Step)),
            times,
            values,
        });
    }
    Ok(tracks)
}

/// The middle thirds of a spline's keys.
fn middle(values: &[f32], keys: usize) -> (Vec<f32>, usize) {
    let width = values.len() / (3 * keys);
    let thirds = values.chunks_exact(width.max(1)).skip(1).step_by(3);
    (thirds.take(keys).flatten().copied().collect(), keys)
}

impl Track {
    /// Weights of all targets at a time; before the first and after the last key they hold.
    fn at(&self, seconds: f32) -> Vec<f32> {
        let row = |k: usize| &self.values[k * self.width..(k + 1) * self.width];
        let last = self.times.len() - 1;
        let next = self.times.partition_point(|t| *t <= seconds);
        if next == 0 || next > last {
            return row(next.min(last)).to_vec();
        }
        let (from, to) = (self.times[next - 1], self.times[next]);
        let s = if self.step {
            0.0
        } else {
            (seconds - from) / (to - from)
        };
        let pairs = row(next - 1).iter().zip(row(next));
        pairs.map(|(a, b)| a + s * (b - a)).collect()
    }
}

impl Part<'_> {
    /// Displacements by each target; empty where it has no positions.
    fn targets(&self, document: &Document) -> Checked<Vec<Vec<Vec3>>> {
        let mut targets = Vec::new();
        for (number, target) in self.primitive.targets.iter().flatten().enumerate() {
            let Some(row) = target.positions else {
                targets.push(Vec::new());
                continue;
            };
            let moves = geometry::vectors(document, row.value(), "morph target")?;
            if moves.len() != self.positions.len() {
                let element = format!("{}/targets/{number}/POSITION", self.element);
                let count = self.positions.len();
                return refuse(
                    element,
                    format!("{} elements for {count} positions", moves.len()),
                );
            }
            targets.push(moves);
        }
        Ok(targets)
    }

    fn at(&self, targets: &[Vec<Vec3>], weights: &[f32]) -> Vec<Vec3> {
        let mut positions = self.positions.clone();
        let driven = targets.iter().zip(weights).filter(|(_, w)| **w != 0.0);
        for (moves, weight) in driven {
            for (p, d) in positions.iter_mut().zip(moves) {
                *p += *weight * d;
            }
        }
        let world = |p: &Vec3| self.world.transform_point3(p.as_dvec3()).as_vec3();
        positions.iter().map(world).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::asset::{Model, MorphAnimation, MorphFrame, Primitive, write_glb_morph};

    const ROOM: Room = Room {
        bytes: 1 << 20,
        need: |frames| 12 * frames as u64,
    };

    fn written(path: &Path) {
        let rest = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let model = Model {
            positions: rest.clone(),
            triangles: vec![[0, 1, 2]],
            primitives: vec![Primitive {
                name: "a".into(),
                vertices: 0..3,
                triangles: 0..1,
                base_color: [1.0; 4],
            }],
            ..Model::default()
        };
        let moved = |x: f32| rest.iter().map(|p| *p + Vec3::X * x).collect::<Vec<_>>();
        let rows: Vec<Vec<Vec3>> = [0.0, 1.0, 4.0].map(moved).to_vec();
        let frames: Vec<MorphFrame<'_>> = rows
            .iter()
            .enumerate()
            .map(|(k, positions)| MorphFrame {
                seconds: k as f32,
                positions,
                normals: &[Vec3::Z; 3],
            })
            .collect();
        let animation = MorphAnimation {
            method: "",
            clip: "hop",
            upright: glam::Quat::IDENTITY,
            frames: &frames,
        };
        write_glb_morph(path, &model, &animation).unwrap();
    }

    #[test]
    fn a_baked_animation_comes_back_as_frames() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.glb");
        written(&path);
        for clip in [None, Some("hop"), Some("0")] {
            let sequence = load_morph(&path, clip, 2.0, ROOM).unwrap().unwrap();
            let x: Vec<f32> = sequence.frames.iter().map(|f| f[0].x).collect();
            assert_eq!(x, [0.0, 0.5, 1.0, 2.5, 4.0]);
            assert_eq!(sequence.triangles, [[0, 1, 2]]);
        }
        assert!(load_morph(&path, Some("sit"), 2.0, ROOM).is_err());
        assert!(load_morph(&path, None, 0.0, ROOM).is_err());
        let small = Room { bytes: 10, ..ROOM };
        let error = load_morph(&path, None, 2.0, small).unwrap_err();
        assert!(matches!(error, Error::Memory { .. }), "{error}");
    }

    #[test]
    fn a_skinned_file_is_none() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/arm.glb");
        assert!(load_morph(&path, None, 30.0, ROOM).unwrap().is_none());
    }
}
