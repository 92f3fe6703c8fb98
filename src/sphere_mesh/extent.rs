//! Extents of regions along fixed directions, whose least bounds a sphere's radius (2016, "Radius bound computation").

use super::{input::Input, lanes::LANES};

/// Three axes and a Fibonacci half-sphere.
pub(super) const DIRECTIONS: usize = 33;
/// Share of the width that a radius may have.
const BOUND: f32 = 0.75;

/// Extents of all regions. Frames are `stride` apart.
#[derive(Debug)]
pub(super) struct Extents {
    stride: usize,
    /// `[region][direction][high, low][frame]`.
    ends: Vec<f32>,
    /// Least extent over the frames, `[region][direction]`: the union's is no less than its parts'.
    least: Vec<f32>,
    /// Least extent of a region and where it is.
    width: Vec<Width>,
}

#[derive(Clone, Copy, Debug)]
struct Width {
    width: f32,
    direction: u32,
    frame: u32,
}

/// What [`Extents::cells`] fills for one region.
struct Cell<'a> {
    ends: &'a mut [f32],
    least: &'a mut [f32],
    width: &'a mut Width,
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

impl Extents {
    /// Extents of the barycentric cells: of a vertex, the middles of its edges and the centres of its triangles.
    pub(super) fn cells(input: &Input) -> Self {
        use rayon::prelude::*;
        let (stride, count) = (input.stride, input.mesh.positions.len());
        let size = DIRECTIONS * 2 * stride;
        let mut extents = Self {
            stride,
            ends: vec![0.0; count * size],
            least: vec![0.0; count * DIRECTIONS],
            width: vec![
                Width {
                    width: 0.0,
                    direction: 0,
                    frame: 0
                };
                count
            ],
        };
        let directions = directions();
        let ends = extents.ends.par_chunks_exact_mut(size);
        let least = extents.least.par_chunks_exact_mut(DIRECTIONS);
        let rows = ends.zip(least).zip(&mut extents.width).enumerate();
        rows.for_each_init(Vec::new, |scratch, (v, ((ends, least), width))| {
            let mut cell = Cell { ends, least, width };
            cell.fill(input, v, &directions, scratch);
            cell.measure(stride);
        });
        extents
    }

    fn ends(&self, region: usize) -> &[f32] {
        let size = DIRECTIONS * 2 * self.stride;
        &self.ends[region * size..][..size]
    }

    fn least(&self, region: usize) -> &[f32] {
        &self.least[region * DIRECTIONS..][..DIRECTIONS]
    }

    /// No more than [`Extents::bound`], at no cost.
    pub(super) fn bound_from_below(&self, u: usize, v: usize) -> f64 {
        f64::from(BOUND * self.width[u].width.max(self.width[v].width))
    }

    /// Greatest radius of a sphere for the union of two regions.
    pub(super) fn bound(&self, u: usize, v: usize) -> f64 {
        let (a, b) = (self.ends(u), self.ends(v));
        let stride = self.stride;
        let at = |w: Width| {
            let at = w.direction as usize * 2 * stride + w.frame as usize;
            a[at].max(b[at]) - a[at + stride].min(b[at + stride])
        };
        let mut best = at(self.width[u]).min(at(self.width[v]));
        let least = self.least(u).iter().zip(self.least(v));
        for (direction, (p, q)) in least.enumerate() {
            if p.max(*q) < best {
                let range = direction * 2 * stride..(direction + 1) * 2 * stride;
                best = best.min(union_width(&a[range.clone()], &b[range], stride));
            }
        }
        f64::from(BOUND * best)
    }

    /// `u` becomes the union of both.
    pub(super) fn merge(&mut self, u: usize, v: usize) {
        let (stride, size) = (self.stride, DIRECTIONS * 2 * self.stride);
        let (a, b) = two(&mut self.ends, size, u, v);
        for (a, b) in a
            .chunks_exact_mut(2 * stride)
            .zip(b.chunks_exact(2 * stride))
        {
            let ((ah, al), (bh, bl)) = (a.split_at_mut(stride), b.split_at(stride));
            ah.iter_mut()
                .zip(bh)
                .for_each(|(a, b)| *a = if *a > *b { *a } else { *b });
            al.iter_mut()
                .zip(bl)
                .for_each(|(a, b)| *a = if *a < *b { *a } else { *b });
        }
        let mut cell = Cell {
            ends: a,
            least: &mut self.least[u * DIRECTIONS..][..DIRECTIONS],
            width: &mut self.width[u],
        };
        cell.measure(stride);
    }
}

/// Rows `u` (to change) and `v` of an array of rows of `size`.
pub(super) fn two<T>(rows: &mut [T], size: usize, u: usize, v: usize) -> (&mut [T], &[T]) {
    let (u, v) = (u * size, v * size);
    if u < v {
        let (head, tail) = rows.split_at_mut(v);
        (&mut head[u..u + size], &tail[..size])
    } else {
        let (head, tail) = rows.split_at_mut(u);
        (&mut tail[..size], &head[v..v + size])
    }
}

fn union_width(a: &[f32], b: &[f32], stride: usize) -> f32 {
    let ((ah, al), (bh, bl)) = (a.split_at(stride), b.split_at(stride));
    let mut least = [f32::INFINITY; LANES];
    for at in (0..stride).step_by(LANES) {
        for (lane, least) in least.iter_mut().enumerate() {
            let f = at + lane;
            let high = if ah[f] > bh[f] { ah[f] } else { bh[f] };
            let low = if al[f] < bl[f] { al[f] } else { bl[f] };
            let width = high - low;
            *least = if width < *least { width } else { *least };
        }
    }
    least.into_iter().fold(f32::INFINITY, f32::min)
}

impl Cell<'_> {
    fn fill(
        &mut self,
        input: &Input,
        v: usize,
        directions: &[[f32; 3]; DIRECTIONS],
        scratch: &mut Vec<f32>,
    ) {
        let stride = input.stride;
        // The vertex, the middles, the centres; in a fan every middle belongs to two triangles, and repeats do no harm.
        let points: Vec<&[f32]> = std::iter::once(v)
            .chain(input.mesh.corners.row(v).iter().map(|&u| u as usize))
            .map(|u| input.position(u))
            .collect();
        scratch.clear();
        scratch.resize(points.len() * stride, 0.0);
        for (direction, ends) in directions
            .iter()
            .zip(self.ends.chunks_exact_mut(2 * stride))
        {
            for (point, shadow) in points.iter().zip(scratch.chunks_exact_mut(stride)) {
                let (x, yz) = point.split_at(stride);
                let (y, z) = yz.split_at(stride);
                for f in 0..stride {
                    shadow[f] = direction[0] * x[f] + direction[1] * y[f] + direction[2] * z[f];
                }
            }
            let (here, others) = scratch.split_at(stride);
            let (high, low) = ends.split_at_mut(stride);
            high.copy_from_slice(here);
            low.copy_from_slice(here);
            for pair in others.chunks_exact(2 * stride) {
                let (a, b) = pair.split_at(stride);
                for f in 0..stride {
                    let (p, q) = (0.5 * (here[f] + a[f]), 0.5 * (here[f] + b[f]));
                    let c = (here[f] + a[f] + b[f]) * (1.0 / 3.0);
                    let (pq, qp) = if p > q { (p, q) } else { (q, p) };
                    let h = if c > pq { c } else { pq };
                    let l = if c < qp { c } else { qp };
                    high[f] = if h > high[f] { h } else { high[f] };
                    low[f] = if l < low[f] { l } else { low[f] };
                }
            }
        }
    }

    fn measure(&mut self, stride: usize) {
        let mut width = Width {
            width: f32::INFINITY,
            direction: 0,
            frame: 0,
        };
        for (direction, (ends, least)) in self
            .ends
            .chunks_exact(2 * stride)
            .zip(self.least.iter_mut())
            .enumerate()
        {
            *least = union_width(ends, ends, stride);
            if *least < width.width {
                let (high, low) = ends.split_at(stride);
                let mut pairs = high.iter().zip(low);
                let frame = pairs.position(|(h, l)| h - l <= *least).unwrap_or(0);
                width = Width {
                    width: *least,
                    direction: direction as u32,
                    frame: frame as u32,
                };
            }
        }
        *self.width = width;
    }
}
