//! Smooth curves through densely given points.

use glam::DVec3;

use super::{Jet, Path, chords, neville::neville};
use crate::flesh::hermite::Quintic;

/// Points that the derivatives at one of them are taken from: itself and two on either side.
const STENCIL: usize = 5;

/// A quintic a stretch, from derivatives that the points around either end tell: fourth order, and what is wrong at one point
/// (a corner, noise) stays there.
pub(super) struct Polyline {
    parameters: Vec<f64>,
    stretches: Vec<Quintic>,
}

impl Polyline {
    /// Points that differ from their neighbours; of a ring each once.
    pub(super) fn new(points: &[DVec3], closed: bool) -> Self {
        let count = points.len();
        let mut all = points.to_vec();
        if closed {
            // A ring goes on in both directions.
            let around = STENCIL / 2;
            all = (0..count + 2 * around + 1)
                .map(|i| points[(i + count * around - around) % count])
                .collect();
        }
        let parameters = chords(&all);
        let jet = |i: usize| {
            let width = STENCIL.min(all.len());
            let from = i.saturating_sub(STENCIL / 2).min(all.len() - width);
            let window = from..from + width;
            let mut jet = neville(&all[window.clone()], &parameters[window], parameters[i]);
            jet.point = all[i];
            jet
        };
        let used = match closed {
            true => STENCIL / 2..STENCIL / 2 + count + 1,
            false => 0..count,
        };
        let jets: Vec<Jet> = used.clone().map(jet).collect();
        let parameters = parameters[used].to_vec();
        let stretch =
            |i: usize| Quintic::new(&jets[i], &jets[i + 1], parameters[i + 1] - parameters[i]);
        Self {
            stretches: (0..jets.len() - 1).map(stretch).collect(),
            parameters,
        }
    }
}

impl Path for Polyline {
    fn breaks(&self) -> Vec<f64> {
        self.parameters.clone()
    }

    fn jet(&self, t: f64) -> Jet {
        let after = self.parameters.partition_point(|p| *p <= t);
        let row = after.clamp(1, self.stretches.len()) - 1;
        let (from, to) = (self.parameters[row], self.parameters[row + 1]);
        let (jet, _) = self.stretches[row].at((t - from) / (to - from), to - from);
        jet
    }
}
