//! Collects vertices and faces, and checks what every format must keep.

use glam::Vec3;

use super::{Parsed, Surface, refuse};
use crate::asset::ROW_LIMIT;

/// A mesh in the making; each face remembers where it stands in the file, for faces may precede their vertices.
#[derive(Default)]
pub(super) struct Gather {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// Line or row of each triangle's face.
    origin: Vec<usize>,
}

impl Gather {
    /// Vertices so far.
    pub(super) fn vertices(&self) -> usize {
        self.positions.len()
    }

    /// Adds a vertex; `at` names its place.
    pub(super) fn vertex(&mut self, at: impl Fn() -> String, xyz: [f64; 3]) -> Parsed<()> {
        let position = Vec3::from(xyz.map(|x| x as f32));
        if !position.is_finite() {
            let [x, y, z] = xyz;
            return refuse(at(), format!("position {x} {y} {z} is not finite"));
        }
        if self.positions.len() == ROW_LIMIT {
            return refuse(at(), format!("more than {ROW_LIMIT} vertices"));
        }
        self.positions.push(position);
        Ok(())
    }

    /// Adds a face as a fan about its first corner; `origin` is its line or row.
    pub(super) fn face(
        &mut self,
        origin: usize,
        at: impl Fn() -> String,
        corners: &[u32],
    ) -> Parsed<()> {
        if corners.len() < 3 {
            return refuse(at(), format!("a face of {} corners", corners.len()));
        }
        if self.triangles.len() + corners.len() - 2 > ROW_LIMIT {
            return refuse(at(), format!("more than {ROW_LIMIT} triangles"));
        }
        for pair in corners[1..].windows(2) {
            self.triangles.push([corners[0], pair[0], pair[1]]);
            self.origin.push(origin);
        }
        Ok(())
    }

    /// The mesh, unless a face names a vertex that does not exist; `unit` is what `origin` counts.
    pub(super) fn finish(self, unit: &str) -> Parsed<Surface> {
        let rows = self.positions.len();
        let outside = |t: &[u32; 3]| t.iter().any(|&v| v as usize >= rows);
        if let Some(bad) = self.triangles.iter().position(outside) {
            let vertex = self.triangles[bad].into_iter().max().unwrap_or_default();
            return refuse(
                format!("{unit} {}", self.origin[bad]),
                format!("the face names vertex {vertex}, counted from 0, of {rows}"),
            );
        }
        if self.triangles.is_empty() {
            return refuse("file", "it has no faces");
        }
        Ok(Surface {
            positions: self.positions,
            triangles: self.triangles,
        })
    }
}
