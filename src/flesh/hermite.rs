//! Polynomials of one cell between two samples.

use glam::DVec3;

use super::curve::Jet;

/// The quintic that has point, first and second derivative of both ends; coefficients by rising power over the cell from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quintic(pub(super) [DVec3; 6]);

impl Quintic {
    /// Between two samples `step` apart.
    pub(super) fn new(from: &Jet, to: &Jet, step: f64) -> Self {
        let gap = to.point - from.point;
        let (v0, v1) = (step * from.first, step * to.first);
        let (w0, w1) = (step * step * from.second, step * step * to.second);
        Self([
            from.point,
            v0,
            0.5 * w0,
            10.0 * gap - 6.0 * v0 - 4.0 * v1 - 1.5 * w0 + 0.5 * w1,
            -15.0 * gap + 8.0 * v0 + 7.0 * v1 + 1.5 * w0 - w1,
            6.0 * gap - 3.0 * (v0 + v1) - 0.5 * (w0 - w1),
        ])
    }

    /// Point and derivatives, and the third derivative, at a share of the cell.
    #[inline]
    pub(super) fn at(&self, u: f64, step: f64) -> (Jet, DVec3) {
        let [a, b, c, d, e, f] = self.0;
        let rate = 1.0 / step;
        let jet = Jet {
            point: a + u * (b + u * (c + u * (d + u * (e + u * f)))),
            first: rate * (b + u * (2.0 * c + u * (3.0 * d + u * (4.0 * e + u * (5.0 * f))))),
            second: rate * rate * (2.0 * c + u * (6.0 * d + u * (12.0 * e + u * (20.0 * f)))),
        };
        let third = rate * rate * rate * (6.0 * d + u * (24.0 * e + u * (60.0 * f)));
        (jet, third)
    }
}

/// The cubic that has vector and derivative of both ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cubic(pub(super) [DVec3; 4]);

impl Cubic {
    /// Between two samples `step` apart, each with its derivative.
    pub(super) fn new(from: (DVec3, DVec3), to: (DVec3, DVec3), step: f64) -> Self {
        let gap = to.0 - from.0;
        let (v0, v1) = (step * from.1, step * to.1);
        Self([from.0, v0, 3.0 * gap - 2.0 * v0 - v1, -2.0 * gap + v0 + v1])
    }

    /// Vector and derivative at a share of the cell.
    #[inline]
    pub(super) fn at(&self, u: f64, step: f64) -> (DVec3, DVec3) {
        let [a, b, c, d] = self.0;
        (
            a + u * (b + u * (c + u * d)),
            (b + u * (2.0 * c + u * (3.0 * d))) / step,
        )
    }
}
