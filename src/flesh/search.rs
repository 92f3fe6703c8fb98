//! The closest point of a spine: a coarse search over all of it, then Newton.

use glam::DVec3;

use super::{curve::Jet, spine::Spine};

/// Fewest and most points of the coarse search.
const COARSE: (f64, f64) = (16.0, 1024.0);
/// Another part of the spine that is as near, but for this share of the distance, makes a point ambiguous.
const RIVAL: f64 = 0.01;
/// Newton steps, with bisection where they leave their bracket.
const STEPS: usize = 40;

/// Points at even steps along the sampled curve.
#[derive(Clone, Debug)]
pub(super) struct Search {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    begin: f64,
    step: f64,
    closed: bool,
}

/// Closest point on a spine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// Its arc length; before 0 or past the length beyond an open spine's ends.
    pub arc: f64,
    /// Distance to it.
    pub distance: f64,
    /// Whether another part of the spine is as near within a hundredth.
    pub ambiguous: bool,
}

impl Search {
    /// Over samples `step` apart, about two points a radius of curvature.
    pub(super) fn new(samples: &[Jet], step: f64, begin: f64, closed: bool) -> Self {
        let curvature = samples
            .iter()
            .map(|j| j.second.length())
            .fold(0.0, f64::max);
        let total = step * (samples.len() - 1) as f64;
        let wanted = (2.0 * curvature * total).clamp(COARSE.0, COARSE.1);
        let stride = (((samples.len() - 1) as f64 / wanted) as usize).max(1);
        // The last sample is one of the points, or a ring's first.
        let mut rows: Vec<usize> = (0..samples.len() - 1).step_by(stride).collect();
        if !closed {
            rows.push(samples.len() - 1);
        }
        let column = |f: fn(&DVec3) -> f64| rows.iter().map(|r| f(&samples[*r].point)).collect();
        Self {
            x: column(|p| p.x),
            y: column(|p| p.y),
            z: column(|p| p.z),
            begin,
            step: stride as f64 * step,
            closed,
        }
    }
}

impl Spine {
    /// The closest point of the spine; past an open end, the point of the straight line that goes on there, where the end is
    /// nearest. `point` is finite.
    pub fn closest(&self, point: DVec3) -> Closest {
        self.closest_by(point, &mut Vec::new())
    }

    /// The same, with room for the coarse search that is used again.
    pub(super) fn closest_by(&self, point: DVec3, squares: &mut Vec<f64>) -> Closest {
        let search = &self.search;
        let rows = search.x.iter().zip(&search.y).zip(&search.z);
        squares.clear();
        squares.extend(rows.map(|((x, y), z)| {
            let (x, y, z) = (x - point.x, y - point.y, z - point.z);
            x * x + y * y + z * z
        }));
        let least = squares.iter().copied().fold(f64::INFINITY, f64::min);
        // Half a step from a point of the search, nothing is nearer than it by more.
        let bound = (1.0 + RIVAL) * least.sqrt() + 0.5 * search.step;
        let bound = bound * bound;
        let count = squares.len();
        let mut best = (f64::NAN, f64::INFINITY);
        let mut next = (f64::NAN, f64::INFINITY);
        for row in 0..count {
            let here = squares[row];
            if here > bound || !self.lowest(squares, row) {
                continue;
            }
            let found = self.refine(point, row);
            // Two brackets may meet in one point.
            if self.apart(found.0, best.0) < search.step {
                best = if found.1 < best.1 { found } else { best };
            } else if found.1 < best.1 {
                (best, next) = (found, best);
            } else if found.1 < next.1 {
                next = found;
            }
        }
        let ambiguous = next.1 <= (1.0 + RIVAL) * best.1;
        let (arc, distance) = self.past_end(point, best);
        Closest {
            arc,
            distance,
            ambiguous,
        }
    }

    /// Whether a point of the search is no farther than its neighbours.
    #[inline]
    fn lowest(&self, squares: &[f64], row: usize) -> bool {
        let last = squares.len() - 1;
        let (before, after) = match (row, self.search.closed) {
            (0, true) => (squares[last], squares[1]),
            (0, false) => (f64::INFINITY, squares[1]),
            (r, true) if r == last => (squares[r - 1], squares[0]),
            (r, false) if r == last => (squares[r - 1], f64::INFINITY),
            (r, _) => (squares[r - 1], squares[r + 1]),
        };
        squares[row] <= before && squares[row] <= after
    }

    /// Arc length between two places, the short way; infinite where one is none.
    fn apart(&self, a: f64, b: f64) -> f64 {
        let gap = (a - b).abs();
        match (gap.is_nan(), self.closed()) {
            (true, _) => f64::INFINITY,
            (_, true) => gap.min(self.length() - gap),
            (_, false) => gap,
        }
    }

    /// Arc length and distance of the closest point around one of the search.
    fn refine(&self, point: DVec3, row: usize) -> (f64, f64) {
        let search = &self.search;
        let [first, last] = self.reach();
        let mut s = (search.begin + row as f64 * search.step).min(last);
        let (mut low, mut high) = (s - search.step, s + search.step);
        if !search.closed {
            (low, high) = (low.max(first), high.min(last));
        }
        let enough = 1e-14 * (last - first);
        for _ in 0..STEPS {
            let jet = self.jet(s);
            let way = point - jet.point;
            let ahead = way.dot(jet.first);
            match ahead > 0.0 {
                true => low = s,
                false => high = s,
            }
            let slope = 1.0 - way.dot(jet.second);
            let mut next = s + ahead / slope;
            if !(slope > 0.0 && next >= low && next <= high) {
                next = 0.5 * (low + high);
            }
            let moved = (next - s).abs();
            s = next;
            if moved <= enough {
                break;
            }
        }
        let s = match search.closed {
            true => s - self.length() * (s / self.length()).floor(),
            false => s,
        };
        (s, self.jet(s).point.distance(point))
    }

    /// Where an end of the sampled curve is nearest, along the straight line from there on.
    fn past_end(&self, point: DVec3, (arc, distance): (f64, f64)) -> (f64, f64) {
        let [first, last] = self.reach();
        let near = 1e-12 * (last - first);
        let (end, sign) = match (self.closed(), arc - first <= near, last - arc <= near) {
            (false, true, _) => (first, -1.0),
            (false, _, true) => (last, 1.0),
            _ => return (arc, distance),
        };
        let jet = self.jet(end);
        let way = point - jet.point;
        let ahead = way.dot(jet.first);
        match ahead * sign > 0.0 {
            true => (end + ahead, way.reject_from_normalized(jet.first).length()),
            false => (arc, distance),
        }
    }
}
