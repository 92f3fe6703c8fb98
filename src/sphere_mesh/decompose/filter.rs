//! Weights filtered over the mesh: a Gaussian over geodesic disks, at a cost that a finer mesh does not raise.

use std::{cmp::Ordering, collections::BinaryHeap};

use rayon::prelude::*;

use super::skin::Skin;
use crate::mesh::Mesh;

/// Standard deviation of the Gaussian, as a share of the diagonal (2016, section 6.2); the disk has three times its radius.
const SIGMA: f64 = 0.03;

/// Samples half a deviation apart stand for the vertices around them; every vertex knows the samples of its disk.
pub(super) struct Filter {
    /// Nearest sample and area of each vertex.
    cells: Vec<(u32, f64)>,
    samples: usize,
    /// Samples and their shares, sum 1, of each vertex.
    disks: Vec<Vec<(u32, f32)>>,
}

impl Filter {
    /// `areas` are the vertices' over all frames; the mesh is in units of the diagonal.
    pub(super) fn new(mesh: &Mesh, areas: &[f64]) -> Self {
        let count = mesh.positions.len();
        let mut nearest = vec![(u32::MAX, f64::INFINITY); count];
        let mut samples = Vec::new();
        let mut walk = Walk::new(count);
        for v in 0..count as u32 {
            if nearest[v as usize].1 > 0.5 * SIGMA {
                for &(u, d) in walk.disk(mesh, v, 0.5 * SIGMA) {
                    if d < nearest[u as usize].1 {
                        nearest[u as usize] = (samples.len() as u32, d);
                    }
                }
                samples.push(v);
            }
        }
        let mut weight = vec![0.0; samples.len()];
        let cells: Vec<(u32, f64)> = nearest.iter().zip(areas).map(|(n, a)| (n.0, *a)).collect();
        cells.iter().for_each(|(s, a)| weight[*s as usize] += a);
        let reach: Vec<Vec<(u32, f64)>> = samples
            .par_iter()
            .map_init(
                || Walk::new(count),
                |walk, &s| walk.disk(mesh, s, 3.0 * SIGMA).to_vec(),
            )
            .collect();
        let mut disks = vec![Vec::new(); count];
        for (s, disk) in reach.iter().enumerate() {
            for &(v, d) in disk {
                let share = weight[s] * (-0.5 * (d / SIGMA).powi(2)).exp();
                disks[v as usize].push((s as u32, share as f32));
            }
        }
        disks.par_iter_mut().for_each(|disk| {
            let sum: f32 = disk.iter().map(|s| s.1).sum();
            disk.iter_mut().for_each(|s| s.1 /= sum);
        });
        Self {
            samples: samples.len(),
            cells,
            disks,
        }
    }

    /// Filtered weights in the slots of `skin`, sum 1 a vertex: what falls to other bones than a vertex's own is shared out.
    pub(super) fn apply(&self, skin: &Skin) -> Vec<f64> {
        let mut sums: Vec<Vec<(u32, f64)>> = vec![Vec::new(); self.samples];
        let mut mass = vec![0.0; self.samples];
        for (v, &(sample, area)) in self.cells.iter().enumerate() {
            mass[sample as usize] += area;
            let sums = &mut sums[sample as usize];
            for (bone, weight) in skin.pairs(v) {
                match sums.iter_mut().find(|s| s.0 == bone) {
                    Some(sum) => sum.1 += area * weight,
                    None => sums.push((bone, area * weight)),
                }
            }
        }
        for (sums, mass) in sums.iter_mut().zip(&mass) {
            sums.iter_mut().for_each(|s| s.1 /= mass);
        }
        let mut filtered = vec![0.0; skin.weights.len()];
        let rows = filtered.par_chunks_mut(skin.width).enumerate();
        rows.for_each(|(v, row)| {
            let bones = skin.bones(v);
            for &(sample, share) in &self.disks[v] {
                for &(bone, weight) in &sums[sample as usize] {
                    if let Some(k) = bones.iter().position(|&b| b == bone) {
                        row[k] += f64::from(share) * weight;
                    }
                }
            }
            let sum: f64 = row.iter().sum();
            if sum > 1e-12 {
                row.iter_mut().for_each(|w| *w /= sum);
            } else {
                row[..bones.len()].copy_from_slice(skin.weights(v));
            }
        });
        filtered
    }
}

/// Distances along the edges from one vertex (Dijkstra), with memory that is used again.
struct Walk {
    distance: Vec<f64>,
    heap: BinaryHeap<Step>,
    found: Vec<(u32, f64)>,
}

#[derive(PartialEq)]
struct Step(f64, u32);

impl Eq for Step {}
impl PartialOrd for Step {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Step {
    /// The nearest comes first out of a heap.
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.total_cmp(&self.0).then(other.1.cmp(&self.1))
    }
}

impl Walk {
    fn new(vertices: usize) -> Self {
        Self {
            distance: vec![f64::INFINITY; vertices],
            heap: BinaryHeap::new(),
            found: Vec::new(),
        }
    }

    /// Vertices within `reach` and their distances.
    fn disk(&mut self, mesh: &Mesh, from: u32, reach: f64) -> &[(u32, f64)] {
        self.found.clear();
        self.distance[from as usize] = 0.0;
        self.heap.push(Step(0.0, from));
        let mut touched = vec![from];
        while let Some(Step(d, v)) = self.heap.pop() {
            if d > self.distance[v as usize] {
                continue;
            }
            self.found.push((v, d));
            let here = mesh.positions[v as usize];
            for &u in mesh.one_ring.row(v as usize) {
                let far = d + f64::from(here.distance(mesh.positions[u as usize]));
                if far <= reach && far < self.distance[u as usize] {
                    self.distance[u as usize] = far;
                    touched.push(u);
                    self.heap.push(Step(far, u));
                }
            }
        }
        touched
            .iter()
            .for_each(|&v| self.distance[v as usize] = f64::INFINITY);
        &self.found
    }
}
