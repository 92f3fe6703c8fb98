//! Controllers: how deep a contact goes at an angle between two gradients (2014, section 4.1 and figure 4).

use crate::Result;

use super::opening::{TABLE, check, share, tabulate};

/// Depth of contact d in [0, 1] as a function of the angle α between the gradients of two fields.
///
/// Three points (cos α, d), between two of which d follows the same smooth step as an [`OpeningCurve`](super::OpeningCurve).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Controller {
    /// (cos α, d), cos α ascending; it may lie outside [-1, 1].
    pub points: [(f32, f32); 3],
    /// Exponents of the smooth step between points 0 and 1, and 1 and 2.
    pub exponents: [f32; 2],
}

impl Controller {
    /// d_c of elbows and knees (figure 4a): no contact up to α = π/2, from there on deeper, full at π.
    pub fn elbow() -> Self {
        Self {
            points: [(-1.0, 1.0), (0.0, 0.0), (1.0, 0.0)],
            exponents: [1.0, 1.0],
        }
    }

    /// Contact once two surfaces fold, from 8° on and full from 26° on: the contact line reaches as far into a fold as the skin
    /// does. Where it ends before, skin piles up at its tip and is pushed through the limb in deep bends. The default of tracking.
    pub fn fold() -> Self {
        Self {
            points: [(0.9, 1.0), (0.99, 0.0), (1.0, 0.0)],
            exponents: [1.0, 1.0],
        }
    }

    /// d_b of finger joints (figure 4b): begins at low angles, full from α = π/2 on.
    pub fn finger() -> Self {
        Self {
            points: [(-1.0, 1.0), (0.0, 1.0), (1.0, 0.0)],
            exponents: [1.0, 1.0],
        }
    }

    /// No contact at any angle: the clean union.
    pub fn never() -> Self {
        Self {
            points: [(-1.0, 0.0), (0.0, 0.0), (1.0, 0.0)],
            exponents: [1.0, 1.0],
        }
    }

    /// A controller through the user's points.
    ///
    /// # Errors
    /// [`Error::Argument`](crate::Error::Argument) with subject `controller` where a number is not finite, cos α does not ascend,
    /// d leaves [0, 1] or an exponent is not positive.
    pub fn new(points: [(f32, f32); 3], exponents: [f32; 2]) -> Result<Self> {
        check("controller", points, exponents)?;
        Ok(Self { points, exponents })
    }

    /// d where the gradients' angle has this cosine.
    pub fn depth(&self, cos_alpha: f64) -> f64 {
        share(self.points, self.exponents, cos_alpha)
    }

    /// d at [`TABLE`] cosines, entry i at cos α = -1 + 2 i / 127.
    pub fn table(&self) -> [f32; TABLE] {
        tabulate(|cos| self.depth(cos))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn at(controller: Controller, degrees: f64) -> f64 {
        controller.depth(degrees.to_radians().cos())
    }

    #[test]
    fn an_elbow_touches_from_90_degrees_on_and_a_finger_bulges_before() {
        let (elbow, finger) = (Controller::elbow(), Controller::finger());
        for degrees in [0.0, 45.0, 90.0] {
            assert!(at(elbow, degrees) < 1e-9, "{degrees}");
        }
        for degrees in [90.0, 135.0, 180.0] {
            assert!((at(finger, degrees) - 1.0).abs() < 1e-9, "{degrees}");
        }
        assert!(at(elbow, 180.0) > 1.0 - 1e-9 && at(finger, 0.0) < 1e-9);
        assert!(at(elbow, 120.0) > 0.2 && at(elbow, 120.0) < 0.8);
        assert!(at(finger, 50.0) > 0.1 && at(finger, 50.0) < 0.9);
    }

    #[test]
    fn depth_rises_smoothly_with_the_angle() {
        // All of the way in 90 degrees would be .011 a degree, in the 18 of a fold .056; the second bound: no kink.
        for (controller, steepest, kink) in [
            (Controller::elbow(), 0.04, 0.004),
            (Controller::finger(), 0.04, 0.004),
            (Controller::fold(), 0.12, 0.04),
        ] {
            let depths: Vec<f64> = (0..=180).map(|d| at(controller, d as f64)).collect();
            let steps: Vec<f64> = depths.windows(2).map(|w| w[1] - w[0]).collect();
            assert!(steps.iter().all(|s| (0.0..steepest).contains(s)));
            assert!(steps.windows(2).all(|w| (w[1] - w[0]).abs() < kink));
        }
    }

    #[test]
    fn a_table_holds_depths_by_cosine() {
        let table = Controller::elbow().table();
        assert_eq!((table[0], table[127]), (1.0, 0.0));
        let cos = 2.0 * 20.0 / 127.0 - 1.0;
        assert_eq!(table[20], Controller::elbow().depth(cos) as f32);
    }

    #[test]
    fn bad_points_are_refused_by_name() {
        let good = Controller::finger().points;
        assert!(Controller::new(good, [2.0, 0.5]).is_ok());
        let error = Controller::new([good[1], good[0], good[2]], [1.0; 2]).unwrap_err();
        assert!(error.to_string().starts_with("controller"));
        assert!(Controller::new(good, [1.0, 0.0]).is_err());
    }
}
