//! Characters from raw arrays.

use std::ffi::c_char;

use glam::{Mat4, Vec3};

use super::{
    guard::{Fault, Outcome},
    pointer::{self, structs},
};
use crate::asset::{ArrayJoint, Arrays, Influence, Model, ROW_LIMIT};

/// Most joints of a character.
const JOINTS: usize = u16::MAX as usize;

/// Most influences of a vertex.
const INFLUENCES: usize = 64;

/// A rigged mesh, all in rest space: the space, in any unit, in which the mesh is modelled and bound.
///
/// Rows at one position (seams of texture coordinates) are welded for the deformation and come back as the rows they are.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_mesh_desc {
    /// sizeof(dm_mesh_desc).
    pub size: u32,
    /// Number of vertices.
    pub vertices: u32,
    /// Number of triangles.
    pub triangles: u32,
    /// Number of joints, up to 65535.
    pub joints: u32,
    /// Joints and weights of each vertex, up to 64; not read without weights.
    pub influences: u32,
    /// Positions, 3 numbers a vertex.
    pub positions: *const f32,
    /// Normals, 3 numbers a vertex; NULL to compute them from the triangles.
    pub normals: *const f32,
    /// Rows of vertices, 3 a triangle, counter-clockwise seen from outside.
    pub indices: *const u32,
    /// Parent of each joint, UINT32_MAX for a root. Parents come before their children.
    pub parents: *const u32,
    /// Bind matrix of each joint (the inverse of what glTF has): joint space to rest space, 16 numbers, column-major.
    pub bind: *const f32,
    /// Name of each joint, unique, in UTF-8; NULL for joint_0, joint_1 and so on.
    pub names: *const *const c_char,
    /// Joints of each vertex, `influences` a vertex; NULL, as weights, to compute both by heat diffusion.
    pub joint_indices: *const u16,
    /// Their weights, not negative; they are scaled to sum 1 where they do not.
    pub weights: *const f32,
    /// How rigidly each vertex follows its joint in tracking, from 0 (free) to 1; NULL for 0.
    pub rigid: *const f32,
}

structs!(dm_mesh_desc);

/// The model of a mesh.
///
/// # Safety
/// `desc` is NULL or valid, and so are its arrays, each as long as its numbers say.
pub(super) unsafe fn model(desc: *const dm_mesh_desc) -> Outcome<Model> {
    // SAFETY: the caller's promise, here and below.
    let desc = unsafe { pointer::read(desc, "desc")? };
    let vertices = bounded("desc.vertices", desc.vertices, ROW_LIMIT)?;
    let triangles = bounded("desc.triangles", desc.triangles, ROW_LIMIT)?;
    bounded("desc.joints", desc.joints, JOINTS)?;
    // SAFETY: see above.
    let arrays = unsafe {
        Arrays {
            positions: vectors(desc.positions, vertices, "desc.positions")?,
            normals: if desc.normals.is_null() {
                Vec::new()
            } else {
                vectors(desc.normals, vertices, "desc.normals")?
            },
            triangles: pointer::array(desc.indices.cast(), triangles, "desc.indices")?,
            joints: joints(&desc)?,
            influences: influences(&desc)?,
            rigid: if desc.rigid.is_null() {
                Vec::new()
            } else {
                pointer::array(desc.rigid, vertices, "desc.rigid")?
            },
        }
    };
    Ok(Model::from_arrays(arrays)?)
}

fn bounded(name: &str, count: u32, most: usize) -> Outcome<usize> {
    let count = count as usize;
    if (1..=most).contains(&count) {
        return Ok(count);
    }
    Err(Fault::argument(
        name,
        format!("{count} is not in 1 to {most}"),
    ))
}

/// # Safety
/// `pointer` is NULL or has three numbers a row.
unsafe fn vectors(pointer: *const f32, rows: usize, name: &str) -> Outcome<Vec<Vec3>> {
    // SAFETY: the caller's promise; a `Vec3` is three numbers.
    unsafe { pointer::array(pointer.cast(), rows, name) }
}

/// # Safety
/// As [`model`], with a number of joints that has been checked.
unsafe fn joints(desc: &dm_mesh_desc) -> Outcome<Vec<ArrayJoint>> {
    let count = desc.joints as usize;
    // SAFETY: the caller's promise, here and below; a `Mat4` is 16 numbers.
    let (parents, bind): (Vec<u32>, Vec<Mat4>) = unsafe {
        (
            pointer::array(desc.parents, count, "desc.parents")?,
            pointer::array(desc.bind.cast(), count, "desc.bind")?,
        )
    };
    let mut joints = Vec::with_capacity(count);
    for (row, (parent, bind)) in parents.into_iter().zip(bind).enumerate() {
        let name = if desc.names.is_null() {
            format!("joint_{row}")
        } else {
            // SAFETY: see above.
            unsafe {
                let name = desc.names.add(row).read_unaligned();
                pointer::text(name, &format!("desc.names[{row}]"))?
            }
        };
        joints.push(ArrayJoint {
            name,
            parent: (parent != u32::MAX).then_some(parent as usize),
            bind,
        });
    }
    Ok(joints)
}

/// # Safety
/// As [`model`], with numbers that have been checked.
unsafe fn influences(desc: &dm_mesh_desc) -> Outcome<Vec<Vec<Influence>>> {
    if desc.joint_indices.is_null() && desc.weights.is_null() {
        return Ok(Vec::new());
    }
    let width = bounded("desc.influences", desc.influences, INFLUENCES)?;
    let count = width * desc.vertices as usize;
    // SAFETY: the caller's promise.
    let (joints, weights): (Vec<u16>, Vec<f32>) = unsafe {
        (
            pointer::array(desc.joint_indices, count, "desc.joint_indices")?,
            pointer::array(desc.weights, count, "desc.weights")?,
        )
    };
    let rows = joints.chunks_exact(width).zip(weights.chunks_exact(width));
    let influence = |(joint, weight): (&u16, &f32)| Influence {
        joint: *joint,
        weight: *weight,
    };
    Ok(rows
        .map(|(joints, weights)| joints.iter().zip(weights).map(influence).collect())
        .collect())
}
