//! Quintic non-uniform B-splines through points.

use glam::DVec3;

use super::{Jet, Path, chords};

const DEGREE: usize = 5;
/// Points of a ring that are repeated beyond either end of the stretch that is used. What happens at an end of a quintic
/// interpolation dies by a factor of 0.43 a point: nothing is left of it after these.
const WRAP: usize = 48;

/// A B-spline with its first two derivatives, each a B-spline of one degree less on the same knots.
pub(super) struct BSpline {
    degree: usize,
    knots: Vec<f64>,
    controls: [Vec<DVec3>; 3],
    /// Ends and breaks of the stretch in use.
    breaks: Vec<f64>,
}

impl BSpline {
    /// Through all points, from the first to the last.
    pub(super) fn open(points: &[DVec3]) -> Self {
        Self::through(points, 0..points.len())
    }

    /// Through a ring of points, each given once.
    pub(super) fn closed(ring: &[DVec3]) -> Self {
        let count = ring.len();
        let around = WRAP.div_ceil(count) * count;
        let points: Vec<DVec3> = (0..2 * around + count + 1)
            .map(|i| ring[i % count])
            .collect();
        Self::through(&points, around..around + count + 1)
    }

    fn through(points: &[DVec3], used: std::ops::Range<usize>) -> Self {
        let parameters = chords(points);
        let degree = DEGREE.min(points.len() - 1);
        let knots = knots(&parameters, degree);
        let value = interpolate(points, &parameters, &knots, degree);
        let first = derivative(&value, &knots[..], degree);
        let inner = knots.get(1..knots.len() - 1).unwrap_or_default();
        let second = match degree {
            1 => vec![DVec3::ZERO],
            _ => derivative(&first, inner, degree - 1),
        };
        Self {
            degree,
            knots,
            controls: [value, first, second],
            breaks: parameters[used].to_vec(),
        }
    }

    /// The span of the knots that has a parameter.
    fn span(&self, t: f64) -> usize {
        span(&self.knots, self.degree, self.controls[0].len(), t)
    }
}

impl Path for BSpline {
    fn breaks(&self) -> Vec<f64> {
        self.breaks.clone()
    }

    fn jet(&self, t: f64) -> Jet {
        let span = self.span(t);
        let order = |order: usize| match self.degree.checked_sub(order) {
            Some(degree) => de_boor(
                &self.knots[order..],
                &self.controls[order],
                degree,
                span - order,
                t,
            ),
            None => DVec3::ZERO,
        };
        Jet {
            point: order(0),
            first: order(1),
            second: order(2),
        }
    }
}

/// Knots at the parameters of the points, but for the first and last three (not-a-knot); as many as coefficients and degree ask.
fn knots(parameters: &[f64], degree: usize) -> Vec<f64> {
    let count = parameters.len();
    let half = degree.div_ceil(2);
    let (first, last) = (parameters[0], parameters[count - 1]);
    let inner = match count > degree + 1 {
        true => &parameters[half..count - half],
        false => &[],
    };
    let mut knots = vec![first; degree + 1];
    knots.extend(inner);
    knots.extend(vec![last; degree + 1]);
    knots
}

fn span(knots: &[f64], degree: usize, controls: usize, t: f64) -> usize {
    let after = knots[..controls].partition_point(|k| *k <= t);
    after.max(degree + 1) - 1
}

/// De Boor's algorithm.
fn de_boor(knots: &[f64], controls: &[DVec3], degree: usize, span: usize, t: f64) -> DVec3 {
    let mut d = [DVec3::ZERO; DEGREE + 1];
    d[..=degree].copy_from_slice(&controls[span - degree..=span]);
    for r in 1..=degree {
        for j in (r..=degree).rev() {
            let from = knots[j + span - degree];
            let share = (t - from) / (knots[j + 1 + span - r] - from);
            d[j] = (1.0 - share) * d[j - 1] + share * d[j];
        }
    }
    d[degree]
}

/// Coefficients of the derivative.
fn derivative(controls: &[DVec3], knots: &[f64], degree: usize) -> Vec<DVec3> {
    let slope = |(i, pair): (usize, &[DVec3])| {
        degree as f64 * (pair[1] - pair[0]) / (knots[i + degree + 1] - knots[i + 1])
    };
    controls.windows(2).enumerate().map(slope).collect()
}

/// The values of the basis functions that are not zero (Cox and de Boor).
fn basis(knots: &[f64], degree: usize, span: usize, t: f64) -> [f64; DEGREE + 1] {
    let mut values = [0.0; DEGREE + 1];
    values[0] = 1.0;
    for r in 1..=degree {
        let mut carried = 0.0;
        for j in 0..r {
            let (right, left) = (knots[span + j + 1], knots[span + 1 + j - r]);
            let share = values[j] / (right - left);
            values[j] = carried + (right - t) * share;
            carried = (t - left) * share;
        }
        values[r] = carried;
    }
    values
}

/// Coefficients by which the spline meets the points. The matrix is banded and totally positive, so that elimination needs no
/// pivots (de Boor and Pinkus 1977).
fn interpolate(points: &[DVec3], parameters: &[f64], knots: &[f64], degree: usize) -> Vec<DVec3> {
    let count = points.len();
    let mut band = vec![[0.0; 2 * DEGREE + 1]; count];
    for (row, &t) in parameters.iter().enumerate() {
        let span = span(knots, degree, count, t);
        let values = basis(knots, degree, span, t);
        for (j, value) in values.iter().take(degree + 1).enumerate() {
            band[row][span - degree + j + DEGREE - row] = *value;
        }
    }
    let mut x = points.to_vec();
    for pivot in 0..count {
        for row in pivot + 1..count.min(pivot + DEGREE + 1) {
            let factor = band[row][pivot + DEGREE - row] / band[pivot][DEGREE];
            for column in pivot..count.min(pivot + DEGREE + 1) {
                band[row][column + DEGREE - row] -= factor * band[pivot][column + DEGREE - pivot];
            }
            let above = x[pivot];
            x[row] -= factor * above;
        }
    }
    for row in (0..count).rev() {
        for column in row + 1..count.min(row + DEGREE + 1) {
            let known = x[column];
            x[row] -= band[row][column + DEGREE - row] * known;
        }
        x[row] /= band[row][DEGREE];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn helix(t: f64) -> DVec3 {
        DVec3::new(t.cos(), t.sin(), 0.4 * t)
    }

    #[test]
    fn the_spline_meets_its_points_and_has_the_derivatives_it_says() {
        for count in [2, 3, 4, 5, 6, 7, 12, 40] {
            let points: Vec<DVec3> = (0..count).map(|i| helix(0.1 * (i * i) as f64)).collect();
            let spline = BSpline::open(&points);
            for (t, point) in spline.breaks().iter().zip(&points) {
                assert!(spline.jet(*t).point.distance(*point) < 1e-10, "{count}");
            }
            let end = spline.breaks()[count - 1];
            for t in [0.13 * end, 0.5 * end, 0.91 * end] {
                let h = 1e-5 * end;
                let (a, b, c) = (spline.jet(t - h), spline.jet(t), spline.jet(t + h));
                assert!(((c.point - a.point) / (2.0 * h)).distance(b.first) < 1e-6);
                assert!(((c.first - a.first) / (2.0 * h)).distance(b.second) < 1e-5);
            }
        }
    }

    #[test]
    fn a_ring_is_smooth_where_it_closes() {
        let points: Vec<DVec3> = (0..7)
            .map(|i| helix(i as f64 * std::f64::consts::TAU / 7.0))
            .map(|p| p.with_z(0.2 * (3.0 * p.x).sin()))
            .collect();
        let spline = BSpline::closed(&points);
        let breaks = spline.breaks();
        let (a, b) = (spline.jet(breaks[0]), spline.jet(breaks[7]));
        assert!(a.point.distance(b.point) < 1e-12);
        assert!(a.first.distance(b.first) < 1e-12);
        assert!(a.second.distance(b.second) < 1e-12);
    }
}
