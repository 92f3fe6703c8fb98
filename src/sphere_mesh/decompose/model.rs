//! A decomposition as a character: a tree of joints, and a clip a sequence.

use glam::{DMat3, DQuat, DVec3, Mat4, Quat, Vec3};

use super::{Decomposition, tree::Tree};
use crate::{
    Error, Result,
    asset::{
        Channel, Clip, Influence, Interpolation, Joint, Model, Node, Primitive, Property, Sequence,
    },
    mesh::Mesh,
    sphere_mesh::{hierarchy::Hierarchy, level::Level},
};

impl Decomposition {
    /// The character: rows and triangles as the clips have them, a joint `sphere_N` for each sphere of the level under a node
    /// `rig`, and an animation a clip, named by its file, with `fps` frames a second.
    ///
    /// Joints turn where they meet their parents. Their animated rotations and translations give the decomposition's motions.
    ///
    /// # Errors
    /// [`Error::Argument`] where hierarchy, level or clips are not those that were decomposed, or `fps` is out of range.
    pub fn model(
        &self,
        hierarchy: &Hierarchy,
        level: &Level,
        clips: &[Sequence],
        fps: f32,
    ) -> Result<Model> {
        self.fits(hierarchy, level, clips)?;
        if !(1e-4..=1e4).contains(&fps) {
            return Err(Error::argument(
                "fps",
                format!("{fps}, not from 0.0001 to 10000"),
            ));
        }
        let tree = Tree::new(hierarchy, level, self);
        let mut row_of = vec![0; tree.sphere.len()];
        for (row, &sphere) in tree.sphere.iter().enumerate() {
            row_of[sphere] = row as u16;
        }
        let mesh = Mesh::new(self.rest.clone(), hierarchy.triangles.clone());
        let rows = || hierarchy.vertex.iter().map(|&v| v as usize);
        let list = |v: usize| {
            let influence = |&(sphere, weight): &(u32, f32)| Influence {
                joint: row_of[sphere as usize],
                weight,
            };
            self.influences[v].iter().map(influence).collect()
        };
        // A vertex without triangle has no normal of its own.
        let normal = |v: usize| mesh.normals[v].try_normalize().unwrap_or(Vec3::Y);
        let triangles = clips[0].triangles.clone();
        let named = names(clips);
        let clip = |(frames, name): (&Vec<_>, &String)| clip(&tree, frames, name, fps);
        Ok(Model {
            positions: rows().map(|v| self.rest[v]).collect(),
            normals: rows().map(normal).collect(),
            influences: rows().map(list).collect(),
            primitives: vec![Primitive {
                name: format!("{}/0", named[0]),
                vertices: 0..hierarchy.vertex.len(),
                triangles: 0..triangles.len(),
                base_color: [0.8, 0.8, 0.8, 1.0],
            }],
            triangles,
            joints: joints(&tree),
            nodes: nodes(&tree),
            clips: self.motions.iter().zip(&named).map(clip).collect(),
            ..Model::default()
        })
    }

    fn fits(&self, hierarchy: &Hierarchy, level: &Level, clips: &[Sequence]) -> Result<()> {
        let frames = |clip: &Sequence| clip.frames.len();
        let same = self.rest.len() == hierarchy.vertices
            && self.centres.len() == level.nodes.len()
            && self
                .motions
                .iter()
                .map(Vec::len)
                .eq(clips.iter().map(frames))
            && !clips.is_empty();
        if same {
            return Ok(());
        }
        Err(Error::argument(
            "decomposition",
            "made from another sphere-mesh or other clips",
        ))
    }
}

/// Names of the clips: of their files, made unique.
fn names(clips: &[Sequence]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for clip in clips {
        let stem = clip.path.file_stem().unwrap_or_default().to_string_lossy();
        let stem = if stem.is_empty() { "clip".into() } else { stem };
        let mut name = stem.to_string();
        let mut number = 2;
        while names.contains(&name) {
            name = format!("{stem}_{number}");
            number += 1;
        }
        names.push(name);
    }
    names
}

fn joints(tree: &Tree) -> Vec<Joint> {
    let joint = |(row, &sphere): (usize, &usize)| Joint {
        name: format!("sphere_{sphere}"),
        node: row + 1,
        parent: tree.parent[row],
        inverse_bind: Mat4::from_translation(-tree.origin[row].as_vec3()),
    };
    tree.sphere.iter().enumerate().map(joint).collect()
}

/// The node `rig`, then the joints at rest.
fn nodes(tree: &Tree) -> Vec<Node> {
    let node = |name: String, parent, translation| Node {
        name,
        parent,
        translation,
        rotation: Quat::IDENTITY,
        scale: Vec3::ONE,
        matrix: None,
    };
    let mut nodes = vec![node("rig".into(), None, Vec3::ZERO)];
    for (row, sphere) in tree.sphere.iter().enumerate() {
        let parent = tree.parent[row];
        // As single precision has them in the inverse bind matrices.
        let origin = |row: usize| tree.origin[row].as_vec3();
        let local = origin(row) - parent.map_or(Vec3::ZERO, origin);
        nodes.push(node(
            format!("sphere_{sphere}"),
            Some(parent.map_or(0, |p| p + 1)),
            local,
        ));
    }
    nodes
}

/// Local rotations and translations of all joints, a key a frame.
fn clip(tree: &Tree, frames: &[Vec<(DMat3, DVec3)>], name: &str, fps: f32) -> Clip {
    let times: Vec<f32> = (0..frames.len()).map(|f| f as f32 / fps).collect();
    let mut channels = Vec::with_capacity(2 * tree.sphere.len());
    for row in 0..tree.sphere.len() {
        let mut before = Quat::IDENTITY;
        let (mut turns, mut places) = (Vec::new(), Vec::new());
        for frame in frames {
            let (rotation, place) = local(tree, frame, row);
            let q = DQuat::from_mat3(&rotation).as_quat().normalize();
            // The shorter way round from key to key.
            let q = if q.dot(before) < 0.0 { -q } else { q };
            before = q;
            turns.extend(q.to_array());
            places.extend(place.as_vec3().to_array());
        }
        let channel = |property, values| Channel {
            node: row + 1,
            property,
            interpolation: Interpolation::Linear,
            times: times.clone(),
            values,
        };
        channels.push(channel(Property::Rotation, turns));
        channels.push(channel(Property::Translation, places));
    }
    Clip {
        name: name.to_owned(),
        seconds: times.last().copied().unwrap_or(0.0),
        channels,
    }
}

/// A joint against its parent, in a frame.
fn local(tree: &Tree, frame: &[(DMat3, DVec3)], row: usize) -> (DMat3, DVec3) {
    let global = |row: usize| {
        let (rotation, translation) = frame[tree.sphere[row]];
        // The origin as the inverse bind matrix has it.
        let origin = tree.origin[row].as_vec3().as_dvec3();
        (rotation, rotation * origin + translation)
    };
    let (rotation, place) = global(row);
    match tree.parent[row] {
        None => (rotation, place),
        Some(parent) => {
            let (turn, from) = global(parent);
            (
                turn.transpose() * rotation,
                turn.transpose() * (place - from),
            )
        }
    }
}
