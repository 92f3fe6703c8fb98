//! Extents of regions along fixed directions, whose least bounds a sphere's radius (2016, "Radius bound computation").

use multiversion::multiversion;
use rayon::prelude::*;

use super::{
    input::Input,
    lanes::{LANES, Points, least, most, zip},
};

/// A Fibonacci half-sphere: as dense as 32 directions on the whole.
const DIRECTIONS: usize = 16;
/// Share of the width that a radius may have.
const BOUND: f32 = 0.75;

/// Steps from the middle of a frame to its farthest point: a width of twice that is a number still.
const STEPS: f32 = 16_000.0;

/// Coordinates of a point along all directions.
type Shadow = [f32; DIRECTIONS];

/// Greatest coordinates along each direction and against it, in steps from the middle of a frame:
/// `[forwards, backwards][direction]`.
type Ends = [[i16; DIRECTIONS]; 2];

/// What the extents of all regions are kept in, in steps, at half the memory of single precision: `[region][frame]`.
#[derive(Debug)]
pub(super) struct Storage(Vec<Ends>);

impl Storage {
    /// For barycentric cells.
    pub(super) fn new(input: &Input) -> Self {
        let count = input.mesh.positions.len() * input.frames;
        Self(vec![[[0; DIRECTIONS]; 2]; count])
    }
}

/// Extents of a region in all frames.
#[derive(Debug)]
pub(super) struct Extent<'a> {
    /// Length of a step.
    step: f32,
    /// `[frame]`.
    ends: &'a mut [Ends],
    /// Least width over frames and directions.
    width: i16,
}

/// Unit vectors, one of each opposite pair: `[axis][direction]`.
fn directions() -> [[f32; DIRECTIONS]; 3] {
    let mut all = [[0.0; DIRECTIONS]; 3];
    for k in 0..DIRECTIONS {
        let i = k as f64 + 0.5;
        let z = 1.0 - i / DIRECTIONS as f64; // the upper half: an extent has no sign
        let turn = std::f64::consts::PI * (1.0 + 5f64.sqrt()) * i;
        let r = (1.0 - z * z).sqrt();
        for (axis, x) in all.iter_mut().zip([r * turn.cos(), r * turn.sin(), z]) {
            axis[k] = x as f32;
        }
    }
    all
}

/// Extents of the barycentric cells: of a vertex, the middles of its edges and the centres of its triangles.
pub(super) fn cells<'a>(input: &Input, storage: &'a mut Storage) -> Vec<Extent<'a>> {
    let middles = middles(input);
    let step = reach(input, &middles) / STEPS;
    let directions = directions().map(|axis| axis.map(|x| x / step));
    let mut shadows = vec![[0.0; DIRECTIONS]; input.mesh.positions.len()];
    for frame in 0..input.frames {
        let points = shadows.par_iter_mut().enumerate();
        points.for_each(|(v, shadow)| *shadow = cast(input, v, frame, &middles, &directions));
        let rows = storage.0.par_chunks_exact_mut(input.frames).enumerate();
        rows.for_each(|(v, ends)| ends[frame] = cell(v, input.mesh.corners.row(v), &shadows));
    }
    let rows = storage.0.par_chunks_exact_mut(input.frames);
    let extents = rows.map(|ends| {
        let width = least_width(ends, ends);
        Extent { step, ends, width }
    });
    extents.collect()
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
        self.length(self.width.max(other.width))
    }

    /// Greatest radius of a sphere for the union of two regions.
    pub(super) fn bound(&self, other: &Self) -> f64 {
        self.length(least_width(self.ends, other.ends))
    }

    /// Radius for a width.
    fn length(&self, width: i16) -> f64 {
        f64::from(BOUND * self.step * f32::from(width))
    }

    /// Becomes the union of both.
    pub(super) fn merge(&mut self, other: &Self) {
        unite(self.ends, other.ends);
        self.width = least_width(self.ends, self.ends);
    }
}

/// Least width over frames and directions of the union of two regions.
#[multiversion(targets("x86_64+avx2"))]
fn least_width(a: &[Ends], b: &[Ends]) -> i16 {
    let mut least = [i16::MAX; DIRECTIONS];
    for ([af, ab], [bf, bb]) in a.iter().zip(b) {
        for k in 0..DIRECTIONS {
            least[k] = least[k].min(af[k].max(bf[k]) + ab[k].max(bb[k]));
        }
    }
    least.into_iter().fold(i16::MAX, i16::min)
}

#[multiversion(targets("x86_64+avx2"))]
fn unite(to: &mut [Ends], from: &[Ends]) {
    let to = to.as_flattened_mut().as_flattened_mut();
    let from = from.as_flattened().as_flattened();
    to.iter_mut().zip(from).for_each(|(a, b)| *a = (*a).max(*b));
}

/// Coordinates of a vertex in a frame, along directions of the length of a step.
#[multiversion(targets("x86_64+avx2"))]
fn cast(
    input: &Input,
    v: usize,
    frame: usize,
    middles: &[Points],
    directions: &[Shadow; 3],
) -> Shadow {
    let (group, lane) = (frame / LANES, frame % LANES);
    let (points, middle) = (&input.position(v)[group], &middles[group]);
    let [x, y, z] = [0, 1, 2].map(|k| points[k][lane] - middle[k][lane]);
    let mut shadow = [0.0; DIRECTIONS];
    for k in 0..DIRECTIONS {
        shadow[k] = directions[0][k] * x + directions[1][k] * y + directions[2][k] * z;
    }
    shadow
}

/// Extent of the cell of a vertex with these corners in a frame, of the shadows of all vertices.
#[multiversion(targets("x86_64+avx2"))]
fn cell(v: usize, corners: &[u32], shadows: &[Shadow]) -> Ends {
    // Of the greatest neighbour is the greatest middle, of the greatest sum of corners the greatest centre.
    let here = &shadows[v];
    let (mut high, mut low) = (*here, *here);
    let (mut highest, mut lowest) = ([f32::NEG_INFINITY; DIRECTIONS], [f32::INFINITY; DIRECTIONS]);
    for pair in corners.chunks_exact(2) {
        let (a, b) = (&shadows[pair[0] as usize], &shadows[pair[1] as usize]);
        for k in 0..DIRECTIONS {
            let sum = here[k] + a[k] + b[k];
            high[k] = most(high[k], most(a[k], b[k]));
            low[k] = least(low[k], least(a[k], b[k]));
            highest[k] = most(highest[k], sum);
            lowest[k] = least(lowest[k], sum);
        }
    }
    let mut ends = [[0; DIRECTIONS]; 2];
    for k in 0..DIRECTIONS {
        let (up, down) = (0.5 * (here[k] + high[k]), 0.5 * (here[k] + low[k]));
        ends[0][k] = rounded(most(here[k], most(highest[k] * (1.0 / 3.0), up)));
        ends[1][k] = rounded(-least(here[k], least(lowest[k] * (1.0 / 3.0), down)));
    }
    ends
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
        let directions = directions();
        let widths = (0..DIRECTIONS).map(|k| {
            let d = DVec3::from(directions.map(|axis| f64::from(axis[k])));
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
        widths.fold(f64::INFINITY, f64::min)
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
