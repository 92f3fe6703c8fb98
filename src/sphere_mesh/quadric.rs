//! Spherical quadrics over all frames (2016, Eqs. 5 to 8), in 3 F + 1 dimensions, block by block.

use multiversion::multiversion;
use rayon::prelude::*;

use super::{
    input::Input,
    lanes::{LANES, Row, S4, V4, X4},
};

/// M (xx xy xz yy yz zz), N and b of four frames.
type Block = [Row; 12];

/// Area σ and first moment σ c of four frames (Eq. 11).
type Drift = [Row; 4];

/// What all frames of a region share: W, B and c of Eq. 8.
///
/// c is the sum of w (n·p)²: the printed (N·p)² has the same minimiser but another order in the queue.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pub(super) weight: f64,
    pub(super) offset: f64,
    pub(super) constant: f64,
}

/// What the quadrics of all regions are kept in, `[region][group]`.
#[derive(Debug)]
pub(super) struct Storage {
    blocks: Vec<Block>,
    /// Where temporal coherence is wanted, and empty otherwise.
    drifts: Vec<Drift>,
}

impl Storage {
    /// For barycentric cells; `temporal` says whether temporal coherence is wanted.
    pub(super) fn new(input: &Input, temporal: bool) -> Self {
        let count = input.positions.len();
        Self {
            blocks: vec![[[0.0; LANES]; 12]; count],
            drifts: vec![[[0.0; LANES]; 4]; if temporal { count } else { 0 }],
        }
    }
}

/// The quadric of a region, without the temporal term, which would accumulate.
#[derive(Debug)]
pub(super) struct Quadric<'a> {
    blocks: &'a mut [Block],
    drifts: &'a mut [Drift],
    pub(super) sums: Sums,
    /// δ of Eq. 12.
    delta: f64,
}

/// The sum of two regions' quadrics in four frames.
#[derive(Clone, Copy)]
pub(super) struct Sum {
    pub(super) m: S4,
    pub(super) n: V4,
    pub(super) b: V4,
    /// Addition to c by the temporal term.
    pub(super) c: X4,
}

/// Quadrics of the barycentric cells; `importance` is `[vertex][group]`, and `temporal` the weight of the temporal term
/// against the mean weight of the planes.
pub(super) fn cells<'a>(
    input: &Input,
    importance: Option<&[[f32; LANES]]>,
    temporal: f64,
    storage: &'a mut Storage,
) -> Vec<Quadric<'a>> {
    let groups = input.groups;
    let blocks = storage.blocks.par_chunks_exact_mut(groups).enumerate();
    let cells = blocks.map(|(v, blocks)| {
        let (sums, area) = cell(input, v, importance, blocks);
        let quadric = Quadric {
            blocks,
            drifts: &mut [],
            sums,
            delta: 0.0,
        };
        (quadric, area)
    });
    let (mut quadrics, areas): (Vec<_>, Vec<f64>) = cells.unzip();
    if temporal > 0.0 {
        let weight: f64 = quadrics.iter().map(|q| q.sums.weight).sum();
        let area: f64 = areas.iter().sum();
        let delta = temporal * 0.5 * weight / area.max(f64::MIN_POSITIVE);
        let drifts = storage.drifts.par_chunks_exact_mut(groups);
        let rows = drifts.zip(&mut quadrics).enumerate();
        rows.for_each(|(v, (drifts, quadric))| {
            moments(input, v, drifts);
            quadric.drifts = drifts;
            quadric.delta = delta;
        });
    }
    quadrics
}

impl Quadric<'_> {
    /// Groups of four frames.
    pub(super) fn groups(&self) -> usize {
        self.blocks.len()
    }

    /// The sum of both in the four frames of a group, the temporal term included.
    #[inline(always)]
    pub(super) fn sum(&self, other: &Self, group: usize) -> Sum {
        let m = |[a, b, c, d, e, f, ..]: &Block| S4::new([*a, *b, *c, *d, *e, *f]);
        let n = |[.., x, y, z, _, _, _]: &Block| V4::new([*x, *y, *z]);
        let b = |[.., x, y, z]: &Block| V4::new([*x, *y, *z]);
        let (p, q) = (&self.blocks[group], &other.blocks[group]);
        let mut sum = Sum {
            m: m(p) + m(q),
            n: n(p) + n(q),
            b: b(p) + b(q),
            c: X4::default(),
        };
        if !self.drifts.is_empty() {
            sum.attach(&self.drifts[group], &other.drifts[group], self.delta);
        }
        sum
    }

    /// Becomes the sum of both.
    pub(super) fn merge(&mut self, other: &Self) {
        let blocks = self.blocks.as_flattened_mut().as_flattened_mut();
        add(blocks, other.blocks.as_flattened().as_flattened());
        let drifts = self.drifts.as_flattened_mut().as_flattened_mut();
        add(drifts, other.drifts.as_flattened().as_flattened());
        self.sums.weight += other.sums.weight;
        self.sums.offset += other.sums.offset;
        self.sums.constant += other.sums.constant;
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn add(to: &mut [f64], from: &[f64]) {
    to.iter_mut().zip(from).for_each(|(a, b)| *a += b);
}

impl Sum {
    /// Adds Eq. 12.
    fn attach(&mut self, p: &Drift, q: &Drift, delta: f64) {
        let moment = |[_, x, y, z]: &Drift| V4::new([*x, *y, *z]);
        let (area, moment) = (X4(p[0]) + X4(q[0]), moment(p) + moment(q));
        let double = X4::splat(2.0 * delta);
        for diagonal in [0, 3, 5] {
            self.m.0[diagonal] += area * double;
        }
        self.b = self.b + moment.times(double);
        let square = moment
            .dot(moment)
            .zip(area, |m, a| if a > 0.0 { m / a } else { 0.0 });
        self.c = square * X4::splat(delta);
    }
}

/// Fills the quadric of a vertex; answers what its frames share and its area, all frames together.
#[multiversion(targets("x86_64+avx2"))]
fn cell(
    input: &Input,
    v: usize,
    importance: Option<&[[f32; LANES]]>,
    blocks: &mut [Block],
) -> (Sums, f64) {
    let (mut weight, mut offset, mut constant, mut areas) =
        (X4::default(), X4::default(), X4::default(), X4::default());
    for (group, block) in blocks.iter_mut().enumerate() {
        let point = |v: u32| V4::widen(&input.position(v as usize)[group]);
        let here = point(v as u32);
        let real = real_frames(input.frames, group);
        let scale = match importance {
            Some(k) => X4::widen(k[v * input.groups + group]) * real,
            None => real,
        };
        let mut sum = [X4::default(); 12];
        for corner in input.mesh.corners.row(v).chunks_exact(2) {
            let (a, b) = (point(corner[0]) - here, point(corner[1]) - here);
            let cross = a.cross(b);
            let twice = cross.dot(cross).map(f64::sqrt);
            let n = cross.times(twice.map(|x| if x > 1e-20 { 1.0 / x } else { 0.0 }));
            // A third of the area; every point of the triangle has the same distance to a sphere's centre along n.
            let third = twice * X4::splat(1.0 / 6.0);
            let w = third * scale;
            let double = w + w;
            let height = n.dot(here);
            let big = n.times(double);
            let [x, y, z] = n.0;
            let terms = [
                big.0[0] * x,
                big.0[0] * y,
                big.0[0] * z,
                big.0[1] * y,
                big.0[1] * z,
                big.0[2] * z,
                big.0[0],
                big.0[1],
                big.0[2],
                big.0[0] * height,
                big.0[1] * height,
                big.0[2] * height,
            ];
            for (sum, term) in sum.iter_mut().zip(terms) {
                *sum += term;
            }
            weight += double;
            offset += double * height;
            constant += w * height * height;
            areas += third * real;
        }
        *block = sum.map(|sum| sum.0);
    }
    let sums = Sums {
        weight: weight.sum(),
        offset: offset.sum(),
        constant: constant.sum(),
    };
    (sums, areas.sum())
}

/// 1 for frames that exist.
fn real_frames(frames: usize, group: usize) -> X4 {
    X4(std::array::from_fn(|lane| {
        f64::from(u8::from(group * LANES + lane < frames))
    }))
}

/// Area of a vertex's barycentric cell and its moment: thirds of triangles, whose means are 11/18 of the way to the
/// centre of the corner's cell: (22 here + 7 a + 7 b) / 36.
#[multiversion(targets("x86_64+avx2"))]
fn moments(input: &Input, v: usize, drifts: &mut [Drift]) {
    for (group, drift) in drifts.iter_mut().enumerate() {
        let point = |v: u32| V4::widen(&input.position(v as usize)[group]);
        let here = point(v as u32);
        let (mut area, mut moment) = (X4::default(), V4::default());
        for corner in input.mesh.corners.row(v).chunks_exact(2) {
            let (a, b) = (point(corner[0]), point(corner[1]));
            let cross = (a - here).cross(b - here);
            let third = cross.dot(cross).map(|x| x.sqrt() / 6.0) * real_frames(input.frames, group);
            let mean = here.times(X4::splat(22.0 / 36.0)) + (a + b).times(X4::splat(7.0 / 36.0));
            area += third;
            moment = moment + mean.times(third);
        }
        let [x, y, z] = moment.0;
        *drift = [area.0, x.0, y.0, z.0];
    }
}
