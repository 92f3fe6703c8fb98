//! Extents of regions along fixed directions, whose least bounds a sphere's radius (2016, "Radius bound computation").

use rayon::prelude::*;

use super::{
    input::Input,
    lanes::{LANES, Points},
};

/// Three axes and a Fibonacci half-sphere.
const DIRECTIONS: usize = 33;
/// Share of the width that a radius may have.
const BOUND: f32 = 0.75;

/// What the extents of all regions are kept in: `[region][direction][forwards, backwards][frame]`, without padding, for
/// they take more memory than all else.
#[derive(Debug)]
pub(super) struct Storage(Vec<f32>);

impl Storage {
    /// For barycentric cells.
    pub(super) fn new(input: &Input) -> Self {
        let count = input.mesh.positions.len();
        Self(vec![0.0; count * DIRECTIONS * 2 * input.frames])
    }
}

/// Extents of a region in all frames.
#[derive(Debug)]
pub(super) struct Extent<'a> {
    frames: usize,
    /// Greatest coordinates along each direction and against it: `[direction][forwards, backwards][frame]`.
    ends: &'a mut [f32],
    /// Least width over the frames along each direction: the union's is no less than its parts'.
    least: [f32; DIRECTIONS],
    width: Width,
}

/// Least width of a region and where it is.
#[derive(Clone, Copy, Debug, Default)]
struct Width {
    width: f32,
    direction: u32,
    frame: u32,
}

/// Unit vectors, one of each opposite pair.
fn directions() -> [[f32; 3]; DIRECTIONS] {
    let mut all = [[0.0; 3]; DIRECTIONS];
    let count = (DIRECTIONS - 3) as f64;
    for (i, direction) in all.iter_mut().enumerate() {
        *direction = match i {
            0..3 => std::array::from_fn(|k| if k == i { 1.0 } else { 0.0 }),
            _ => {
                let i = (i - 3) as f64 + 0.5;
                let z = 1.0 - i / count; // the upper half: an extent has no sign
                let turn = std::f64::consts::PI * (1.0 + 5f64.sqrt()) * i;
                let r = (1.0 - z * z).sqrt();
                [r * turn.cos(), r * turn.sin(), z].map(|x| x as f32)
            }
        };
    }
    all
}

/// Extents of the barycentric cells: of a vertex, the middles of its edges and the centres of its triangles.
pub(super) fn cells<'a>(input: &Input, storage: &'a mut Storage) -> Vec<Extent<'a>> {
    let (frames, directions) = (input.frames, directions());
    let rows = storage.0.par_chunks_exact_mut(DIRECTIONS * 2 * frames);
    let cells = rows.enumerate().map_init(Vec::new, |shadows, (v, ends)| {
        for (direction, ends) in directions.iter().zip(ends.chunks_exact_mut(2 * frames)) {
            let (forwards, backwards) = ends.split_at_mut(frames);
            cell(input, v, direction, shadows, forwards, backwards);
        }
        let mut extent = Extent {
            frames,
            ends,
            least: [0.0; DIRECTIONS],
            width: Width::default(),
        };
        extent.measure();
        extent
    });
    cells.collect()
}

impl Extent<'_> {
    /// No more than [`Extent::bound`], at no cost.
    pub(super) fn bound_from_below(&self, other: &Self) -> f64 {
        f64::from(BOUND * self.width.width.max(other.width.width))
    }

    /// Greatest radius of a sphere for the union of two regions.
    pub(super) fn bound(&self, other: &Self) -> f64 {
        let size = 2 * self.frames;
        let at = |w: Width| {
            let forwards = w.direction as usize * size + w.frame as usize;
            let backwards = forwards + self.frames;
            let end = |at: usize| self.ends[at].max(other.ends[at]);
            end(forwards) + end(backwards)
        };
        let mut best = at(self.width).min(at(other.width));
        let ends = self
            .ends
            .chunks_exact(size)
            .zip(other.ends.chunks_exact(size));
        let least = self.least.iter().zip(&other.least);
        for ((a, b), (p, q)) in ends.zip(least) {
            if p.max(*q) < best {
                best = best.min(union_width(a, b));
            }
        }
        f64::from(BOUND * best)
    }

    /// Becomes the union of both.
    pub(super) fn merge(&mut self, other: &Self) {
        for (a, b) in self.ends.iter_mut().zip(other.ends.iter()) {
            *a = if *a > *b { *a } else { *b };
        }
        self.measure();
    }

    /// Finds the least widths.
    fn measure(&mut self) {
        self.width.width = f32::INFINITY;
        let ends = self.ends.chunks_exact(2 * self.frames);
        for (direction, (ends, least)) in ends.zip(&mut self.least).enumerate() {
            *least = union_width(ends, ends);
            if *least < self.width.width {
                let (forwards, backwards) = ends.split_at(self.frames);
                let mut pairs = forwards.iter().zip(backwards);
                let frame = pairs.position(|(a, b)| a + b <= *least).unwrap_or(0);
                self.width = Width {
                    width: *least,
                    direction: direction as u32,
                    frame: frame as u32,
                };
            }
        }
    }
}

/// Least width over the frames of the union of two regions along one direction, each `[forwards, backwards][frame]`.
fn union_width(a: &[f32], b: &[f32]) -> f32 {
    let (af, ab) = a.split_at(a.len() / 2);
    let (bf, bb) = b.split_at(b.len() / 2);
    let width = |f: usize| {
        let forwards = if af[f] > bf[f] { af[f] } else { bf[f] };
        let backwards = if ab[f] > bb[f] { ab[f] } else { bb[f] };
        forwards + backwards
    };
    let least = |a: f32, b: f32| if a < b { a } else { b };
    let frames = af.len();
    let whole = frames - frames % LANES;
    let mut lanes = [f32::INFINITY; LANES];
    for at in (0..whole).step_by(LANES) {
        for (lane, old) in lanes.iter_mut().enumerate() {
            *old = least(width(at + lane), *old);
        }
    }
    let rest = (whole..frames).map(width);
    rest.chain(lanes).fold(f32::INFINITY, least)
}

/// Extent of a vertex's cell along one direction and against it.
fn cell(
    input: &Input,
    v: usize,
    direction: &[f32; 3],
    shadows: &mut Vec<f32>,
    forwards: &mut [f32],
    backwards: &mut [f32],
) {
    // The vertex, the middles, the centres; in a fan every middle belongs to two triangles, and repeats do no harm.
    let others = input.mesh.corners.row(v).iter().map(|&u| u as usize);
    shadows.clear();
    for vertex in std::iter::once(v).chain(others) {
        for points in input.position(vertex) {
            shadows.extend_from_slice(&shadow(direction, points));
        }
    }
    let (frames, stride) = (input.frames, input.groups * LANES);
    let (here, others) = shadows.split_at(stride);
    let here = &here[..frames];
    forwards.copy_from_slice(here);
    backwards.copy_from_slice(here);
    for pair in others.chunks_exact(2 * stride) {
        let (a, b) = pair.split_at(stride);
        let (a, b) = (&a[..frames], &b[..frames]);
        for f in 0..frames {
            let (p, q) = (0.5 * (here[f] + a[f]), 0.5 * (here[f] + b[f]));
            let c = (here[f] + a[f] + b[f]) * (1.0 / 3.0);
            let (pq, qp) = if p > q { (p, q) } else { (q, p) };
            let h = if c > pq { c } else { pq };
            let l = if c < qp { c } else { qp };
            forwards[f] = if h > forwards[f] { h } else { forwards[f] };
            backwards[f] = if l < backwards[f] { l } else { backwards[f] };
        }
    }
    backwards.iter_mut().for_each(|x| *x = -*x);
}

/// Coordinates of four points along a direction.
fn shadow(d: &[f32; 3], [x, y, z]: &Points) -> [f32; LANES] {
    std::array::from_fn(|lane| d[0] * x[lane] + d[1] * y[lane] + d[2] * z[lane])
}
