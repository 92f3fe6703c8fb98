//! Collapsing edges, cheapest first, until every component is one sphere (2016, section 4).

use std::{cmp::Ordering, collections::BinaryHeap};

use rayon::prelude::*;

use super::{
    curvature::importance,
    extent::Extents,
    hierarchy::{Hierarchy, Merge},
    input::Input,
    lanes::{LANES, V4, X4},
    options::Options,
    quadric::Quadrics,
    solve::{self, Edge},
    topology::Topology,
};
use crate::report::Progress;

/// Most edges that collapse at once.
const BATCH: usize = 128;
/// Spheres that there must be for each of them.
const SPHERES_EACH: usize = 64;

/// Frames of solutions that are worth waking a thread for.
const SHARE: usize = 1024;

/// Does the same to all items of `frames` each, on several threads where it pays.
fn shared<T: Sync, R: Send>(
    items: &[T],
    frames: usize,
    work: impl Fn(&T) -> R + Sync + Send,
) -> Vec<R> {
    if items.len() * frames < 2 * SHARE {
        return items.iter().map(work).collect();
    }
    let part = SHARE.div_ceil(frames);
    items.par_iter().with_min_len(part).map(work).collect()
}

/// An edge of the queue; it is out of date when one of its ends has changed.
#[derive(Clone, Copy, PartialEq)]
struct Candidate {
    cost: f64,
    ends: [u32; 2],
    stamps: [u32; 2],
}

impl Eq for Candidate {}

impl Ord for Candidate {
    /// The cheapest is the greatest; equal costs go by their ends, so that the order never depends on threads.
    fn cmp(&self, other: &Self) -> Ordering {
        let costs = other.cost.total_cmp(&self.cost);
        costs.then_with(|| other.ends.cmp(&self.ends))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

struct Collapse<'a> {
    input: &'a Input,
    quadrics: Quadrics,
    extents: Option<Extents>,
    topology: Topology,
    /// Node whose sphere a slot has.
    node: Vec<u32>,
    /// Counts the changes of a slot; `DEAD` where it lost its region.
    stamp: Vec<u32>,
    /// Cost of each slot's sphere.
    cost: Vec<f64>,
    queue: BinaryHeap<Candidate>,
    /// Edges that would turn triangles over.
    turned: Vec<Candidate>,
    /// Centres of the spheres that collapses made: `[collapse][axis][frame]`.
    centres: Vec<f32>,
    merges: Vec<Merge>,
    /// The last batch that touched a slot or its neighbours.
    touched: Vec<u32>,
    round: u32,
}

const DEAD: u32 = u32::MAX;

/// Builds the whole hierarchy.
pub(super) fn build(
    input: Input,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
) -> Hierarchy {
    let importance = (options.curvature > 0.0).then(|| importance(&input, options.curvature));
    let quadrics = Quadrics::cells(&input, importance.as_deref(), options.temporal);
    drop(importance);
    let weight = quadrics.sums.iter().map(|s| s.weight).sum::<f64>() * 0.5;
    let count = input.mesh.positions.len();
    let mut collapse = Collapse {
        quadrics,
        extents: options.spheres.then(|| Extents::cells(&input)),
        topology: Topology::new(&input.mesh),
        node: (0..count as u32).collect(),
        stamp: vec![0; count],
        cost: vec![0.0; count],
        queue: BinaryHeap::new(),
        turned: Vec::new(),
        centres: Vec::with_capacity(count * 3 * input.stride),
        merges: Vec::with_capacity(count),
        touched: vec![0; count],
        round: 0,
        input: &input,
    };
    collapse.start();
    collapse.run(options.inversion, progress);
    progress(Progress {
        stage: "collapsing edges",
        done: count,
        total: count,
    });
    let Collapse {
        centres, merges, ..
    } = collapse;
    Hierarchy::new(input, centres, merges, weight)
}

impl Collapse<'_> {
    /// Centres of a slot's sphere.
    fn sphere(&self, slot: u32) -> &[f32] {
        let node = self.node[slot as usize] as usize;
        let count = self.input.mesh.positions.len();
        match node.checked_sub(count) {
            None => self.input.position(node),
            Some(made) => {
                let size = 3 * self.input.stride;
                &self.centres[made * size..][..size]
            }
        }
    }

    fn edge(&self, u: u32, v: u32) -> Edge<'_> {
        [self.sphere(u), self.sphere(v)]
    }

    fn solve(&self, u: u32, v: u32) -> solve::Sphere {
        let edge = self.edge(u, v);
        let extents = self.extents.as_ref();
        solve::sphere(&self.quadrics, extents, edge, u as usize, v as usize)
    }

    fn candidate(&self, a: u32, b: u32) -> Candidate {
        let ends = [a.min(b), a.max(b)];
        Candidate {
            cost: self.solve(ends[0], ends[1]).cost,
            ends,
            stamps: ends.map(|v| self.stamp[v as usize]),
        }
    }

    fn start(&mut self) {
        let count = self.input.mesh.positions.len() as u32;
        let this = &*self;
        let candidates = (0..count).into_par_iter().flat_map_iter(|u| {
            let later = this.topology.near(u).iter().filter(move |&&v| v > u);
            later.map(move |&v| this.candidate(u, v))
        });
        let candidates: Vec<Candidate> = candidates.collect();
        let finite = candidates.into_iter().filter(|c| c.cost.is_finite());
        self.queue = finite.collect();
    }

    fn run(&mut self, inversion: bool, progress: &(dyn Fn(Progress) + Sync)) {
        let total = self.input.mesh.positions.len();
        let mut watch = inversion;
        loop {
            loop {
                let batch = self.batch();
                if batch.is_empty() {
                    break;
                }
                let before = self.merges.len() / 1024;
                self.step(&batch, watch);
                if self.merges.len() / 1024 > before {
                    progress(Progress {
                        stage: "collapsing edges",
                        done: self.merges.len(),
                        total,
                    });
                }
            }
            // What is left would turn triangles over, however it is done: then that matters no longer.
            self.turned = std::mem::take(&mut self.turned)
                .into_iter()
                .filter(|c| self.current(c))
                .collect();
            if self.turned.is_empty() {
                break;
            }
            self.queue = std::mem::take(&mut self.turned).into();
            watch = false;
        }
    }

    fn current(&self, candidate: &Candidate) -> bool {
        candidate.ends.map(|v| self.stamp[v as usize]) == candidate.stamps
            && candidate.stamps.iter().all(|&s| s != DEAD)
    }

    /// The cheapest edges that do not touch each other's surroundings, for threads to share: few against the spheres that
    /// are left, so that hardly any would have come later had their predecessors' new edges been known; one at coarse levels.
    fn batch(&mut self) -> Vec<Candidate> {
        let left = self.input.mesh.positions.len() - self.merges.len();
        let most = (left / SPHERES_EACH).clamp(1, BATCH);
        let mut batch: Vec<Candidate> = Vec::new();
        self.round += 1;
        while batch.len() < most {
            let Some(candidate) = self.queue.pop() else {
                break;
            };
            if !self.current(&candidate) {
                continue;
            }
            let ends = candidate.ends;
            if ends.iter().any(|&v| self.touched[v as usize] == self.round) {
                self.queue.push(candidate);
                break;
            }
            for v in ends {
                self.touched[v as usize] = self.round;
                for &k in self.topology.near(v) {
                    self.touched[k as usize] = self.round;
                }
            }
            batch.push(candidate);
        }
        batch
    }

    /// Collapses the edges of a batch, but those that turn triangles over where this is watched.
    fn step(&mut self, batch: &[Candidate], watch: bool) {
        let this = &*self;
        let frames = this.input.stride;
        let made = shared(batch, frames, |candidate| this.made(candidate, watch));
        let mut edges = Vec::new();
        for (candidate, made) in batch.iter().zip(made) {
            let Some((sphere, centres)) = made else {
                self.turned.push(*candidate);
                continue;
            };
            self.apply(candidate.ends, &sphere, &centres);
            let u = candidate.ends[0];
            edges.extend(self.topology.near(u).iter().map(|&k| [u, k]));
        }
        let this = &*self;
        let candidates = shared(&edges, frames, |&[u, k]| this.candidate(u, k));
        let finite = candidates.into_iter().filter(|c| c.cost.is_finite());
        self.queue.extend(finite);
    }

    /// The sphere that an edge becomes and its centres; nothing where that turns triangles over.
    fn made(&self, candidate: &Candidate, watch: bool) -> Option<(solve::Sphere, Vec<f32>)> {
        let [u, v] = candidate.ends;
        let sphere = self.solve(u, v);
        let mut made = vec![0.0; 3 * self.input.stride];
        let (edge, a, b) = (self.edge(u, v), u as usize, v as usize);
        solve::centres(&self.quadrics, edge, a, b, &sphere, &mut made);
        (!watch || !self.turns(u, v, &made)).then_some((sphere, made))
    }

    fn apply(&mut self, [u, v]: [u32; 2], sphere: &solve::Sphere, centres: &[f32]) {
        let (a, b) = (u as usize, v as usize);
        let before = self.merges.last().map_or(0.0, |m| m.total);
        self.merges.push(Merge {
            children: [self.node[a], self.node[b]],
            radius: sphere.radius as f32,
            total: before + sphere.cost - (self.cost[a] + self.cost[b]),
        });
        self.centres.extend(centres);
        self.cost[a] = sphere.cost;
        self.node[a] = (self.input.mesh.positions.len() + self.merges.len() - 1) as u32;
        self.quadrics.merge(a, b);
        if let Some(extents) = &mut self.extents {
            extents.merge(a, b);
        }
        self.topology.collapse(u, v);
        self.stamp[a] += 1;
        self.stamp[b] = DEAD;
    }

    /// Whether large triangles turn over in many frames: Σ_f √(A A') n·n' < 0 for one of those that stay.
    fn turns(&self, u: u32, v: u32, made: &[f32]) -> bool {
        let stride = self.input.stride;
        self.topology.moved(u, v).any(|[moving, b, c]| {
            let [p, b, c] = [moving, b, c].map(|k| self.sphere(k));
            let mut sum = X4::default();
            for at in (0..stride).step_by(LANES) {
                let load = |from: &[f32]| V4::widen(from, stride, at);
                let (q, b, c) = (load(made), load(b), load(c));
                let before = (b - load(p)).cross(c - load(p));
                let after = (b - q).cross(c - q);
                let sizes = before.dot(before) * after.dot(after);
                // |n| is twice the area: √(A A') n·n' = N·N' / (2 √(|N| |N'|)).
                let scale = sizes.map(|s| {
                    if s > 0.0 {
                        s.sqrt().sqrt().recip()
                    } else {
                        0.0
                    }
                });
                sum += before.dot(after) * scale;
            }
            sum.sum() < 0.0
        })
    }
}
