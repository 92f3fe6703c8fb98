//! A character as its file tells it, validated but not prepared.

use std::{ops::Range, path::PathBuf};

use glam::{Mat4, Quat, Vec3};

/// A rigged character: all primitives of the skinned meshes one after the other, in **rest** space.
///
/// Rest space is the bind space of the file's first skin; meshes of other skins are carried into it on load.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// The file.
    pub path: PathBuf,
    /// Rest positions, a row a vertex of the file.
    pub positions: Vec<Vec3>,
    /// Unit normals, a row a vertex (area-weighted where the file has none).
    pub normals: Vec<Vec3>,
    /// Triangles as vertex rows; always in range.
    pub triangles: Vec<[u32; 3]>,
    /// Which rows belong to which primitive of the file.
    pub primitives: Vec<Primitive>,
    /// Weights a vertex: finite, positive, sum 1, greatest first; empty lists where the file gives none.
    pub influences: Vec<Vec<Influence>>,
    /// How rigidly each vertex follows its joint in tracking, from 0 (free) to 1 (never relaxed), by the attribute `_RIGID`;
    /// empty where no primitive has it.
    pub rigid: Vec<f32>,
    /// Joints of all skins, parents before children.
    pub joints: Vec<Joint>,
    /// The node tree that clips animate, parents before children.
    pub nodes: Vec<Node>,
    /// Chains of joints that the file marks as spines.
    pub spines: Vec<Spine>,
    /// Animations.
    pub clips: Vec<Clip>,
    /// Extensions that the file uses.
    pub extensions: Vec<String>,
    /// What was mended or left out on load, a sentence each.
    pub warnings: Vec<String>,
}

/// One primitive of a mesh.
#[derive(Clone, Debug)]
pub struct Primitive {
    /// `mesh name/primitive number`.
    pub name: String,
    /// Its rows in the vertex arrays.
    pub vertices: Range<usize>,
    /// Its rows in the triangle array.
    pub triangles: Range<usize>,
    /// Linear base colour of its material.
    pub base_color: [f32; 4],
}

/// Weight of one joint for one vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influence {
    /// Row in [`Model::joints`].
    pub joint: u16,
    /// In (0, 1].
    pub weight: f32,
}

/// A joint of a skin.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name of its node, or `joint_N`; made unique.
    pub name: String,
    /// Row in [`Model::nodes`].
    pub node: usize,
    /// Nearest ancestor that is a joint.
    pub parent: Option<usize>,
    /// Rest space → joint space; invertible and finite.
    pub inverse_bind: Mat4,
}

/// A chain of joints that bends by fleshing, marked by `dermis_spine` in the extras of its first joint's node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spine {
    /// Name of its first joint.
    pub root: String,
    /// Name of its last, the root or a descendant.
    pub tip: String,
    /// `radial`, `normal` or `binormal`: in which direction flesh gives way.
    pub map: String,
}

/// A node of the file's tree with its own (unanimated) transform.
#[derive(Clone, Debug)]
pub struct Node {
    /// Name or `node_N`.
    pub name: String,
    /// Row of the parent.
    pub parent: Option<usize>,
    /// Local translation.
    pub translation: Vec3,
    /// Local rotation, unit.
    pub rotation: Quat,
    /// Local scale.
    pub scale: Vec3,
    /// Local matrix where the file gives one instead; such a node is not animated.
    pub matrix: Option<Mat4>,
}

/// An animation.
#[derive(Clone, Debug)]
pub struct Clip {
    /// Name or `clip_N`; made unique.
    pub name: String,
    /// Time of the last key, seconds.
    pub seconds: f32,
    /// One channel a node and property.
    pub channels: Vec<Channel>,
}

/// Keys of one property of one node.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Row in [`Model::nodes`].
    pub node: usize,
    /// What it drives.
    pub property: Property,
    /// How to interpolate.
    pub interpolation: Interpolation,
    /// Key times in seconds, rising.
    pub times: Vec<f32>,
    /// Flat values: 3 floats a key (translation, scale) or 4 (rotation x y z w); three times as many for cubic splines.
    pub values: Vec<f32>,
}

/// The property that a channel drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// Local translation.
    Translation,
    /// Local rotation.
    Rotation,
    /// Local scale.
    Scale,
}

/// Interpolation between keys (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Holds the last key.
    Step,
    /// Linear, spherical for rotations.
    Linear,
    /// Hermite spline with tangents.
    CubicSpline,
}
