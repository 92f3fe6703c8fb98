//! Welded topology of a triangle mesh and what follows from it.

mod cotangent;
mod grid;
mod heat;
mod mean_value;
mod rings;
mod topology;
mod weld;

use glam::Vec3;

pub use cotangent::{cotangent, lumped_areas};
pub use grid::TriangleGrid;
pub(crate) use heat::{HeatMatrix, Laplacian};
pub use mean_value::mean_value;
pub use rings::rings;
pub use topology::normals;
pub use weld::{Welded, weld};

/// Rows of rows in one flat array: row `i` is `items[offsets[i]..offsets[i + 1]]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Csr {
    /// One more than rows.
    pub offsets: Vec<u32>,
    /// All rows' items.
    pub items: Vec<u32>,
}

impl Csr {
    /// Items of row `i`.
    pub fn row(&self, i: usize) -> &[u32] {
        &self.items[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }

    /// Gathers rows of their own into one flat array.
    pub fn from_rows(rows: &[Vec<u32>]) -> Self {
        let mut offsets = Vec::with_capacity(rows.len() + 1);
        offsets.push(0);
        let mut end = 0;
        for row in rows {
            end += row.len() as u32;
            offsets.push(end);
        }
        Self {
            offsets,
            items: rows.concat(),
        }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// No rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A welded mesh in rest space: no two vertices share a position, no triangle is degenerate.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Rest positions.
    pub positions: Vec<Vec3>,
    /// Area-weighted unit normals; zero where a vertex has no triangle.
    pub normals: Vec<Vec3>,
    /// Triangles as vertex rows.
    pub triangles: Vec<[u32; 3]>,
    /// Neighbours of a vertex, without repetition: in cyclic order on a manifold fan, ascending elsewhere.
    pub one_ring: Csr,
    /// For every vertex the two other corners of each incident triangle, in winding order: `a0 b0 a1 b1 …`.
    pub corners: Csr,
    /// Connected component of a vertex, numbered from 0.
    pub components: Vec<u32>,
    /// Vertex on an open or non-manifold edge.
    pub boundary: Vec<bool>,
}
