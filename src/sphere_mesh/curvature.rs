//! Importance of a vertex: total curvature, by cotangent Laplacian and angle deficit (2013, section 5; 2016, section 3).

use std::f64::consts::TAU;

use multiversion::multiversion;
use rayon::prelude::*;

use super::{
    input::Input,
    lanes::{LANES, V4, X4},
};

/// Greatest BBD² (κ₁² + κ₂²) that counts: a ball with 1/224 of the diagonal for its radius. Beyond are slivers.
const SHARPEST: f64 = 1e5;

/// (1 + BBD² (κ₁² + κ₂²))^`power` of each vertex in each frame, `[vertex][group]`.
pub(super) fn importance(input: &Input, power: f64) -> Vec<[f32; LANES]> {
    let mut values = vec![[0.0; LANES]; input.mesh.positions.len() * input.groups];
    let rows = values.par_chunks_exact_mut(input.groups).enumerate();
    rows.for_each(|(v, row)| {
        for (group, values) in row.iter_mut().enumerate() {
            // Lengths are in units of the diagonal already.
            let k = total(input, v, group).map(|k| 1.0 + k.min(SHARPEST));
            let k = match power {
                0.5 => k.map(f64::sqrt), // as by default, and quicker
                _ => k.map(|k| k.powf(power)),
            };
            *values = k.narrow();
        }
    });
    values
}

/// κ₁² + κ₂² = 4 H² - 2 K of a vertex in four frames, at least 0.
#[multiversion(targets("x86_64+avx2"))]
fn total(input: &Input, v: usize, group: usize) -> X4 {
    let point = |v: u32| V4::widen(&input.position(v as usize)[group]);
    let here = point(v as u32);
    let mut laplacian = V4::default();
    let mut area = X4::splat(1e-20);
    let mut angles = Angles::default();
    for corner in input.mesh.corners.row(v).chunks_exact(2) {
        let (a, b) = (point(corner[0]), point(corner[1]));
        let (ea, eb, ab) = (a - here, b - here, b - a);
        let cross = ea.cross(eb);
        let twice = cross.dot(cross).map(|x| x.sqrt() + 1e-20);
        // The edge to a faces the angle at b, the edge to b the angle at a.
        let half = twice.map(|x| 0.5 / x);
        let at_a = X4::default() - ea.dot(ab);
        let at_b = eb.dot(ab);
        laplacian = laplacian + ea.times(at_b * half) + eb.times(at_a * half);
        area += twice * X4::splat(1.0 / 6.0);
        angles.add(ea.dot(eb), twice);
    }
    let mean = laplacian.dot(laplacian).zip(area, |l, a| l / (a * a));
    let gauss = angles.deficit().zip(area, |d, a| 2.0 * d / a);
    mean.zip(gauss, |m, g| (m - g).max(0.0))
}

/// A sum of angles in four frames, as a product of complex numbers: the arc tangent is dear, and one is enough.
struct Angles {
    /// The unit number whose argument the sum has.
    along: X4,
    across: X4,
    /// 2π less for each time that the sum passed π on its way.
    deficit: X4,
}

impl Default for Angles {
    fn default() -> Self {
        Self {
            along: X4::splat(1.0),
            across: X4::default(),
            deficit: X4::splat(TAU),
        }
    }
}

impl Angles {
    /// Adds the angle in [0, π] of two edges with this inner product and this length of their cross product.
    fn add(&mut self, inner: X4, cross: X4) {
        let scale = (inner * inner + cross * cross).map(|x| 1.0 / (x.sqrt() + f64::MIN_POSITIVE));
        let (along, across) = (inner * scale, cross * scale);
        let before = self.across;
        (self.along, self.across) = (
            self.along * along - self.across * across,
            self.along * across + self.across * along,
        );
        // Less than half a turn ended below the axis having begun above it.
        let turn = |before: f64, after: f64| {
            if before >= 0.0 && after < 0.0 {
                TAU
            } else {
                0.0
            }
        };
        self.deficit = self.deficit - before.zip(self.across, turn);
    }

    /// 2π less the sum.
    fn deficit(self) -> X4 {
        self.deficit - self.across.zip(self.along, f64::atan2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_sum_as_they_do_one_by_one() {
        // From next to nothing to several turns, in steps that no fraction of a turn repeats.
        for count in 1..40 {
            let mut angles = Angles::default();
            let mut sum = 0.0;
            for i in 0..count {
                let angle = 3.1 * ((i * i + count) as f64 * 0.618).fract();
                sum += angle;
                let length = 10f64.powi(i % 9 - 8);
                angles.add(
                    X4::splat(length * angle.cos()),
                    X4::splat(length * angle.sin()),
                );
            }
            let error = angles.deficit().0[0] - (TAU - sum);
            assert!(error.abs() < 1e-12, "{count}: {error}");
        }
    }
}
