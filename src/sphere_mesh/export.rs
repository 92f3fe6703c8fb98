//! A level as files that other programs read: `.ma`, and its surface as PLY or OBJ.

use std::path::Path;

use glam::Vec3;

use super::{extract::Skin, shape::Shape};
use crate::{
    Error, Result,
    asset::{PlyFrame, write_atomic, write_ply},
    mesh::Mesh,
};

/// Writes a level in one frame as a medial mesh: `#v #e #f`, then `v x y z r`, `e a b`, `f a b c`, counted from 0. All sides
/// of triangles are among the edges.
///
/// # Errors
/// [`Error::File`] where the system refuses.
pub fn write_ma(path: &Path, shape: &Shape) -> Result<()> {
    let sides = shape
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [a, c]]);
    let mut edges: Vec<[u32; 2]> = shape.edges.iter().copied().chain(sides).collect();
    edges.sort_unstable();
    edges.dedup();
    write_atomic(path, |out| {
        let counts = (shape.balls.len(), edges.len(), shape.triangles.len());
        writeln!(out, "{} {} {}", counts.0, counts.1, counts.2)?;
        for ball in &shape.balls {
            let c = ball.centre;
            writeln!(out, "v {} {} {} {}", c.x, c.y, c.z, ball.radius)?;
        }
        for [a, b] in &edges {
            writeln!(out, "e {a} {b}")?;
        }
        for [a, b, c] in &shape.triangles {
            writeln!(out, "f {a} {b} {c}")?;
        }
        Ok(())
    })
}

impl Skin {
    /// Positions and area-weighted normals in single precision.
    pub fn mesh(&self) -> Mesh {
        let positions: Vec<Vec3> = self.positions.iter().map(|p| p.as_vec3()).collect();
        Mesh::new(positions, self.triangles.clone())
    }

    /// Writes the surface as binary PLY with normals.
    ///
    /// # Errors
    /// [`Error::File`] where the system refuses; [`Error::Argument`] for a surface without vertices.
    pub fn write_ply(&self, path: &Path, frame: usize) -> Result<()> {
        let mesh = self.mesh();
        let count = mesh.positions.len();
        if count == 0 {
            return Err(Error::argument("surface", "it is empty"));
        }
        let zeros = vec![0.0; count];
        write_ply(
            path,
            &PlyFrame {
                positions: &mesh.positions,
                normals: &mesh.normals,
                field: &zeros,
                iso: &zeros,
                state: &vec![0; count],
                bone: &vec![0; count],
                triangles: &mesh.triangles,
                method: "sphere-mesh",
                clip: "",
                time: frame as f32,
                device: "",
            },
        )
    }
}
