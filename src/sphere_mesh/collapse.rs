//! Collapsing edges, cheapest first, until every component is one sphere (2016, section 4).

use std::{
    cmp::Ordering,
    collections::{BinaryHeap, binary_heap::PeekMut},
};

use rayon::prelude::*;

use super::{
    curvature::importance,
    extent,
    hierarchy::{Hierarchy, Merge},
    input::Input,
    inversion,
    lanes::Points,
    options::Options,
    quadric,
    region::Region,
    rows::Rows,
    solve::{self, Edge},
    topology::{Surroundings, Topology},
};
use crate::report::Progress;

/// Most edges that collapse at once.
const BATCH: usize = 128;
/// Spheres that there must be for each of them.
const SPHERES_EACH: usize = 64;

/// Groups of frames to solve that are worth waking a thread for.
const SHARE: usize = 64;
/// Solutions that a collapse takes as long as, about: its new edges, its centres and the union of its regions.
const SOLUTIONS: usize = 10;

/// Items that a thread should have at least, each of which takes as long as solving `groups`; nothing where one does them all.
fn share(items: usize, groups: usize) -> Option<usize> {
    (items * groups >= 2 * SHARE).then(|| SHARE.div_ceil(groups))
}

/// An edge of the queue; it is out of date when one of its ends has changed. Its sphere is solved again where it collapses: few
/// do, and the queue is the quicker the less there is of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Candidate {
    cost: f64,
    /// The one that has it in its list is the first.
    ends: [u32; 2],
    stamps: [u32; 2],
}

impl Candidate {
    /// Whether neither end has changed since.
    fn current(&self, stamps: &[u32]) -> bool {
        self.ends.map(|v| stamps[v as usize]) == self.stamps
    }

    /// Whether the owner has not changed since.
    fn listed(&self, stamps: &[u32]) -> bool {
        stamps[self.owner()] == self.stamps[0]
    }

    /// The slot that has it in its list.
    fn owner(&self) -> usize {
        self.ends[0] as usize
    }

    /// The ends, the lesser first.
    fn pair(&self) -> [u32; 2] {
        let [a, b] = self.ends;
        [a.min(b), a.max(b)]
    }
}

impl Eq for Candidate {}

impl Ord for Candidate {
    /// The cheapest is the greatest; equal costs go by their ends, so that the order never depends on threads.
    fn cmp(&self, other: &Self) -> Ordering {
        let costs = other.cost.total_cmp(&self.cost);
        costs.then_with(|| other.pair().cmp(&self.pair()))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// One end of an edge.
#[derive(Clone, Copy)]
struct End<'a> {
    slot: u32,
    stamp: u32,
    region: &'a Region<'a>,
    centres: &'a [Points],
}

/// An edge that collapses: the regions at its ends, of which the first becomes the union.
struct Pair<'a> {
    candidate: Candidate,
    regions: [Region<'a>; 2],
    made: Made,
}

/// What an edge becomes.
#[derive(Default)]
struct Made {
    /// Whether it collapses: it does not where that turns triangles over.
    good: bool,
    sphere: solve::Sphere,
    centres: Vec<Points>,
    surroundings: Surroundings,
    /// The edges to its neighbours, cheapest last.
    edges: Vec<Candidate>,
}

struct Collapse<'a> {
    input: &'a Input,
    /// By slot; nothing where a slot lost its region, or where that is being united with another.
    regions: Vec<Option<Region<'a>>>,
    topology: Topology,
    /// Node whose sphere a slot has.
    node: Vec<u32>,
    /// Counts the changes of a slot; `DEAD` where it lost its region.
    stamp: Vec<u32>,
    /// Cost of each slot's sphere.
    cost: Vec<f64>,
    /// The cheapest edge of every slot that has any.
    queue: BinaryHeap<Candidate>,
    /// The others of each slot, cheapest last. An edge is in the list of one end: the one that changed last.
    lists: Rows<Candidate>,
    /// What collapses made, to be filled anew.
    spare: Vec<Made>,
    /// Edges that would turn triangles over.
    turned: Vec<Candidate>,
    /// Centres of the spheres that collapses made: `[collapse][group]`.
    centres: Vec<Points>,
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
    // On a thread of the pool: others join in sooner than when they are asked from outside.
    let (centres, merges, weight) = rayon::scope(|_| collapse(&input, options, progress));
    Hierarchy::new(input, &centres, merges, weight)
}

/// Centres of the spheres that collapses made, the collapses, and the weight of all planes.
fn collapse(
    input: &Input,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
) -> (Vec<Points>, Vec<Merge>, f64) {
    let count = input.mesh.positions.len();
    let mut quadrics = quadric::Storage::new(input, options.temporal > 0.0);
    let importance = (options.curvature > 0.0).then(|| importance(input, options.curvature));
    let quadrics = quadric::cells(
        input,
        importance.as_deref(),
        options.temporal,
        &mut quadrics,
    );
    drop(importance);
    let weight = quadrics.iter().map(|q| q.sums.weight).sum::<f64>() * 0.5;
    let mut extents = options.spheres.then(|| extent::Storage::new(input));
    let extents = extents
        .as_mut()
        .map(|storage| extent::cells(input, storage));
    let mut extents = extents.into_iter().flatten();
    let regions = quadrics.into_iter().map(|quadric| {
        let extent = extents.next();
        Some(Region { quadric, extent })
    });
    let mut collapse = Collapse {
        input,
        regions: regions.collect(),
        topology: Topology::new(&input.mesh),
        node: (0..count as u32).collect(),
        stamp: vec![0; count],
        cost: vec![0.0; count],
        queue: BinaryHeap::new(),
        lists: Rows::with_capacity(count, input.mesh.one_ring.items.len() / 2),
        spare: Vec::new(),
        turned: Vec::new(),
        centres: Vec::with_capacity(count * input.groups),
        merges: Vec::with_capacity(count),
        touched: vec![0; count],
        round: 0,
    };
    collapse.start();
    collapse.run(options.inversion, progress);
    progress(Progress {
        stage: "collapsing edges",
        done: count,
        total: count,
    });
    (collapse.centres, collapse.merges, weight)
}

/// Solves the edge between two ends, in the list of the first; nothing where it has no sphere.
fn candidate(owner: End<'_>, other: End<'_>) -> Option<Candidate> {
    let cost = sphere(owner, other).cost;
    cost.is_finite().then_some(Candidate {
        cost,
        ends: [owner.slot, other.slot],
        stamps: [owner.stamp, other.stamp],
    })
}

/// The sphere of an edge, whichever of its ends comes first.
fn sphere(a: End<'_>, b: End<'_>) -> solve::Sphere {
    let (a, b) = if a.slot < b.slot { (a, b) } else { (b, a) };
    solve::sphere(Edge {
        regions: [a.region, b.region],
        centres: [a.centres, b.centres],
    })
}

impl<'a> Collapse<'a> {
    /// Centres of a slot's sphere.
    fn sphere(&self, slot: u32) -> &[Points] {
        let node = self.node[slot as usize] as usize;
        let count = self.input.mesh.positions.len();
        match node.checked_sub(count) {
            None => self.input.position(node),
            Some(made) => &self.centres[made * self.input.groups..][..self.input.groups],
        }
    }

    /// A slot that has a region.
    fn end(&self, slot: u32) -> Option<End<'_>> {
        Some(End {
            slot,
            stamp: self.stamp[slot as usize],
            region: self.regions[slot as usize].as_ref()?,
            centres: self.sphere(slot),
        })
    }

    fn start(&mut self) {
        let count = self.input.mesh.positions.len() as u32;
        let this = &*self;
        let later = |u: u32| this.topology.near(u).iter().filter(move |&&v| v > u);
        let edges = (0..count).into_par_iter().flat_map_iter(|u| {
            let edges = later(u).map(move |&v| (u, v));
            edges.filter_map(|(u, v)| candidate(this.end(u)?, this.end(v)?))
        });
        let edges: Vec<Candidate> = edges.collect();
        let mut rest = &edges[..];
        for u in 0..count as usize {
            let own = rest.iter().take_while(|e| e.owner() == u).count();
            let (row, after) = rest.split_at(own);
            rest = after;
            self.lists.push(row.iter().copied());
            self.lists.row_mut(u).sort_unstable();
        }
        let cheapest = (0..count as usize).filter_map(|u| self.lists.pop(u));
        self.queue = cheapest.collect();
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
                .filter(|c| c.current(&self.stamp))
                .collect();
            if self.turned.is_empty() {
                break;
            }
            self.queue = std::mem::take(&mut self.turned).into();
            watch = false;
        }
    }

    /// Takes the cheapest edge.
    fn cheapest(&mut self) -> Option<Candidate> {
        loop {
            let candidate = *self.queue.peek()?;
            let current = candidate.current(&self.stamp);
            self.next();
            if current {
                return Some(candidate);
            }
        }
    }

    /// Replaces the first edge of the queue by the next in its list.
    fn next(&mut self) {
        let Some(mut first) = self.queue.peek_mut() else {
            return;
        };
        let owner = first.owner();
        // A list that has been replaced has an edge of its own in the queue.
        let same = first.listed(&self.stamp);
        let next = loop {
            match same.then(|| self.lists.pop(owner)).flatten() {
                Some(next) if !next.current(&self.stamp) => (),
                next => break next,
            }
        };
        match next {
            Some(next) => *first = next,
            None => drop(PeekMut::pop(first)),
        }
    }

    /// The cheapest edges that do not touch each other's surroundings, for threads to share: few against the spheres that
    /// are left, so that hardly any would have come later had their predecessors' new edges been known; one at coarse levels.
    /// What touches them waits for the next batch.
    fn batch(&mut self) -> Vec<Candidate> {
        let left = self.input.mesh.positions.len() - self.merges.len();
        let most = (left / SPHERES_EACH).clamp(1, BATCH);
        let (mut batch, mut aside) = (Vec::with_capacity(most), Vec::new());
        self.round += 1;
        while batch.len() < most && aside.len() <= most {
            let Some(candidate) = self.cheapest() else {
                break;
            };
            let ends = candidate.ends;
            if ends.iter().any(|&v| self.touched[v as usize] == self.round) {
                aside.push(candidate);
                continue;
            }
            for v in ends {
                self.touched[v as usize] = self.round;
                for &k in self.topology.near(v) {
                    self.touched[k as usize] = self.round;
                }
            }
            batch.push(candidate);
        }
        self.queue.extend(aside);
        batch
    }

    /// Collapses the edges of a batch, but those that turn triangles over where this is watched. What one of them changes
    /// none of the others sees.
    fn step(&mut self, batch: &[Candidate], watch: bool) {
        let pairs = batch.iter().filter_map(|&candidate| {
            let [u, v] = candidate
                .pair()
                .map(|slot| self.regions[slot as usize].take());
            Some(Pair {
                candidate,
                regions: [u?, v?],
                made: self.spare.pop().unwrap_or_default(),
            })
        });
        let mut pairs: Vec<Pair<'a>> = pairs.collect();
        let this = &*self;
        match share(pairs.len(), this.input.groups * SOLUTIONS) {
            None => pairs.iter_mut().for_each(|pair| this.make(pair, watch)),
            Some(least) => {
                let pairs = pairs.par_iter_mut().with_min_len(least);
                pairs.for_each(|pair| this.make(pair, watch));
            }
        }
        for pair in pairs {
            self.apply(pair);
        }
    }

    /// Unites the regions of a pair, but not where that turns triangles over.
    fn make(&self, pair: &mut Pair<'a>, watch: bool) {
        let [u, v] = pair.candidate.pair();
        let [a, b] = &mut pair.regions;
        let made = &mut pair.made;
        let edge = Edge {
            regions: [&*a, &*b],
            centres: [self.sphere(u), self.sphere(v)],
        };
        made.sphere = solve::sphere(edge);
        solve::centres(edge, &made.sphere, &mut made.centres);
        made.good = !(watch && self.turns(u, v, &made.centres));
        if !made.good {
            return;
        }
        a.merge(b);
        let here = End {
            slot: u,
            stamp: self.stamp[u as usize] + 1,
            region: &*a,
            centres: &made.centres,
        };
        self.topology.unite(u, v, &mut made.surroundings);
        self.edges(here, &made.surroundings.near, &mut made.edges);
    }

    /// The edges from a region to its neighbours, cheapest last.
    fn edges(&self, here: End<'_>, near: &[u32], edges: &mut Vec<Candidate>) {
        let edge = |&k: &u32| candidate(here, self.end(k)?);
        edges.clear();
        match share(near.len(), self.input.groups) {
            None => edges.extend(near.iter().filter_map(edge)),
            Some(least) => edges.par_extend(near.par_iter().with_min_len(least).filter_map(edge)),
        }
        edges.sort_unstable();
    }

    fn apply(&mut self, pair: Pair<'a>) {
        let [u, v] = pair.candidate.pair();
        let (a, b) = (u as usize, v as usize);
        let [region, other] = pair.regions;
        let made = pair.made;
        self.regions[a] = Some(region);
        if made.good {
            let before = self.merges.last().map_or(0.0, |m| m.total);
            self.merges.push(Merge {
                children: [self.node[a], self.node[b]],
                radius: made.sphere.radius as f32,
                total: before + made.sphere.cost - (self.cost[a] + self.cost[b]),
            });
            self.centres.extend_from_slice(&made.centres);
            self.cost[a] = made.sphere.cost;
            self.node[a] = (self.input.mesh.positions.len() + self.merges.len() - 1) as u32;
            self.topology.collapse(u, v, &made.surroundings);
            self.stamp[a] += 1;
            self.stamp[b] = DEAD;
            self.lists.clear(b);
            self.lists.replace(a, &made.edges);
            self.queue.extend(self.lists.pop(a));
        } else {
            self.regions[b] = Some(other);
            self.turned.push(pair.candidate);
        }
        self.spare.push(made);
    }

    /// Whether large triangles turn over in many frames, of those that stay.
    fn turns(&self, u: u32, v: u32, made: &[Points]) -> bool {
        self.topology.moved(u, v).any(|[moving, b, c]| {
            inversion::turns(self.sphere(moving), made, self.sphere(b), self.sphere(c))
        })
    }
}
