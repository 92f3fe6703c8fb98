//! The mesh that is bent, from any file that has one.

use std::{collections::HashMap, path::Path};

use dermis::{
    Error, Result,
    asset::{self, Model, Primitive, Surface},
    mesh, rig,
};
use glam::{DVec3, Quat};

use crate::poses;

/// A mesh in rest, a row a vertex of the file.
pub(super) struct Shape {
    /// What a GLB is written from.
    pub(super) model: Model,
    pub(super) positions: Vec<DVec3>,
    pub(super) normals: Vec<DVec3>,
    /// Stands the mesh up in a GLB and in pictures.
    pub(super) upright: Quat,
    /// Edges that are no two triangles', after rows at one place are welded; none of a closed mesh.
    pub(super) open_edges: usize,
}

impl Shape {
    pub(super) fn load(path: &Path) -> Result<Self> {
        let still = match asset::is_surface(path) {
            true => Some(asset::load_surface(path)?),
            false => asset::load_still(path)?,
        };
        let (model, upright) = match still {
            Some(surface) => (without_joints(path, surface), Quat::IDENTITY),
            None => {
                let model = asset::load(path)?;
                let upright = poses::rotation(&rig::scene_from_rest(&model));
                (model, upright)
            }
        };
        let doubles = |rows: &[glam::Vec3]| rows.iter().map(|v| v.as_dvec3()).collect();
        Ok(Self {
            positions: doubles(&model.positions),
            normals: doubles(&model.normals),
            upright,
            open_edges: open_edges(&model),
            model,
        })
    }

    pub(super) fn triangles(&self) -> &[[u32; 3]] {
        &self.model.triangles
    }

    /// How much these joints, separated by commas, carry of each vertex.
    pub(super) fn mask(&self, joints: &str) -> Result<Vec<f64>> {
        let mut mask = vec![0.0; self.positions.len()];
        for name in joints.split(',') {
            let known = self.model.joints.iter().position(|j| j.name == name);
            let Some(joint) = known else {
                let reason = match self.model.joints.is_empty() {
                    true => "the file has no joints",
                    false => "the file has no such joint",
                };
                return Err(Error::Joint {
                    joint: name.into(),
                    reason: reason.into(),
                });
            };
            for (sum, influences) in mask.iter_mut().zip(&self.model.influences) {
                let own = influences.iter().filter(|i| usize::from(i.joint) == joint);
                *sum += own.map(|i| f64::from(i.weight)).sum::<f64>();
            }
        }
        Ok(mask.iter().map(|m| m.clamp(0.0, 1.0)).collect())
    }
}

fn without_joints(path: &Path, surface: Surface) -> Model {
    let (rows, triangles) = (surface.positions.len(), surface.triangles.len());
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut model = Model {
        path: path.into(),
        positions: surface.positions,
        triangles: surface.triangles,
        primitives: vec![Primitive {
            name: name.into_owned(),
            vertices: 0..rows,
            triangles: 0..triangles,
            base_color: [0.8, 0.8, 0.8, 1.0],
        }],
        ..Model::default()
    };
    model.normals = normals(&model);
    model
}

/// Area-weighted; +z where there is no area.
fn normals(model: &Model) -> Vec<glam::Vec3> {
    let mut sums = vec![DVec3::ZERO; model.positions.len()];
    for triangle in &model.triangles {
        let [a, b, c] = triangle.map(|row| model.positions[row as usize].as_dvec3());
        for row in triangle {
            sums[*row as usize] += (b - a).cross(c - a);
        }
    }
    let unit = |v: &DVec3| v.try_normalize().unwrap_or(DVec3::Z).as_vec3();
    sums.iter().map(unit).collect()
}

fn open_edges(model: &Model) -> usize {
    let welded = mesh::weld(&model.positions, &model.triangles);
    // Each edge once in each direction.
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for [a, b, c] in &welded.mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let turn = if from < to { 1 } else { -1 };
            *edges.entry((*from.min(to), *from.max(to))).or_default() += turn;
        }
    }
    edges.values().filter(|sum| **sum != 0).count()
}
