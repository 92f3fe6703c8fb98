//! Skeleton, poses, weights and partition; together with mesh and fields they make the immutable [`Rig`].

mod archive;
mod bones;
pub mod cache;
mod clip;
mod heat;
mod interpolate;
mod options;
mod pose;
mod pose_file;
mod prepare;
mod primitive;
mod program;
mod random;
mod rigid;
mod sample;
mod sheets;
pub(crate) mod skeleton;
mod spine;
mod subdivide;
mod swell;
mod volumes;
mod weights;

use std::path::PathBuf;

use glam::Mat4;

use crate::{
    compose::Composition,
    field::Field,
    mesh::{Csr, Mesh},
};

pub use clip::scene_from_rest;
pub use options::Options;
pub(crate) use pose::degrees;
pub use pose_file::{JointPose, PoseFile};
pub use primitive::Primitive;
pub use random::Random;
pub use sample::sequence;
pub use spine::{FleshPlace, Fleshing, SpineChain, SpinePoint};
pub use subdivide::subdivide;
pub use swell::{Stretch, Swell};

/// One joint of a skeleton.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// Row of the parent, always smaller than the joint's own.
    pub parent: Option<usize>,
    /// Joint space → rest space.
    pub bind: Mat4,
    /// Rest space → joint space.
    pub inverse_bind: Mat4,
}

/// Joints, parents before children.
#[derive(Clone, Debug, Default)]
pub struct Skeleton {
    /// Joints, parents before children.
    pub joints: Vec<Joint>,
    /// Rows of the children of each joint, ascending.
    pub children: Vec<Vec<usize>>,
}

/// A posed skeleton.
#[derive(Debug, Default, PartialEq)]
pub struct Pose {
    /// Rest → model space, one a joint; identity is the rest pose.
    pub matrices: Vec<Mat4>,
}

/// Weights of welded vertices, fixed width, greatest first, padded with weight 0.
#[derive(Clone, Debug, Default)]
pub struct Weights {
    /// Influences a vertex (4, 8, 12, …).
    pub width: usize,
    /// Joint rows, `width` a vertex.
    pub joints: Vec<u16>,
    /// Weights, `width` a vertex, sum 1.
    pub weights: Vec<f32>,
}

/// The file's own rows against the welded mesh.
#[derive(Clone, Debug, Default)]
pub struct FileRows {
    /// Welded vertex of a row.
    pub vertex: Vec<u32>,
    /// The file's normal of a row.
    pub normals: Vec<glam::Vec3>,
    /// The file's triangles, as rows.
    pub triangles: Vec<[u32; 3]>,
}

/// A character prepared for deformation; immutable and shared.
#[derive(Clone, Debug, Default)]
pub struct Rig {
    /// File name, for reports.
    pub name: String,
    /// Welded mesh in rest space.
    pub mesh: Mesh,
    /// The file's rows.
    pub rows: FileRows,
    /// Joints.
    pub skeleton: Skeleton,
    /// Weights of the welded vertices.
    pub weights: Weights,
    /// Part (joint row) of each welded vertex: the joint of greatest weight that has a field or none at all.
    pub part: Vec<u16>,
    /// Radius of each joint's part in rest units: no vertex moves further than this from its geometric position.
    pub radius: Vec<f32>,
    /// Implicit fields, ascending by joint; those of the extra primitives follow.
    pub fields: Vec<Field>,
    /// Extra primitives, one a field at the end of the fields.
    pub primitives: Vec<Swell>,
    /// How the fields are combined.
    pub composition: Composition,
    /// Mean value coordinates aligned with `mesh.one_ring.items`; an all-zero row is not relaxed.
    pub mean_value: Vec<f32>,
    /// Vertices within three rings of each vertex, itself included, ascending.
    pub neighbourhood: Csr,
    /// Vertices that follow geometric skinning only (thin sheets, small rigid shells), or fleshing wholly.
    pub geometric: Vec<bool>,
    /// How rigidly each welded vertex follows its part's joint in tracking, from 0 (free) to 1: carried from its place at rest,
    /// projected, but never relaxed (2014, section 6.2 and figure 11).
    pub rigid: Vec<f32>,
    /// Vertices that bend by fleshing along chains of joints.
    pub fleshing: Fleshing,
    /// Folder that keeps what takes long to make, where the user named one.
    pub cache: Option<PathBuf>,
    /// What was mended or left out, a sentence each.
    pub warnings: Vec<String>,
}

#[cfg(test)]
mod character_tests;
