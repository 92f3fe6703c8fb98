//! All levels of a sphere-mesh: a forest of regions, a sphere a node.

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{
    input::Input,
    lanes::{LANES, Points},
    level::Level,
};
use crate::{Error, Result, mesh::Csr};

/// A collapse: two nodes become one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Merge {
    /// Nodes: a vertex, or the number of vertices plus an earlier collapse.
    pub children: [u32; 2],
    /// Radius of the new sphere, in units of the diagonal.
    pub radius: f32,
    /// Cost of all spheres after it.
    pub total: f64,
}

/// The hierarchy of an animated sphere-mesh.
///
/// Level with N spheres: the last N nodes of which none is a part of another. At the number of welded vertices it is the
/// mesh itself with radius 0, at the least it is one sphere a connected component.
#[derive(Clone, Debug, PartialEq)]
pub struct Hierarchy {
    /// Welded vertex of each row of the sequence.
    pub vertex: Vec<u32>,
    /// Welded triangles, none degenerate.
    pub triangles: Vec<[u32; 3]>,
    /// Collapses in their order.
    pub merges: Vec<Merge>,
    /// Frames.
    pub frames: usize,
    /// Welded vertices.
    pub vertices: usize,
    /// Centre of the unit in which spheres are kept.
    pub origin: DVec3,
    /// Unit: the mean over the frames of the bounding box's diagonal, in the sequence's units.
    pub diagonal: f64,
    /// Weight of all planes, which turns a cost into a mean square distance.
    pub weight: f64,
    /// Centres of the vertices and of the collapses' spheres: `[node][axis][frame]`.
    pub(super) centres: Vec<f32>,
}

/// `[axis][frame]` of the points of some groups, without the frames that only fill the last one.
fn unpack(groups: &[Points], row: &mut [f32]) {
    let frames = row.len() / 3;
    for (k, axis) in row.chunks_exact_mut(frames).enumerate() {
        for (to, points) in axis.chunks_mut(LANES).zip(groups) {
            to.copy_from_slice(&points[k][..to.len()]);
        }
    }
}

impl Hierarchy {
    pub(super) fn new(input: Input, made: &[Points], merges: Vec<Merge>, weight: f64) -> Self {
        let vertices = input.mesh.positions.len();
        let mut centres = vec![0.0; (vertices + merges.len()) * 3 * input.frames];
        let nodes = input.positions.par_chunks_exact(input.groups);
        let nodes = nodes.chain(made.par_chunks_exact(input.groups));
        let rows = centres.par_chunks_exact_mut(3 * input.frames);
        rows.zip(nodes).for_each(|(row, node)| unpack(node, row));
        Self {
            vertex: input.vertex,
            triangles: input.mesh.triangles,
            merges,
            frames: input.frames,
            vertices,
            origin: input.origin,
            diagonal: input.diagonal,
            weight,
            centres,
        }
    }

    /// Numbers of spheres that levels can have.
    pub fn range(&self) -> Range<usize> {
        self.vertices - self.merges.len()..self.vertices + 1
    }

    /// Root of the mean square distance between the planes of the mesh, weighted as in the build, and the spheres of the
    /// level with this many, in % of the bounding box's diagonal.
    pub fn error(&self, spheres: usize) -> f64 {
        let collapses = self.vertices.saturating_sub(spheres).min(self.merges.len());
        let total = collapses
            .checked_sub(1)
            .map_or(0.0, |k| self.merges[k].total);
        100.0 * (total.max(0.0) / self.weight.max(f64::MIN_POSITIVE)).sqrt()
    }

    /// Least number of spheres whose [`Hierarchy::error`] is at most `error`.
    pub fn spheres_for(&self, error: f64) -> usize {
        let fine = self.merges.partition_point(|m| {
            let mean = m.total.max(0.0) / self.weight.max(f64::MIN_POSITIVE);
            100.0 * mean.sqrt() <= error
        });
        self.vertices - fine
    }

    /// The level with this many spheres.
    ///
    /// # Errors
    /// [`Error::Argument`] naming the range where there is no such level.
    pub fn level(&self, spheres: usize) -> Result<Level> {
        let range = self.range();
        if !range.contains(&spheres) {
            let reason = format!(
                "{spheres}, but levels have {} (one a component) to {} (one a vertex)",
                range.start,
                range.end - 1
            );
            return Err(Error::argument("spheres", reason));
        }
        Ok(Level::new(self, spheres))
    }

    /// Position of a welded vertex in a frame, in the sequence's units.
    pub fn position(&self, vertex: usize, frame: usize) -> Vec3 {
        self.centre(vertex, frame)
    }

    /// Centre of a node's sphere in a frame, in the sequence's units.
    pub fn centre(&self, node: usize, frame: usize) -> Vec3 {
        let row = self.row(node);
        let scaled = DVec3::from([0, 1, 2].map(|k| f64::from(row[k * self.frames + frame])));
        (self.origin + scaled * self.diagonal).as_vec3()
    }

    /// Centres of a node's sphere in units of the diagonal, `[axis][frame]`.
    pub(super) fn row(&self, node: usize) -> &[f32] {
        &self.centres[node * 3 * self.frames..][..3 * self.frames]
    }

    /// Radius of a node's sphere, in the sequence's units.
    pub fn radius(&self, node: usize) -> f32 {
        let merge = node.checked_sub(self.vertices);
        merge.map_or(0.0, |k| {
            (f64::from(self.merges[k].radius) * self.diagonal) as f32
        })
    }

    /// Welded vertices of each node of a level, for those who work on regions.
    pub fn regions(&self, level: &Level) -> Csr {
        let mut rows = vec![Vec::new(); level.nodes.len()];
        for (vertex, &sphere) in level.labels.iter().enumerate() {
            rows[sphere as usize].push(vertex as u32);
        }
        Csr::from_rows(&rows)
    }
}
