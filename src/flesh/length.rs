//! Curves by their arc length, within and past their ends.

use glam::DVec3;

use super::curve::{Jet, Path};
use crate::{Error, Result};

/// Nodes and weights of Gauss and Legendre on [-1, 1], the positive half of eight.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];
/// Panels between two breaks are halved until two halves agree with the whole to this share of the length.
const AGREED: f64 = 1e-14;
/// ... or this often.
const HALVINGS: u32 = 14;
/// A curve slower than this share of its mean speed stands still, and has no direction.
const STILL: f64 = 1e-9;

/// A path with its arc length at the ends of panels.
pub(super) struct ArcLength<'a> {
    path: &'a dyn Path,
    /// Parameter and arc length.
    panels: Vec<(f64, f64)>,
}

impl<'a> ArcLength<'a> {
    pub(super) fn new(path: &'a dyn Path) -> Result<Self> {
        let breaks = path.breaks();
        let rough: f64 = breaks.windows(2).map(|b| gauss(path, b[0], b[1])).sum();
        if !(rough.is_finite() && rough > 0.0) {
            let reason = "the curve has no length, or one that is not finite";
            return Err(Error::argument("points", reason));
        }
        let mut panels = vec![(breaks[0], 0.0)];
        for pair in breaks.windows(2) {
            halve(
                path,
                (pair[0], pair[1]),
                AGREED * rough,
                HALVINGS,
                &mut panels,
            );
        }
        Ok(Self { path, panels })
    }

    fn end(&self) -> (f64, f64) {
        self.panels[self.panels.len() - 1]
    }

    pub(super) fn length(&self) -> f64 {
        self.end().1
    }

    /// Point, tangent and curvature vector at an arc length.
    pub(super) fn at(&self, s: f64) -> Result<Jet> {
        let jet = self.path.jet(self.parameter(s));
        let speed = jet.first.length();
        let mean = self.length() / (self.end().0 - self.panels[0].0);
        if !(speed.is_finite() && speed > STILL * mean) {
            let reason = format!("the curve has a cusp or no direction at length {s}");
            return Err(Error::argument("points", reason));
        }
        let tangent = jet.first / speed;
        let curvature = jet.second.reject_from_normalized(tangent) / (speed * speed);
        if !(jet.point.is_finite() && curvature.is_finite()) {
            let reason = format!("the curve is not finite at length {s}");
            return Err(Error::argument("points", reason));
        }
        Ok(Jet {
            point: jet.point,
            first: tangent,
            second: curvature,
        })
    }

    /// The parameter at an arc length, by Newton within the panel.
    fn parameter(&self, s: f64) -> f64 {
        let after = self.panels.partition_point(|p| p.1 <= s);
        let row = after.clamp(1, self.panels.len() - 1) - 1;
        let ((from, low), (to, high)) = (self.panels[row], self.panels[row + 1]);
        let mut t = from + (to - from) * (s - low) / (high - low);
        for _ in 0..12 {
            let missing = s - low - gauss(self.path, from, t);
            let step = missing / self.path.jet(t).first.length();
            t = (t + step).clamp(from, to);
            if step.is_nan() || step.abs() <= 1e-15 * (to.abs() + from.abs()) {
                break;
            }
        }
        t
    }
}

/// Length of a path between two parameters.
fn gauss(path: &dyn Path, from: f64, to: f64) -> f64 {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let pair = |(node, weight): (f64, f64)| {
        let speed = |t: f64| path.jet(t).first.length();
        weight * (speed(middle - half * node) + speed(middle + half * node))
    };
    half * GAUSS.iter().map(|&g| pair(g)).sum::<f64>()
}

/// Adds panels that are short enough to be integrated at once.
fn halve(
    path: &dyn Path,
    (from, to): (f64, f64),
    agreed: f64,
    left: u32,
    panels: &mut Vec<(f64, f64)>,
) {
    let middle = 0.5 * (from + to);
    let halves = [gauss(path, from, middle), gauss(path, middle, to)];
    let whole = gauss(path, from, to);
    if left > 0 && (halves[0] + halves[1] - whole).abs() > agreed {
        halve(path, (from, middle), agreed, left - 1, panels);
        halve(path, (middle, to), agreed, left - 1, panels);
        return;
    }
    for (t, length) in [(middle, halves[0]), (to, halves[1])] {
        let before = panels[panels.len() - 1].1;
        panels.push((t, before + length));
    }
}

/// How a curve goes on past an end: in the plane of its curvature there, which eases to zero.
pub(super) struct RunOut {
    /// Point, tangent outward and curvature vector at the end.
    end: Jet,
    length: f64,
}

impl RunOut {
    pub(super) fn new(end: Jet, length: f64) -> Self {
        Self { end, length }
    }

    /// At a distance from the end along the run-out.
    pub(super) fn at(&self, z: f64) -> Jet {
        let panels = 8;
        let step = z / f64::from(panels);
        let integral = |row: i32| {
            let (middle, half) = ((f64::from(row) + 0.5) * step, 0.5 * step);
            let pair = |&(node, weight): &(f64, f64)| {
                weight * (self.tangent(middle - half * node) + self.tangent(middle + half * node))
            };
            half * GAUSS.iter().map(pair).sum::<DVec3>()
        };
        let way: DVec3 = (0..panels).map(integral).sum();
        let (x, curvature) = (z / self.length, self.end.second.length());
        let ease = 1.0 - x * x * x * (10.0 - x * (15.0 - 6.0 * x));
        let (sin, cos) = self.turned(z).sin_cos();
        Jet {
            point: self.end.point + way,
            first: self.tangent(z),
            second: ease * (cos * self.end.second - curvature * sin * self.end.first),
        }
    }

    /// Angle turned: the integral of the curvature, which falls as a smooth step.
    fn turned(&self, z: f64) -> f64 {
        let x = z / self.length;
        let ramp = x - x.powi(4) * (2.5 - x * (3.0 - x));
        self.end.second.length() * self.length * ramp
    }

    fn tangent(&self, z: f64) -> DVec3 {
        let (sin, cos) = self.turned(z).sin_cos();
        cos * self.end.first + sin * self.end.second.normalize_or_zero()
    }
}
