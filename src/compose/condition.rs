//! What a slice has to meet besides its sides: zero slope at the axes, 0.5 at the pins.
//!
//! A condition is met to within its compliance ε: its distance x costs x² / ε beside the bending energy Σ (L g)².

use super::{pins::Pin, profile::ISO};

/// ε of the axes' conditions: 4 x² is x² / ε.
const AXIS: f64 = 0.25;
/// ε of a firm pin: it stays within some 1e-8 of 0.5. Above 0, so that pins that coincide are no contradiction.
const FIRM: f64 = 1e-8;
/// ε of a pin of share 1/2. A vertex ahead of a contact line gives way by about this much to a unit force, so that its value goes
/// from free to 0.5 evenly while its share goes from 0 to 1: measured, steps from slice to slice are within 15 % of each other.
const LOOSE: f64 = 0.5;

/// The value of g at one vertex, times a weight.
#[derive(Clone, Copy)]
pub(super) struct Tap {
    pub(super) i: usize,
    pub(super) j: usize,
    pub(super) weight: f64,
}

/// A weighted sum of g that is to have a value.
pub(super) struct Condition {
    pub(super) taps: Vec<Tap>,
    pub(super) value: f64,
    /// ε: 0 would hold the value exactly.
    pub(super) compliance: f64,
}

/// The axes' conditions g(1/m, f2) = f2 and g(f1, 1/m) = f1: zero normal derivative.
pub(super) fn axes(cells: usize) -> Vec<Condition> {
    let condition = |i: usize, j: usize, along: usize| Condition {
        taps: vec![Tap { i, j, weight: 1.0 }],
        value: along as f64 / cells as f64,
        compliance: AXIS,
    };
    let first = (1..cells).map(|j| condition(1, j, j));
    let second = (1..cells).map(|i| condition(i, 1, i));
    first.chain(second).collect()
}

/// The bilinear interpolant at a pin is 0.5.
pub(super) fn pinned(pin: &Pin, cells: usize) -> Condition {
    let [(i, u), (j, v)] = pin.at.map(|f| {
        let x = f * cells as f64;
        // A pin that is a vertex but for rounding is that vertex.
        let x = if (x - x.round()).abs() < 1e-9 {
            x.round()
        } else {
            x
        };
        let i = (x as usize).min(cells - 1);
        (i, x - i as f64)
    });
    let corners = [
        (i, j, (1.0 - u) * (1.0 - v)),
        (i + 1, j, u * (1.0 - v)),
        (i, j + 1, (1.0 - u) * v),
        (i + 1, j + 1, u * v),
    ];
    let taps = corners.into_iter().filter(|c| c.2 > 0.0);
    Condition {
        taps: taps.map(|(i, j, weight)| Tap { i, j, weight }).collect(),
        value: ISO,
        compliance: FIRM + LOOSE * (1.0 - pin.share) / pin.share,
    }
}
