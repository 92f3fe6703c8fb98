//! Frames that do not turn about their curve, by double reflection (Wang et al. 2008), and their twist.

use glam::DVec3;

use super::{curve::Jet, hermite::Quintic};

/// Reflections between two samples, for a fourth-order method on a fine grid.
const PARTS: usize = 4;

/// First frame vectors at all samples, from `first` at sample `start` in both directions.
pub(super) fn carry(curves: &[Quintic], samples: &[Jet], start: usize, first: DVec3) -> Vec<DVec3> {
    let mut sides = vec![first; samples.len()];
    for row in start..curves.len() {
        sides[row + 1] = across(&curves[row], sides[row], false, &samples[row + 1]);
    }
    for row in (0..start).rev() {
        sides[row] = across(&curves[row], sides[row + 1], true, &samples[row]);
    }
    sides
}

/// Through one cell, backward from its end or forward, to a sample.
fn across(curve: &Quintic, side: DVec3, back: bool, to: &Jet) -> DVec3 {
    let at = |part: usize| {
        let u = part as f64 / PARTS as f64;
        let (jet, _) = curve.at(if back { 1.0 - u } else { u }, 1.0);
        (jet.point, jet.first.normalize())
    };
    let end = (0..PARTS).fold(side, |side, part| reflect(side, at(part), at(part + 1)));
    end.reject_from_normalized(to.first).normalize()
}

/// Reflected in the plane between the two points, then in that between the reflected and the new tangent.
fn reflect(side: DVec3, from: (DVec3, DVec3), to: (DVec3, DVec3)) -> DVec3 {
    let mirror = |v: DVec3, normal: DVec3| {
        let square = normal.length_squared();
        match square > 1e-30 {
            true => v - 2.0 * normal.dot(v) / square * normal,
            false => v,
        }
    };
    let chord = (to.0 - from.0).normalize_or_zero();
    let (side, tangent) = (mirror(side, chord), mirror(from.1, chord));
    mirror(side, to.1 - tangent)
}

/// Turns the frame vectors by `turn`, an angle and its rate by arc length at each sample; returns the rates. Around a ring of a
/// given length, what is missing for it to close is spread evenly.
pub(super) fn twist(
    sides: &mut [DVec3],
    samples: &[Jet],
    ring: Option<f64>,
    turn: impl Fn(usize) -> (f64, f64),
) -> Vec<f64> {
    let last = sides.len() - 1;
    let tangent = samples[0].first;
    // From the carried frame back to the first.
    let missing = sides[0]
        .cross(sides[last])
        .dot(tangent)
        .atan2(sides[0].dot(sides[last]));
    let (close, spread) = match ring {
        Some(length) => (-missing, -missing / length),
        None => (0.0, 0.0),
    };
    let turned = |(row, side): (usize, &mut DVec3)| {
        let (angle, rate) = turn(row);
        let angle = angle + close * row as f64 / last as f64;
        let (sin, cos) = angle.sin_cos();
        *side = cos * *side + sin * samples[row].first.cross(*side);
        rate + spread
    };
    sides.iter_mut().enumerate().map(turned).collect()
}
