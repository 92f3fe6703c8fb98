//! Welding: rows of the file that share a position become one vertex.

use std::collections::HashMap;

use glam::Vec3;

use super::Mesh;

/// Rows closer than this share of the bounding box's diagonal fall into one cell of the welding lattice.
const QUANTUM: f64 = 1e-7;

/// A welded mesh and where each row went.
#[derive(Clone, Debug, Default)]
pub struct Welded {
    /// Vertices in the order in which their first rows appear; each has the position of that row.
    pub mesh: Mesh,
    /// Welded vertex of each row.
    pub vertex: Vec<u32>,
}

impl Welded {
    /// First row of each welded vertex, ascending.
    pub fn first_rows(&self) -> Vec<u32> {
        let mut rows = Vec::with_capacity(self.mesh.positions.len());
        for (row, &vertex) in self.vertex.iter().enumerate() {
            if vertex as usize == rows.len() {
                rows.push(row as u32);
            }
        }
        rows
    }
}

/// Welds rows whose positions agree after quantising by 1e-7 of the bounding box's diagonal.
///
/// Triangles that lose a corner are dropped; vertices without a triangle are kept. Positions must be finite and
/// triangles in range.
pub fn weld(positions: &[Vec3], triangles: &[[u32; 3]]) -> Welded {
    let (low, high) = positions
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| {
            (low.min(p), high.max(p))
        });
    let diagonal = (high.as_dvec3() - low.as_dvec3()).length();
    let scale = if diagonal > 0.0 {
        (QUANTUM * diagonal).recip()
    } else {
        0.0
    };
    let mut cells: HashMap<[i64; 3], u32> = HashMap::with_capacity(positions.len());
    let mut kept = Vec::new();
    let vertex: Vec<u32> = positions
        .iter()
        .map(|&p| {
            let cell = (p.as_dvec3() - low.as_dvec3()) * scale;
            *cells
                .entry(cell.to_array().map(|x| x.round() as i64))
                .or_insert_with(|| {
                    kept.push(p + Vec3::ZERO); // -0.0 becomes 0.0
                    kept.len() as u32 - 1
                })
        })
        .collect();
    let triangles = triangles
        .iter()
        .map(|t| t.map(|row| vertex[row as usize]))
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    Welded {
        mesh: Mesh::new(kept, triangles),
        vertex,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn seam_rows_become_one_vertex_in_order_of_first_appearance() {
        let p = [
            Vec3::X,
            Vec3::new(-0.0, 0.0, 0.0),
            Vec3::Y,
            Vec3::new(0.0, -0.0, 0.0),
            Vec3::new(1.0 + 1e-8, 0.0, 0.0),
            Vec3::Z,
        ];
        let welded = weld(&p, &[[0, 1, 2], [3, 4, 5], [1, 3, 2]]);
        assert_eq!(welded.vertex, [0, 1, 2, 1, 0, 3]);
        assert_eq!(welded.first_rows(), [0, 1, 2, 5]);
        assert_eq!(welded.mesh.triangles, [[0, 1, 2], [1, 0, 3]]);
        assert!(welded.mesh.positions[1].x.is_sign_positive());
    }

    #[test]
    fn distinct_points_stay_apart_and_lone_vertices_stay() {
        let p = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X * (1.0 + 1e-5)];
        let welded = weld(&p, &[[0, 1, 2]]);
        assert_eq!(welded.mesh.positions.len(), 4);
        assert_eq!(welded.mesh.normals[3], Vec3::ZERO);
        assert_eq!(welded.mesh.components, [0, 0, 0, 1]);
    }

    #[test]
    fn one_point_or_none_is_no_trouble() {
        assert!(weld(&[], &[]).mesh.positions.is_empty());
        let welded = weld(&[Vec3::ONE; 3], &[[0, 1, 2]]);
        assert_eq!(welded.vertex, [0, 0, 0]);
        assert!(welded.mesh.triangles.is_empty());
    }
}
