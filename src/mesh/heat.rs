//! Heat diffusion over a mesh, from which smooth weights are made (Baran & Popović 2007, section 4).

use super::{Mesh, cotangent, lumped_areas};

/// Least weight of an edge: obtuse triangles must not cut a component in two.
const LEAST_EDGE: f64 = 1e-3;
/// Least distance to a source, as a share of the bounding box's diagonal.
const LEAST_DISTANCE: f64 = 1e-4;
/// Least area of a vertex, as a share of the diagonal's square: a vertex without triangle has none.
const LEAST_AREA: f64 = 1e-12;
/// Relative residual at which the solver stops.
const TOLERANCE: f64 = 1e-8;
const MOST_ITERATIONS: usize = 5000;

/// The mesh's stiffness matrix and lumped areas.
pub(crate) struct Laplacian<'a> {
    mesh: &'a Mesh,
    edges: Vec<f32>,
    areas: Vec<f64>,
    /// Diagonal of the bounding box.
    size: f64,
}

impl<'a> Laplacian<'a> {
    pub(crate) fn new(mesh: &'a Mesh) -> Self {
        Self {
            mesh,
            edges: cotangent(mesh),
            areas: lumped_areas(mesh),
            size: f64::from(mesh.diagonal().max(f32::MIN_POSITIVE)),
        }
    }

    /// H of a vertex at some distance to its source: 1/d², over its area.
    pub(crate) fn heat(&self, vertex: u32, distance: f64) -> f64 {
        let area = self.areas[vertex as usize].max(LEAST_AREA * self.size.powi(2));
        area / distance.max(LEAST_DISTANCE * self.size).powi(2)
    }
}

/// Symmetric positive definite matrix: L + diag(heat) over some vertices; beyond them everything is 0.
pub(crate) struct HeatMatrix {
    offsets: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
    diagonal: Vec<f64>,
}

impl HeatMatrix {
    /// `vertices` ascend.
    pub(crate) fn new(laplacian: &Laplacian, vertices: &[u32], heat: &[f64]) -> Self {
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
                matrix.diagonal[i] += weight;
                if let Ok(column) = vertices.binary_search(u) {
                    matrix.columns.push(column as u32);
                    matrix.values.push(-weight);
                }
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
    pub(crate) fn solve(&self, right: &[f64]) -> Vec<f64> {
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
mod tests {
    use super::*;
    use crate::mesh::weld;
    use glam::Vec3;

    /// A grid of `n` by `n` vertices.
    fn sheet(n: u32) -> Mesh {
        let points = (0..n * n).map(|i| Vec3::new((i % n) as f32, (i / n) as f32, 0.0));
        let corners = (0..n * n).filter(|i| i % n + 1 < n && i / n + 1 < n);
        let cells = corners.flat_map(|i| [[i, i + 1, i + n], [i + 1, i + n + 1, i + n]]);
        let (points, cells): (Vec<Vec3>, Vec<[u32; 3]>) = (points.collect(), cells.collect());
        weld(&points, &cells).mesh
    }

    #[test]
    fn the_matrix_is_solved() {
        let mesh = sheet(20);
        let vertices: Vec<u32> = (0..mesh.positions.len() as u32).collect();
        let heat: Vec<f64> = vertices.iter().map(|v| f64::from(v % 3) * 0.01).collect();
        let matrix = HeatMatrix::new(&Laplacian::new(&mesh), &vertices, &heat);
        let x: Vec<f64> = vertices.iter().map(|v| f64::from(*v).sin()).collect();
        let mut right = vec![0.0; x.len()];
        matrix.multiply(&x, &mut right);
        let solved = matrix.solve(&right);
        let error = x.iter().zip(&solved).map(|(a, b)| (a - b).abs());
        assert!(error.fold(0.0, f64::max) < 1e-5);
    }

    #[test]
    fn some_vertices_are_solved_with_nothing_beyond_them() {
        let mesh = sheet(20);
        let vertices: Vec<u32> = (0..mesh.positions.len() as u32)
            .filter(|v| mesh.positions[*v as usize].x < 9.5)
            .collect();
        let heat: Vec<f64> = vertices.iter().map(|_| 0.01).collect();
        let solved = HeatMatrix::new(&Laplacian::new(&mesh), &vertices, &heat).solve(&heat);
        let at = |x: f32| {
            let here = vertices.iter().zip(&solved);
            let mut here = here.filter(|(v, _)| mesh.positions[**v as usize].x == x);
            here.next().map_or(f64::NAN, |(_, w)| *w)
        };
        assert!(at(9.0) > 0.0 && at(9.0) < at(5.0) && at(5.0) < at(0.0) && at(0.0) < 1.0);
    }
}
