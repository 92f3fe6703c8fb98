//! Extents of regions along fixed directions, whose least bounds a sphere's radius (2016, "Radius bound computation").

use multiversion::multiversion;
use rayon::prelude::*;

use super::{
    input::Input,
    lanes::{LANES, Points, least, most, zip},
};

/// Three axes and a Fibonacci half-sphere.
const DIRECTIONS: usize = 33;
/// Share of the width that a radius may have.
const BOUND: f32 = 0.75;

/// Steps from the middle of a frame to its farthest point: a width of twice that is a number still.
const STEPS: f32 = 16_000.0;

/// What the extents of all regions are kept in, in steps and without padding, for they take more memory than all else.
#[derive(Debug)]
pub(super) struct Storage {
    /// `[region][direction][forwards, backwards][frame]`.
    ends: Vec<i16>,
    /// `[region][direction]`.
    least: Vec<i16>,
}

impl Storage {
    /// For barycentric cells.
    pub(super) fn new(input: &Input) -> Self {
        let rows = input.mesh.positions.len() * DIRECTIONS;
        Self {
            ends: vec![0; rows * 2 * input.frames],
            least: vec![0; rows],
        }
    }
}

/// Extents of a region in all frames, in steps.
#[derive(Debug)]
pub(super) struct Extent<'a> {
    frames: usize,
    /// Length of a step.
    step: f32,
    /// Greatest coordinates along each direction and against it, from the middle of the frame:
    /// `[direction][forwards, backwards][frame]`.
    ends: &'a mut [i16],
    /// Least width over the frames along each direction: the union's is no less than its parts'.
    least: &'a mut [i16],
    width: Width,
}

/// Least width of a region and where it is.
#[derive(Clone, Copy, Debug, Default)]
struct Width {
    width: i16,
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
    let frames = input.frames;
    let middles = middles(input);
    let step = reach(input, &middles) / STEPS;
    let ends = storage.ends.chunks_exact_mut(DIRECTIONS * 2 * frames);
    let rows = ends.zip(storage.least.chunks_exact_mut(DIRECTIONS));
    let extents = rows.map(|(ends, least)| Extent {
        frames,
        step,
        ends,
        least,
        width: Width::default(),
    });
    let mut extents: Vec<Extent<'a>> = extents.collect();
    let mut shadows = vec![[0.0; LANES]; input.positions.len()];
    for (k, direction) in directions().iter().enumerate() {
        let direction = direction.map(|x| x / step);
        let points = shadows.par_iter_mut().zip(&input.positions).enumerate();
        points.for_each(|(row, (shadow, points))| {
            let middle = along(&direction, &middles[row % input.groups]);
            *shadow = zip(along(&direction, points), middle, |a, b| a - b);
        });
        let cells = extents.par_iter_mut().enumerate();
        cells.for_each(|(v, extent)| {
            let ends = &mut extent.ends[k * 2 * frames..][..2 * frames];
            cell(input, v, &shadows, ends);
        });
    }
    extents.par_iter_mut().for_each(Extent::measure);
    extents
}

/// Middle of the bounding box of each frame, in groups.
fn middles(input: &Input) -> Vec<Points> {
    let of = |group: usize| {
        let (mut low, mut high) = (input.positions[group], input.positions[group]);
        for points in input.positions[group..].iter().step_by(input.groups) {
            for k in 0..3 {
                low[k] = zip(low[k], points[k], least);
                high[k] = zip(high[k], points[k], most);
            }
        }
        std::array::from_fn(|k| zip(low[k], high[k], |a, b| 0.5 * (a + b)))
    };
    (0..input.groups).into_par_iter().map(of).collect()
}

/// Greatest distance of a point from the middle of its frame.
fn reach(input: &Input, middles: &[Points]) -> f32 {
    let rows = input.positions.par_chunks_exact(input.groups);
    let squares = rows.map(|row| {
        let apart = row.iter().zip(middles).map(|(points, middle)| {
            let square = |k: usize| zip(points[k], middle[k], |a, b| (a - b) * (a - b));
            let all = zip(zip(square(0), square(1), add), square(2), add);
            all.into_iter().fold(0.0, most)
        });
        apart.fold(0.0, most)
    });
    let square = squares.reduce(|| 0.0, most);
    square.sqrt().max(f32::MIN_POSITIVE * STEPS)
}

impl Extent<'_> {
    /// No more than [`Extent::bound`], at no cost.
    pub(super) fn bound_from_below(&self, other: &Self) -> f64 {
        self.length(self.width.width.max(other.width.width))
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
        let least = self.least.iter().zip(other.least.iter());
        for ((a, b), (p, q)) in ends.zip(least) {
            if *p.max(q) < best {
                best = best.min(union_width(a, b));
            }
        }
        self.length(best)
    }

    /// Radius for a width.
    fn length(&self, width: i16) -> f64 {
        f64::from(BOUND * self.step * f32::from(width))
    }

    /// Becomes the union of both.
    pub(super) fn merge(&mut self, other: &Self) {
        for (a, b) in self.ends.iter_mut().zip(other.ends.iter()) {
            *a = (*a).max(*b);
        }
        self.measure();
    }

    /// Finds the least widths.
    fn measure(&mut self) {
        self.width.width = i16::MAX;
        let ends = self.ends.chunks_exact(2 * self.frames);
        for (direction, (ends, least)) in ends.zip(self.least.iter_mut()).enumerate() {
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
fn union_width(a: &[i16], b: &[i16]) -> i16 {
    let ((af, ab), (bf, bb)) = (a.split_at(a.len() / 2), b.split_at(b.len() / 2));
    let forwards = af.iter().zip(bf).map(|(a, b)| *a.max(b));
    let backwards = ab.iter().zip(bb).map(|(a, b)| *a.max(b));
    let widths = forwards.zip(backwards).map(|(a, b)| a + b);
    widths.fold(i16::MAX, i16::min)
}

/// Coordinates of four points along a direction.
fn along(d: &[f32; 3], [x, y, z]: &Points) -> [f32; LANES] {
    std::array::from_fn(|lane| d[0] * x[lane] + d[1] * y[lane] + d[2] * z[lane])
}

/// Extent of a vertex's cell along one direction, `[forwards, backwards][frame]`, of the `shadows` of all vertices.
#[multiversion(targets("x86_64+avx2"))]
fn cell(input: &Input, v: usize, shadows: &[[f32; LANES]], ends: &mut [i16]) {
    let (forwards, backwards) = ends.split_at_mut(input.frames);
    let ends = forwards.chunks_mut(LANES).zip(backwards.chunks_mut(LANES));
    for (group, (forwards, backwards)) in ends.enumerate() {
        let at = |v: usize| shadows[v * input.groups + group];
        let here = at(v);
        // Of the greatest neighbour is the greatest middle, of the greatest sum of corners the greatest centre.
        let (mut high, mut low) = (here, here);
        let (mut highest, mut lowest) = ([f32::NEG_INFINITY; LANES], [f32::INFINITY; LANES]);
        for pair in input.mesh.corners.row(v).chunks_exact(2) {
            let (a, b) = (at(pair[0] as usize), at(pair[1] as usize));
            let sum = zip(zip(here, a, add), b, add);
            high = zip(high, zip(a, b, most), most);
            low = zip(low, zip(a, b, least), least);
            highest = zip(highest, sum, most);
            lowest = zip(lowest, sum, least);
        }
        let end = |corner, sum, most: fn(f32, f32) -> f32| {
            let middle = zip(here, corner, |here, corner| 0.5 * (here + corner));
            let centre = zip(sum, middle, |sum, middle| most(sum * (1.0 / 3.0), middle));
            zip(here, centre, most)
        };
        let (high, low) = (end(high, highest, most), end(low, lowest, least));
        for (to, high) in forwards.iter_mut().zip(high) {
            *to = rounded(high);
        }
        for (to, low) in backwards.iter_mut().zip(low) {
            *to = rounded(-low);
        }
    }
}

/// The nearest whole number, of an end no farther than [`STEPS`]: by cutting a positive number, which is quick.
fn rounded(end: f32) -> i16 {
    ((end + 32_768.5) as i32 - 32_768) as i16
}

fn add(a: f32, b: f32) -> f32 {
    a + b
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::sphere_mesh::tests::bending;
    use glam::{DVec3, Vec3};

    /// Least width of the union of two vertices' cells.
    fn exact(input: &Input, pair: [usize; 2]) -> f64 {
        let place = |v: u32, f: usize| {
            let points = input.position(v as usize)[f / LANES];
            DVec3::from(points.map(|x| f64::from(x[f % LANES])))
        };
        let widths = directions().map(|d| {
            let d = DVec3::from(d.map(f64::from));
            let of_frame = |f: usize| {
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                let mut reach = |p: DVec3| {
                    low = low.min(d.dot(p));
                    high = high.max(d.dot(p));
                };
                for v in pair {
                    let here = place(v as u32, f);
                    reach(here);
                    for corner in input.mesh.corners.row(v).chunks_exact(2) {
                        let (a, b) = (place(corner[0], f), place(corner[1], f));
                        reach(0.5 * (here + a));
                        reach(0.5 * (here + b));
                        reach((here + a + b) / 3.0);
                    }
                }
                high - low
            };
            (0..input.frames)
                .map(of_frame)
                .fold(f64::INFINITY, f64::min)
        });
        widths.into_iter().fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn bounds_are_those_of_double_precision_to_two_steps_however_far_a_sequence_goes() {
        for (frames, way) in [(1, 0.0), (7, 0.0), (8, 300.0)] {
            let mut sequence = bending(frames);
            for (f, points) in sequence.frames.iter_mut().enumerate() {
                points
                    .iter_mut()
                    .for_each(|p| *p += Vec3::X * way * f as f32);
            }
            let input = Input::new(&sequence).unwrap();
            let mut storage = Storage::new(&input);
            let mut extents = cells(&input, &mut storage);
            let step = f64::from(extents[0].step);
            for v in (0..input.mesh.positions.len() - 20).step_by(7) {
                let error = |a: f64, exact: f64| (a / f64::from(BOUND) - exact).abs();
                let pair = [v, v + 13];
                let bound = extents[v].bound(&extents[v + 13]);
                assert!(error(bound, exact(&input, pair)) < 2.0 * step, "{pair:?}");
                assert!(extents[v].bound_from_below(&extents[v + 13]) <= bound);
                // A union is as wide as the two together.
                let (head, tail) = extents.split_at_mut(v + 13);
                head[v].merge(&tail[0]);
                assert!(error(head[v].bound(&head[v]), exact(&input, pair)) < 2.0 * step);
            }
        }
    }
}
