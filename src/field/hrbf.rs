//! Hermite radial basis functions: solve and evaluate (2013, Eq. 1 with φ(t) = t³).

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

/// Hermite radial basis function d(x) = Σ λ t³ + 3 t (β·δ), in coordinates `(x - origin) / scale` (Eq. 1, φ = t³).
#[derive(Clone, Debug, Default)]
pub struct Hrbf {
    /// Centre of the part in rest space.
    pub origin: DVec3,
    /// Size of the part.
    pub scale: f64,
    /// Scaled centres.
    pub centers: Vec<DVec3>,
    /// λ a centre.
    pub lambda: Vec<f64>,
    /// β a centre.
    pub beta: Vec<DVec3>,
}

/// What the function has to be at a centre, in rest space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constraint {
    pub(super) position: DVec3,
    /// d there; 0 on the surface.
    pub(super) value: f64,
    /// ∇d there, unit.
    pub(super) normal: DVec3,
}

/// Greatest error of the solved system, in scaled units, that is taken as solved.
const RESIDUAL: f64 = 1e-6;

impl Hrbf {
    /// Solves the 4m × 4m system d(v) = value, ∇d(v) = normal; `None` where it is singular or centres coincide.
    pub(super) fn solve(constraints: &[Constraint]) -> Option<Self> {
        let origin =
            constraints.iter().map(|c| c.position).sum::<DVec3>() / constraints.len() as f64;
        let scale = constraints
            .iter()
            .map(|c| c.position.distance(origin))
            .fold(0.0, f64::max);
        if !(scale > 0.0 && scale.is_finite()) {
            return None;
        }
        let centers: Vec<DVec3> = constraints
            .iter()
            .map(|c| (c.position - origin) / scale)
            .collect();
        let matrix = matrix(&centers);
        let right = DVector::from_iterator(
            4 * centers.len(),
            constraints
                .iter()
                .flat_map(|c| [c.value / scale, c.normal.x, c.normal.y, c.normal.z]),
        );
        let solution = matrix.clone().lu().solve(&right)?;
        let residual = (matrix * &solution - right).amax();
        // NaN fails the comparison.
        (residual < RESIDUAL).then(|| Self {
            origin,
            scale,
            centers,
            lambda: solution.iter().step_by(4).copied().collect(),
            beta: solution
                .as_slice()
                .chunks_exact(4)
                .map(|c| DVec3::new(c[1], c[2], c[3]))
                .collect(),
        })
    }

    /// d and ∇d at a point of rest space, d in rest units.
    ///
    /// ∇d = Σ 3 λ t δ + 3 t β + 3 (β·δ) δ / t, whose last term is 0 at a centre.
    pub fn evaluate(&self, rest: DVec3) -> (f64, DVec3) {
        let x = (rest - self.origin) / self.scale;
        let (mut value, mut gradient) = (0.0, DVec3::ZERO);
        for ((center, lambda), beta) in self.centers.iter().zip(&self.lambda).zip(&self.beta) {
            let delta = x - center;
            let t = delta.length();
            let along = beta.dot(delta);
            value += t * (lambda * t * t + 3.0 * along);
            let radial = if t > 0.0 { along / t } else { 0.0 };
            gradient += 3.0 * ((lambda * t + radial) * delta + t * beta);
        }
        (value * self.scale, gradient)
    }
}

/// The system's matrix: a 4 × 4 block a pair of centres, 0 on the diagonal.
fn matrix(centers: &[DVec3]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(4 * centers.len(), 4 * centers.len());
    for (k, center) in centers.iter().enumerate() {
        for (j, at) in centers.iter().enumerate() {
            let delta = at - center;
            let t = delta.length();
            if t == 0.0 {
                continue;
            }
            matrix[(4 * j, 4 * k)] = t * t * t;
            for a in 0..3 {
                matrix[(4 * j, 4 * k + 1 + a)] = 3.0 * t * delta[a];
                matrix[(4 * j + 1 + a, 4 * k)] = 3.0 * t * delta[a];
                for b in 0..3 {
                    let identity = if a == b { 3.0 * t } else { 0.0 };
                    matrix[(4 * j + 1 + a, 4 * k + 1 + b)] =
                        identity + 3.0 * delta[a] * delta[b] / t;
                }
            }
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Evenly spread unit vectors (Fibonacci spiral).
    fn sphere(n: usize) -> Vec<DVec3> {
        (0..n)
            .map(|i| {
                let z = 1.0 - (2 * i + 1) as f64 / n as f64;
                let (y, x) = (2.399_963_229_728_653 * i as f64).sin_cos();
                let flat = (1.0 - z * z).sqrt();
                DVec3::new(flat * x, flat * y, z)
            })
            .collect()
    }

    /// A sphere of radius 20 about (100, -50, 3).
    fn ball() -> Hrbf {
        let constraints: Vec<Constraint> = sphere(40)
            .into_iter()
            .map(|n| Constraint {
                position: DVec3::new(100.0, -50.0, 3.0) + 20.0 * n,
                value: 0.0,
                normal: n,
            })
            .collect();
        Hrbf::solve(&constraints).unwrap()
    }

    #[test]
    fn a_sphere_is_reproduced_between_its_samples() {
        let ball = ball();
        for n in sphere(333) {
            let (d, gradient) = ball.evaluate(DVec3::new(100.0, -50.0, 3.0) + 20.0 * n);
            assert!(d.abs() < 0.2, "{d}");
            assert!(
                gradient.dot(n) > 0.95 && gradient.length() < 1.05,
                "{gradient}"
            );
        }
        // The smoothest function through the samples is round at the centre: (t² - 1) / 2 rather than t - 1.
        let middle = ball.evaluate(DVec3::new(100.0, -50.0, 3.0)).0;
        assert!(middle < -6.0, "{middle}");
        assert!(ball.evaluate(DVec3::new(130.0, -50.0, 3.0)).0 > 5.0);
    }

    #[test]
    fn the_gradient_is_the_derivative() {
        let ball = ball();
        for n in sphere(50) {
            let x = DVec3::new(100.0, -50.0, 3.0) + 27.0 * n;
            let difference = DVec3::from_array(std::array::from_fn(|a| {
                let h = 1e-4 * DVec3::AXES[a];
                (ball.evaluate(x + h).0 - ball.evaluate(x - h).0) / 2e-4
            }));
            assert!(difference.distance(ball.evaluate(x).1) < 1e-6);
        }
    }

    #[test]
    fn coincident_centres_are_refused() {
        let twice = [DVec3::X, DVec3::X, DVec3::Y].map(|position| Constraint {
            position,
            value: 0.0,
            normal: DVec3::X,
        });
        assert!(Hrbf::solve(&twice).is_none());
    }
}
