//! The curve of a spine of joints: the natural quintic spline through points of the joints.
//!
//! Between two knots it is the quintic that has point, first and second derivative of both; where these meet, so do the third and
//! the fourth derivative, and at the ends the second and the third are 0. So curvature is C² along the spline and passes into the
//! straight lines that go on past its ends with its first derivative: what is bent along it is C¹.
//!
//! All of it is linear in the points: a place on the curve has a weight for each of them.

use nalgebra::DMatrix;

/// What is linear in both ends of a piece: coefficients of the two points, first and second derivatives.
type Functional = [f64; 6];

/// A natural quintic spline over given knots.
#[derive(Clone, Debug)]
pub(super) struct Spline {
    /// Parameters of the points, ascending from 0.
    knots: Vec<f64>,
    /// First derivatives at the knots, then second, a column a point.
    rates: DMatrix<f64>,
}

impl Spline {
    /// Over two knots or more, ascending; none where rounding makes the system singular.
    pub(super) fn new(knots: Vec<f64>) -> Option<Self> {
        let count = knots.len();
        let mut system = DMatrix::zeros(2 * count, 2 * count);
        let mut points = DMatrix::zeros(2 * count, count);
        let mut row = 0;
        let mut condition = |terms: &[(usize, Functional, f64)]| {
            for (piece, functional, sign) in terms {
                for (k, end) in [*piece, piece + 1].into_iter().enumerate() {
                    points[(row, end)] -= sign * functional[k];
                    system[(row, end)] += sign * functional[2 + k];
                    system[(row, count + end)] += sign * functional[4 + k];
                }
            }
            row += 1;
        };
        let pieces: Vec<f64> = knots.windows(2).map(|k| k[1] - k[0]).collect();
        let last = pieces.len() - 1;
        for order in [2, 3] {
            condition(&[(0, derivative(order, 0.0, pieces[0]), 1.0)]);
            condition(&[(last, derivative(order, 1.0, pieces[last]), 1.0)]);
        }
        for knot in 1..pieces.len() {
            for order in [3, 4] {
                let [before, after] = [(knot - 1, 1.0), (knot, 0.0)]
                    .map(|(piece, end)| (piece, derivative(order, end, pieces[piece])));
                condition(&[(before.0, before.1, 1.0), (after.0, after.1, -1.0)]);
            }
        }
        let rates = system.lu().solve(&points)?;
        Some(Self { knots, rates })
    }

    /// The parameters of the points.
    pub(super) fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Weights of all points in the curve and its first three derivatives at a parameter between the ends.
    pub(super) fn weights(&self, t: f64) -> Vec<[f64; 4]> {
        let count = self.knots.len();
        let piece = self.knots.partition_point(|k| *k <= t).clamp(1, count - 1) - 1;
        let step = self.knots[piece + 1] - self.knots[piece];
        let u = (t - self.knots[piece]) / step;
        let functionals = [0, 1, 2, 3].map(|order| derivative(order, u, step));
        let weight = |point: usize, f: &Functional| {
            let ends = [piece, piece + 1].into_iter().enumerate();
            ends.map(|(k, end)| {
                let own = if end == point { f[k] } else { 0.0 };
                own + f[2 + k] * self.rates[(end, point)]
                    + f[4 + k] * self.rates[(count + end, point)]
            })
            .sum()
        };
        let weights = |point| std::array::from_fn(|order| weight(point, &functionals[order]));
        (0..count).map(weights).collect()
    }
}

/// A derivative of the quintic at a share `u` of a piece of length `h`.
fn derivative(order: u32, u: f64, h: f64) -> Functional {
    let [v, w] = [h, h * h];
    // Coefficients of the powers of u.
    let powers: [Functional; 6] = [
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, v, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.5 * w, 0.0],
        [-10.0, 10.0, -6.0 * v, -4.0 * v, -1.5 * w, 0.5 * w],
        [15.0, -15.0, 8.0 * v, 7.0 * v, 1.5 * w, -w],
        [-6.0, 6.0, -3.0 * v, -3.0 * v, -0.5 * w, 0.5 * w],
    ];
    let mut sum = [0.0; 6];
    for (power, coefficients) in powers.iter().enumerate().skip(order as usize) {
        let falling: f64 = (0..order as usize).map(|k| (power - k) as f64).product();
        let factor = falling * u.powi((power - order as usize) as i32) / h.powi(order as i32);
        for (slot, coefficient) in sum.iter_mut().zip(coefficients) {
            *slot += factor * coefficient;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const KNOTS: [f64; 5] = [0.0, 0.7, 1.9, 2.4, 4.0];

    /// Derivatives of the spline through some values.
    fn at(spline: &Spline, values: &[f64], t: f64) -> [f64; 4] {
        let weights = spline.weights(t);
        let sum = |order| {
            weights
                .iter()
                .zip(values)
                .map(move |(w, x): (&[f64; 4], _)| w[order] * x)
        };
        [0, 1, 2, 3].map(|order| sum(order).sum())
    }

    #[test]
    fn it_goes_through_its_points_and_is_straight_where_they_are() {
        let spline = Spline::new(KNOTS.to_vec()).unwrap();
        let values = [0.3, -1.0, 2.0, 0.5, 0.9];
        for (t, value) in KNOTS.iter().zip(values) {
            assert!((at(&spline, &values, *t)[0] - value).abs() < 1e-12);
        }
        for k in 0..=40 {
            let t = 0.1 * f64::from(k);
            let [x, v, a, j] = at(&spline, &KNOTS.map(|t| 2.0 * t - 1.0), t);
            assert!((x - (2.0 * t - 1.0)).abs() < 1e-12 && (v - 2.0).abs() < 1e-12);
            assert!(a.abs() < 1e-11 && j.abs() < 1e-10, "{a} {j}");
        }
    }

    #[test]
    fn three_derivatives_are_continuous_and_the_ends_are_straight() {
        let spline = Spline::new(KNOTS.to_vec()).unwrap();
        let values = [0.3, -1.0, 2.0, 0.5, 0.9];
        for t in &KNOTS[1..4] {
            let [before, after] = [t - 1e-9, t + 1e-9].map(|t| at(&spline, &values, t));
            for order in 0..4 {
                let jump = (before[order] - after[order]).abs();
                assert!(jump < 1e-6, "{t} {order}: {jump}");
            }
        }
        for t in [0.0, 4.0] {
            let [_, _, a, j] = at(&spline, &values, t);
            assert!(a.abs() < 1e-10 && j.abs() < 1e-9);
        }
        let h = 1e-5;
        for order in 0..3 {
            let slope = (at(&spline, &values, 1.2 + h)[order]
                - at(&spline, &values, 1.2 - h)[order])
                / (2.0 * h);
            assert!((slope - at(&spline, &values, 1.2)[order + 1]).abs() < 1e-6);
        }
    }

    #[test]
    fn two_points_make_a_line() {
        let spline = Spline::new(vec![0.0, 3.0]).unwrap();
        let [x, v, a, j] = at(&spline, &[1.0, 7.0], 1.5);
        assert!((x - 4.0).abs() < 1e-12 && (v - 2.0).abs() < 1e-12);
        assert!(a.abs() < 1e-12 && j.abs() < 1e-12);
    }
}
