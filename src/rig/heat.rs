//! Weights by heat diffusion (Baran & Popović 2007, section 4).

use rayon::prelude::*;

use super::{
    Skeleton,
    bones::{Nearest, bones, nearest, nearest_visible},
};
use crate::{
    asset::Influence,
    mesh::{Mesh, TriangleGrid, cotangent, lumped_areas},
};

/// Influences kept a vertex.
const KEPT: usize = 4;
/// Least weight of an edge: obtuse triangles must not cut a component in two.
const LEAST_EDGE: f64 = 1e-3;
/// Least distance to a bone, as a share of the bounding box's diagonal.
const LEAST_DISTANCE: f64 = 1e-4;
/// Least area of a vertex, as a share of the diagonal's square: a vertex without triangle has none.
const LEAST_AREA: f64 = 1e-12;
/// Relative residual at which the solver stops.
const TOLERANCE: f64 = 1e-8;
const MOST_ITERATIONS: usize = 5000;

/// Influences of every vertex in components that hold a `wanted` vertex, greatest first, four at most, sum 1; empty
/// lists elsewhere.
///
/// Solves (-Δ + H) w = H p for each joint, H = 1/d² to the nearest visible bone, p the share of the joint in it. In a
/// component that sees no bone the nearest one stands in.
pub(super) fn heat_weights(
    mesh: &Mesh,
    skeleton: &Skeleton,
    wanted: &[bool],
) -> Vec<Vec<Influence>> {
    let mut components: Vec<Vec<u32>> = vec![Vec::new(); mesh.component_count()];
    let mut chosen = vec![false; components.len()];
    for (v, &c) in mesh.components.iter().enumerate() {
        components[c as usize].push(v as u32);
        chosen[c as usize] |= wanted[v];
    }
    let grid = TriangleGrid::new(mesh);
    let bones = bones(skeleton, &grid);
    let laplacian = Laplacian::new(mesh);
    let mut lists = vec![Vec::new(); mesh.positions.len()];
    for vertices in components.iter().zip(&chosen).filter(|c| *c.1).map(|c| c.0) {
        let mut sources: Vec<Option<Nearest>> = vertices
            .par_iter()
            .map(|&v| nearest_visible(mesh, &grid, &bones, v as usize))
            .collect();
        if sources.iter().all(Option::is_none) {
            let any = |&v: &u32| Some(nearest(mesh, &bones, v as usize));
            sources = vertices.par_iter().map(any).collect();
        }
        for (v, list) in vertices.iter().zip(diffuse(&laplacian, vertices, &sources)) {
            lists[*v as usize] = list;
        }
    }
    lists
}

/// The mesh's stiffness matrix and lumped areas.
struct Laplacian<'a> {
    mesh: &'a Mesh,
    edges: Vec<f32>,
    areas: Vec<f64>,
    /// Diagonal of the bounding box.
    size: f64,
}

impl<'a> Laplacian<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        Self {
            mesh,
            edges: cotangent(mesh),
            areas: lumped_areas(mesh),
            size: f64::from(mesh.diagonal().max(f32::MIN_POSITIVE)),
        }
    }
}

/// Solves a component for all its joints; `vertices` ascend.
fn diffuse(
    laplacian: &Laplacian,
    vertices: &[u32],
    sources: &[Option<Nearest>],
) -> Vec<Vec<Influence>> {
    let heat: Vec<f64> = vertices
        .iter()
        .zip(sources)
        .map(|(&v, source)| {
            let area = laplacian.areas[v as usize].max(LEAST_AREA * laplacian.size.powi(2));
            let distance = |s: &Nearest| s.distance.max(LEAST_DISTANCE * laplacian.size);
            source.as_ref().map_or(0.0, |s| area / distance(s).powi(2))
        })
        .collect();
    let matrix = Matrix::new(laplacian, vertices, &heat);
    let mut joints: Vec<u16> = sources
        .iter()
        .flatten()
        .flat_map(|s| &s.joints)
        .copied()
        .collect();
    joints.sort_unstable();
    joints.dedup();
    let columns: Vec<Vec<f64>> = joints
        .par_iter()
        .map(|joint| {
            let share =
                |s: &Nearest| f64::from(u8::from(s.joints.contains(joint))) / s.joints.len() as f64;
            let right: Vec<f64> = heat
                .iter()
                .zip(sources)
                .map(|(h, source)| h * source.as_ref().map_or(0.0, share))
                .collect();
            matrix.solve(&right)
        })
        .collect();
    (0..vertices.len())
        .map(|i| keep_greatest(joints.iter().zip(&columns).map(|(j, c)| (*j, c[i]))))
        .collect()
}

fn keep_greatest(weights: impl Iterator<Item = (u16, f64)>) -> Vec<Influence> {
    let mut all: Vec<(u16, f64)> = weights.filter(|w| w.1 > 1e-6).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    all.truncate(KEPT);
    let sum: f64 = all.iter().map(|w| w.1).sum();
    all.iter()
        .map(|&(joint, w)| Influence {
            joint,
            weight: (w / sum) as f32,
        })
        .collect()
}

/// Symmetric positive definite matrix: L + diag(heat) over a component's vertices.
struct Matrix {
    offsets: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
    diagonal: Vec<f64>,
}

impl Matrix {
    fn new(laplacian: &Laplacian, vertices: &[u32], heat: &[f64]) -> Self {
        let ring = &laplacian.mesh.one_ring;
        let mut matrix = Self {
            offsets: vec![0],
            columns: Vec::new(),
            values: Vec::new(),
            diagonal: heat.to_vec(),
        };
        for (i, &v) in vertices.iter().enumerate() {
            let start = ring.offsets[v as usize] as usize;
            for (k, u) in ring.row(v as usize).iter().enumerate() {
                let weight = f64::from(laplacian.edges[start + k]).max(LEAST_EDGE);
                // Neighbours are of the same component.
                let column = vertices.partition_point(|x| x < u);
                matrix.columns.push(column as u32);
                matrix.values.push(-weight);
                matrix.diagonal[i] += weight;
            }
            matrix.offsets.push(matrix.columns.len());
        }
        matrix
    }

    fn multiply(&self, x: &[f64], out: &mut [f64]) {
        for (i, y) in out.iter_mut().enumerate() {
            let row = self.offsets[i]..self.offsets[i + 1];
            let off: f64 = row
                .map(|k| self.values[k] * x[self.columns[k] as usize])
                .sum();
            *y = self.diagonal[i] * x[i] + off;
        }
    }

    /// Conjugate gradients with the diagonal as preconditioner (Saad 2003, algorithm 9.1).
    fn solve(&self, right: &[f64]) -> Vec<f64> {
        let precondition =
            |r: &[f64]| -> Vec<f64> { r.iter().zip(&self.diagonal).map(|(r, d)| r / d).collect() };
        let mut x = vec![0.0; right.len()];
        let mut r = right.to_vec();
        let mut z = precondition(&r);
        let mut p = z.clone();
        let mut product = vec![0.0; right.len()];
        let mut rz = dot(&r, &z);
        let goal = TOLERANCE * TOLERANCE * dot(&r, &r);
        for _ in 0..MOST_ITERATIONS {
            if dot(&r, &r) <= goal {
                break;
            }
            self.multiply(&p, &mut product);
            let step = rz / dot(&p, &product);
            for i in 0..x.len() {
                x[i] += step * p[i];
                r[i] -= step * product[i];
            }
            z = precondition(&r);
            let next = dot(&r, &z);
            let turn = next / rz;
            for (p, z) in p.iter_mut().zip(&z) {
                *p = z + turn * *p;
            }
            rz = next;
        }
        x
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
#[path = "heat_tests.rs"]
mod tests;
