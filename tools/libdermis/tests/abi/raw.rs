//! The bundled arm as a path and as arrays, and a small mesh.

use std::{
    ffi::{CString, c_char},
    ptr::null,
};

use dermis::{asset::Model, capi::*};
use glam::Mat4;

/// Path of the bundled arm.
pub(crate) fn path() -> CString {
    let path = crate::root().join("assets/arm.glb");
    CString::new(path.to_str().unwrap()).unwrap()
}

/// Arrays of a rigged mesh.
#[derive(Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) indices: Vec<[u32; 3]>,
    pub(crate) parents: Vec<u32>,
    pub(crate) bind: Vec<[f32; 16]>,
    pub(crate) names: Vec<CString>,
    pointers: Vec<*const c_char>,
    pub(crate) influences: usize,
    pub(crate) joints: Vec<u16>,
    pub(crate) weights: Vec<f32>,
}

impl Mesh {
    /// A closed tube along x with two joints, without weights.
    pub(crate) fn tube() -> Self {
        Self::tube_of(17, 12)
    }

    /// The same with this many rings of vertices.
    pub(crate) fn tube_of(rings: u32, sides: u32) -> Self {
        let mut mesh = Self::default();
        for ring in 0..rings {
            for side in 0..sides {
                let angle = std::f32::consts::TAU * side as f32 / sides as f32;
                let x = 4.0 * ring as f32 / (rings - 1) as f32;
                mesh.positions
                    .push([x, 0.4 * angle.cos(), 0.4 * angle.sin()]);
            }
        }
        let at = |ring: u32, side: u32| ring * sides + side % sides;
        for ring in 0..rings - 1 {
            for side in 0..sides {
                let (a, b) = (at(ring, side), at(ring, side + 1));
                let (c, d) = (at(ring + 1, side), at(ring + 1, side + 1));
                mesh.indices.extend([[a, b, c], [c, b, d]]);
            }
        }
        for side in 1..sides - 1 {
            let last = rings - 1;
            mesh.indices.push([at(0, 0), at(0, side + 1), at(0, side)]);
            mesh.indices
                .push([at(last, 0), at(last, side), at(last, side + 1)]);
        }
        mesh.parents = vec![u32::MAX, 0];
        mesh.bind = [0.0, 2.0]
            .map(|x| Mat4::from_translation(glam::Vec3::X * x).to_cols_array())
            .to_vec();
        mesh
    }

    /// The arrays of a model.
    pub(crate) fn of(model: &Model) -> Self {
        let width = model.influences.iter().map(Vec::len).max().unwrap();
        let mut mesh = Self {
            positions: model.positions.iter().map(|p| p.to_array()).collect(),
            normals: model.normals.iter().map(|n| n.to_array()).collect(),
            indices: model.triangles.clone(),
            influences: width,
            ..Self::default()
        };
        for joint in &model.joints {
            mesh.parents
                .push(joint.parent.map_or(u32::MAX, |p| p as u32));
            mesh.bind.push(joint.inverse_bind.inverse().to_cols_array());
            mesh.names.push(CString::new(joint.name.as_str()).unwrap());
        }
        mesh.pointers = mesh.names.iter().map(|name| name.as_ptr()).collect();
        for list in &model.influences {
            for slot in 0..width {
                let influence = list.get(slot);
                mesh.joints.push(influence.map_or(0, |i| i.joint));
                mesh.weights.push(influence.map_or(0.0, |i| i.weight));
            }
        }
        mesh
    }

    /// A description of the arrays, valid as long as they are.
    pub(crate) fn desc(&self) -> dm_mesh_desc {
        fn of<T, U>(rows: &[T]) -> *const U {
            if rows.is_empty() {
                null()
            } else {
                rows.as_ptr().cast()
            }
        }
        dm_mesh_desc {
            size: size_of::<dm_mesh_desc>() as u32,
            vertices: self.positions.len() as u32,
            triangles: self.indices.len() as u32,
            joints: self.parents.len() as u32,
            influences: self.influences as u32,
            positions: of(&self.positions),
            normals: of(&self.normals),
            indices: of(&self.indices),
            parents: of(&self.parents),
            bind: of(&self.bind),
            names: of(&self.pointers),
            joint_indices: of(&self.joints),
            weights: of(&self.weights),
            rigid: null(),
        }
    }
}
