//! Opening curves: how far an operator opens with the angle between the two gradients (2013, section 4.2 and figure 7).

use std::f64::consts::FRAC_PI_4;

use crate::{Error, Result};

/// Entries of an opening curve's table.
pub const TABLE: usize = 128;

/// θ as a function of the angle α between the gradients of two fields.
///
/// Three points (cos α, F), F being 1 for the union (θ = π/4) and 0 for the operator in full (θ = 0); between two points
/// F follows the smooth step κ of the middle point's distance raised to an exponent, outside of them it is constant.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct OpeningCurve {
    /// (cos α, F), cos α ascending; it may lie outside [-1, 1].
    pub points: [(f32, f32); 3],
    /// Exponents of κ between points 0 and 1, and 1 and 2.
    pub exponents: [f32; 2],
}

impl OpeningCurve {
    /// Elbows and knees (figure 7a): union at α = 0, full at π/4, union again from π/2 on.
    pub fn elbow() -> Self {
        Self {
            points: [
                (0.0, 1.0),
                (std::f32::consts::FRAC_1_SQRT_2, 0.0),
                (1.0, 1.0),
            ],
            exponents: [1.0, 1.0],
        }
    }

    /// Finger joints (figure 7b): union at α = 0, opening slowly, full from π/2 on.
    pub fn finger() -> Self {
        Self {
            points: [(-1.0, 0.0), (0.0, 0.0), (1.0, 1.0)],
            exponents: [1.0, 1.0],
        }
    }

    /// A curve through the user's points.
    ///
    /// # Errors
    /// [`Error::Argument`] where a number is not finite, cos α does not ascend, F leaves [0, 1] or an exponent is not positive.
    pub fn new(points: [(f32, f32); 3], exponents: [f32; 2]) -> Result<Self> {
        check("opening", points, exponents)?;
        Ok(Self { points, exponents })
    }

    /// tan θ in [0, 1] where the gradients' angle has this cosine.
    pub fn tan_theta(&self, cos_alpha: f64) -> f64 {
        (share(self.points, self.exponents, cos_alpha) * FRAC_PI_4)
            .tan()
            .clamp(0.0, 1.0)
    }

    /// tan θ at [`TABLE`] cosines, entry i at cos α = -1 + 2 i / 127.
    pub fn table(&self) -> [f32; TABLE] {
        tabulate(|cos| self.tan_theta(cos))
    }
}

/// Refuses points and exponents that give no curve; `subject` is what the user calls it.
pub(super) fn check(subject: &str, points: [(f32, f32); 3], exponents: [f32; 2]) -> Result<()> {
    let refuse = |reason: String| Err(Error::argument(subject, reason));
    for (cos, value) in points {
        if !cos.is_finite() || !(0.0..=1.0).contains(&value) {
            return refuse(format!(
                "point ({cos}, {value}) needs a finite cosine and a value in 0 to 1"
            ));
        }
    }
    if !(points[0].0 < points[1].0 && points[1].0 < points[2].0) {
        return refuse("cosines must ascend".into());
    }
    if let Some(bad) = exponents.iter().find(|s| !(s.is_finite() && **s > 0.0)) {
        return refuse(format!("exponent {bad} is not positive"));
    }
    Ok(())
}

/// The curve's value at a cosine: from the middle point to either side by the smooth step κ raised to that side's exponent.
pub(super) fn share(points: [(f32, f32); 3], exponents: [f32; 2], cos: f64) -> f64 {
    let [(x0, f0), (x1, f1), (x2, f2)] = points.map(|(x, f)| (x as f64, f as f64));
    let (far, value, exponent) = if cos < x1 {
        ((x1 - cos) / (x1 - x0), f0, exponents[0])
    } else {
        ((cos - x1) / (x2 - x1), f2, exponents[1])
    };
    f1 + (value - f1) * kappa(far.clamp(0.0, 1.0)).powf(exponent as f64)
}

/// A function of cos α at [`TABLE`] cosines, entry i at -1 + 2 i / 127.
pub(super) fn tabulate(f: impl Fn(f64) -> f64) -> [f32; TABLE] {
    std::array::from_fn(|i| f(2.0 * i as f64 / (TABLE - 1) as f64 - 1.0) as f32)
}

/// The authors' smooth step u(v(0.8 x + 0.1)), u(x) = 1 - exp(1 - 1/(1-x)), v(x) = exp(1 - 1/x), stretched by
/// its own 2e-4 to reach 0 and 1 exactly.
fn kappa(x: f64) -> f64 {
    let raw = |x: f64| {
        let v = (1.0 - 1.0 / (0.8 * x + 0.1)).exp();
        1.0 - (1.0 - 1.0 / (1.0 - v)).exp()
    };
    let (first, last) = (raw(0.0), raw(1.0));
    ((raw(x) - first) / (last - first)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn presets_pass_through_the_points_of_figure_7() {
        let at = |curve: OpeningCurve, degrees: f64| curve.tan_theta(degrees.to_radians().cos());
        let (elbow, finger) = (OpeningCurve::elbow(), OpeningCurve::finger());
        for degrees in [0.0, 90.0, 120.0, 180.0] {
            assert!((at(elbow, degrees) - 1.0).abs() < 1e-9, "{degrees}");
        }
        assert!(at(elbow, 45.0) < 1e-6 && at(elbow, 20.0) > 0.1 && at(elbow, 70.0) > 0.1);
        assert!((at(finger, 0.0) - 1.0).abs() < 1e-9);
        for degrees in [90.0, 135.0, 180.0] {
            assert!(at(finger, degrees) < 1e-9, "{degrees}");
        }
        let rising: Vec<f64> = (0..=90).map(|d| at(finger, d as f64)).collect();
        assert!(rising.windows(2).all(|w| w[0] >= w[1]));
    }

    #[test]
    fn a_table_interpolates_its_curve() {
        let curve = OpeningCurve::elbow();
        let table = curve.table();
        for i in 0..=1000 {
            let cos = i as f64 / 500.0 - 1.0;
            let x = (cos + 1.0) / 2.0 * 127.0;
            let (k, s) = ((x as usize).min(126), x - (x as usize).min(126) as f64);
            let linear = table[k] as f64 * (1.0 - s) + table[k + 1] as f64 * s;
            // .02: half a step of 2/127 on a slope of at most 3.
            assert!((linear - curve.tan_theta(cos)).abs() < 0.02, "{cos}");
        }
    }

    #[test]
    fn bad_points_are_refused_by_name() {
        let good = OpeningCurve::elbow().points;
        assert!(OpeningCurve::new(good, [1.0, 1.0]).is_ok());
        let swapped = [good[1], good[0], good[2]];
        let high = [good[0], (0.5, 1.5), good[2]];
        let nan = [(f32::NAN, 1.0), good[1], good[2]];
        for points in [swapped, high, nan] {
            let error = OpeningCurve::new(points, [1.0, 1.0]).unwrap_err();
            assert!(error.to_string().starts_with("opening"));
        }
        assert!(OpeningCurve::new(good, [0.0, 1.0]).is_err());
    }
}
