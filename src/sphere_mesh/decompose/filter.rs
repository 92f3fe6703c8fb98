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
    pub(super) fn apply(&self, skin: &Skin, bones: usize) -> Vec<f64> {
        let mut mass = vec![0.0; self.samples];
        for &(sample, area) in &self.cells {
            mass[sample as usize] += area;
        }
        let mut slots: Vec<Vec<(u32, u32)>> = vec![Vec::new(); bones];
        for v in 0..skin.vertices() {
            for (k, &bone) in skin.bones(v).iter().enumerate() {
                slots[bone as usize].push((v as u32, k as u32));
            }
        }
        let one = |slots: &Vec<(u32, u32)>| self.spread(skin, slots, &mass);
        let spread: Vec<Vec<f64>> = slots.par_iter().map(one).collect();
        let mut filtered = vec![0.0; skin.weights.len()];
        for (slots, spread) in slots.iter().zip(spread) {
            for (&(v, k), weight) in slots.iter().zip(spread) {
                filtered[v as usize * skin.width + k as usize] = weight;
            }
        }
        for (v, row) in filtered.chunks_exact_mut(skin.width).enumerate() {
            let sum: f64 = row.iter().sum();
            if sum > 1e-12 {
                row.iter_mut().for_each(|w| *w /= sum);
            } else {
                row[..skin.bones(v).len()].copy_from_slice(skin.weights(v));
            }
        }
        filtered
    }

    /// One bone's filtered weights, at those vertices that may follow it: `slots` are these and their slots of it.
    fn spread(&self, skin: &Skin, slots: &[(u32, u32)], mass: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.samples];
        for &(v, k) in slots {
            let (sample, area) = self.cells[v as usize];
            sums[sample as usize] += area * skin.weights[v as usize * skin.width + k as usize];
        }
        sums.iter_mut().zip(mass).for_each(|(s, m)| *s /= m);
        let disk = |&(v, _): &(u32, u32)| {
            // Two sums, so that none waits for the other.
            let mut sum = [0.0; 2];
            let disk = &self.disks[v as usize];
            let mut pairs = disk.chunks_exact(2);
            for pair in &mut pairs {
                for (sum, (sample, share)) in sum.iter_mut().zip(pair) {
                    *sum += f64::from(*share) * sums[*sample as usize];
                }
            }
            for (sample, share) in pairs.remainder() {
                sum[0] += f64::from(*share) * sums[*sample as usize];
            }
            sum[0] + sum[1]
        };
        slots.iter().map(disk).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere_mesh::tests::tube;

    #[test]
    fn filtered_weights_are_the_disks_means_shared_out_among_a_vertex_s_own_bones() {
        let (points, triangles) = tube(40, 12, 0.0);
        let mesh = Mesh::new(points, triangles);
        let count = mesh.positions.len();
        let areas: Vec<f64> = (0..count).map(|v| 1.0 + (v % 3) as f64).collect();
        let filter = Filter::new(&mesh, &areas);
        let list = |v: usize| match v % 4 {
            0 => vec![(0, 1.0)],
            1 => vec![(1, 0.25), (2, 0.75)],
            2 => vec![(2, 0.5), (0, 0.5)],
            _ => vec![(2, 0.1), (1, 0.3), (0, 0.6)],
        };
        let lists: Vec<Vec<(u32, f64)>> = (0..count).map(list).collect();
        let skin = Skin::new(3, &lists);
        let filtered = filter.apply(&skin, 3);
        let mut means = vec![([0.0; 3], 0.0); filter.samples];
        for (v, &(sample, area)) in filter.cells.iter().enumerate() {
            let (sums, mass) = &mut means[sample as usize];
            *mass += area;
            skin.pairs(v)
                .for_each(|(b, w)| sums[b as usize] += area * w);
        }
        for v in 0..count {
            let share = |bone: u32| -> f64 {
                let mean = |&(s, share): &(u32, f32)| {
                    let (sums, mass) = &means[s as usize];
                    f64::from(share) * sums[bone as usize] / mass
                };
                filter.disks[v].iter().map(mean).sum()
            };
            let sum: f64 = skin.bones(v).iter().map(|&b| share(b)).sum();
            for (k, &bone) in skin.bones(v).iter().enumerate() {
                let (found, wanted) = (filtered[v * 3 + k], share(bone) / sum);
                assert!((found - wanted).abs() < 1e-9, "{v}: {found} {wanted}");
            }
        }
    }
}
