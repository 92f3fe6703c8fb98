//! Spherical quadrics over all frames (2016, Eqs. 5 to 8), in 3 F + 1 dimensions, block by block.

use rayon::prelude::*;

use super::{
    extent::two,
    input::Input,
    lanes::{LANES, S4, V4, X4},
};

/// Numbers of a frame: M (xx xy xz yy yz zz), N, b.
const BLOCK: usize = 12;

/// What all frames of a region share: W, B and c of Eq. 8.
///
/// c is the sum of w (n·p)²: the printed (N·p)² has the same minimiser but another order in the queue.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pub(super) weight: f64,
    pub(super) offset: f64,
    pub(super) constant: f64,
}

/// Quadrics of all regions, never with the temporal term, which would accumulate.
#[derive(Debug)]
pub(super) struct Quadrics {
    pub(super) stride: usize,
    blocks: Vec<f64>,
    pub(super) sums: Vec<Sums>,
    /// Area σ and first moment σ c of each region and frame (Eq. 11), where temporal coherence is wanted.
    drift: Option<Vec<f64>>,
    /// δ of Eq. 12.
    delta: f64,
}

/// The sum of two regions' quadrics in four frames.
#[derive(Clone, Copy)]
pub(super) struct Block {
    pub(super) m: S4,
    pub(super) n: V4,
    pub(super) b: V4,
    /// Addition to c by the temporal term.
    pub(super) c: X4,
}

impl Quadrics {
    /// Quadrics of the barycentric cells; `importance` is `[vertex][frame]`, and `temporal` the weight of the temporal
    /// term against the mean weight of the planes.
    pub(super) fn cells(input: &Input, importance: Option<&[f32]>, temporal: f64) -> Self {
        let (stride, count) = (input.stride, input.mesh.positions.len());
        let mut quadrics = Self {
            stride,
            blocks: vec![0.0; count * BLOCK * stride],
            sums: vec![Sums::default(); count],
            drift: (temporal > 0.0).then(|| vec![0.0; count * 4 * stride]),
            delta: 0.0,
        };
        let blocks = quadrics.blocks.par_chunks_exact_mut(BLOCK * stride);
        let areas: Vec<f64> = blocks
            .zip(&mut quadrics.sums)
            .enumerate()
            .map(|(v, (block, sums))| cell(input, v, importance, block, sums))
            .collect();
        if let Some(drift) = &mut quadrics.drift {
            let rows = drift.par_chunks_exact_mut(4 * stride).enumerate();
            rows.for_each(|(v, row)| moments(input, v, row));
            let weight: f64 = quadrics.sums.iter().map(|s| s.weight).sum();
            let area: f64 = areas.iter().sum();
            quadrics.delta = temporal * 0.5 * weight / area.max(f64::MIN_POSITIVE);
        }
        quadrics
    }

    fn row(&self, region: usize) -> &[f64] {
        let size = BLOCK * self.stride;
        &self.blocks[region * size..][..size]
    }

    /// The sum of both in the four frames from `at`, the temporal term included.
    #[inline(always)]
    pub(super) fn sum(&self, u: usize, v: usize, at: usize) -> Block {
        let (a, b, stride) = (self.row(u), self.row(v), self.stride);
        let vector = |k: usize| {
            let from = k * stride;
            V4::load(&a[from..], stride, at) + V4::load(&b[from..], stride, at)
        };
        let mut block = Block {
            m: S4::load(a, stride, at) + S4::load(b, stride, at),
            n: vector(6),
            b: vector(9),
            c: X4::default(),
        };
        if let Some(drift) = &self.drift {
            self.attach(&mut block, drift, u, v, at);
        }
        block
    }

    /// Adds Eq. 12.
    fn attach(&self, block: &mut Block, drift: &[f64], u: usize, v: usize, at: usize) {
        let stride = self.stride;
        let row = |region: usize| &drift[region * 4 * stride..][..4 * stride];
        let (a, b) = (row(u), row(v));
        let area = X4::load(a, at) + X4::load(b, at);
        let moment = V4::load(&a[stride..], stride, at) + V4::load(&b[stride..], stride, at);
        let double = X4::splat(2.0 * self.delta);
        for diagonal in [0, 3, 5] {
            block.m.0[diagonal] += area * double;
        }
        block.b = block.b + moment.times(double);
        let square = moment
            .dot(moment)
            .zip(area, |m, a| if a > 0.0 { m / a } else { 0.0 });
        block.c = square * X4::splat(self.delta);
    }

    /// `u` becomes the sum of both.
    pub(super) fn merge(&mut self, u: usize, v: usize) {
        let add = |(a, b): (&mut f64, &f64)| *a += b;
        let (a, b) = two(&mut self.blocks, BLOCK * self.stride, u, v);
        a.iter_mut().zip(b).for_each(add);
        if let Some(drift) = &mut self.drift {
            let (a, b) = two(drift, 4 * self.stride, u, v);
            a.iter_mut().zip(b).for_each(add);
        }
        let b = self.sums[v];
        let a = &mut self.sums[u];
        a.weight += b.weight;
        a.offset += b.offset;
        a.constant += b.constant;
    }
}

/// Fills the quadric of a vertex; answers its area, all frames together.
fn cell(
    input: &Input,
    v: usize,
    importance: Option<&[f32]>,
    block: &mut [f64],
    sums: &mut Sums,
) -> f64 {
    let stride = input.stride;
    let point = |v: u32, at| V4::widen(input.position(v as usize), stride, at);
    let (mut weight, mut offset, mut constant, mut areas) =
        (X4::default(), X4::default(), X4::default(), X4::default());
    for at in (0..stride).step_by(LANES) {
        let here = point(v as u32, at);
        let real = real_frames(input.frames, at);
        let scale = match importance {
            Some(k) => X4::widen(&k[v * stride..], at) * real,
            None => real,
        };
        let mut sum = [X4::default(); BLOCK];
        for corner in input.mesh.corners.row(v).chunks_exact(2) {
            let (a, b) = (point(corner[0], at) - here, point(corner[1], at) - here);
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
        for (k, sum) in sum.iter().enumerate() {
            block[k * stride + at..][..LANES].copy_from_slice(&sum.0);
        }
    }
    *sums = Sums {
        weight: weight.sum(),
        offset: offset.sum(),
        constant: constant.sum(),
    };
    areas.sum()
}

/// 1 for frames that exist.
fn real_frames(frames: usize, at: usize) -> X4 {
    X4(std::array::from_fn(|lane| {
        f64::from(u8::from(at + lane < frames))
    }))
}

/// Area of a vertex's barycentric cell and its moment: thirds of triangles, whose means are 11/18 of the way to the
/// centre of the corner's cell: (22 here + 7 a + 7 b) / 36.
fn moments(input: &Input, v: usize, row: &mut [f64]) {
    let stride = input.stride;
    let point = |v: u32, at| V4::widen(input.position(v as usize), stride, at);
    for at in (0..stride).step_by(LANES) {
        let here = point(v as u32, at);
        let (mut area, mut moment) = (X4::default(), V4::default());
        for corner in input.mesh.corners.row(v).chunks_exact(2) {
            let (a, b) = (point(corner[0], at), point(corner[1], at));
            let cross = (a - here).cross(b - here);
            let third = cross.dot(cross).map(|x| x.sqrt() / 6.0) * real_frames(input.frames, at);
            let mean = here.times(X4::splat(22.0 / 36.0)) + (a + b).times(X4::splat(7.0 / 36.0));
            area += third;
            moment = moment + mean.times(third);
        }
        let rows = [area, moment.0[0], moment.0[1], moment.0[2]];
        for (k, x) in rows.iter().enumerate() {
            row[k * stride + at..][..LANES].copy_from_slice(&x.0);
        }
    }
}
