//! What a profile has to be; errors name the depth and the point.

use crate::{Error, Result};

use super::{Level, profile::ISO};

/// An error about a profile.
pub(super) fn refusal(reason: impl Into<String>) -> Error {
    Error::argument("profile", reason)
}

/// Refuses a depth that is not in [0, 1] or does not ascend.
pub(super) fn check_depth(depth: f64, before: Option<f64>) -> Result<()> {
    if !(0.0..=1.0).contains(&depth) {
        return Err(refusal(format!("depth {depth} is not in 0 to 1")));
    }
    match before {
        Some(before) if depth <= before => Err(refusal(format!(
            "depth {depth} does not ascend from {before}"
        ))),
        _ => Ok(()),
    }
}

/// Refuses points outside of [0, 1]².
fn check_range(depth: f64, name: &str, points: &[[f64; 2]]) -> Result<()> {
    let outside = |p: &[f64; 2]| p.iter().any(|f| !(0.0..=1.0).contains(f));
    match points.iter().position(outside) {
        Some(i) => Err(refusal(format!(
            "depth {depth}, {name} point {i}: {:?} is not in 0 to 1",
            points[i]
        ))),
        None => Ok(()),
    }
}

/// Refuses a surface that does not run from axis to axis.
pub(super) fn check_surface(level: &Level) -> Result<()> {
    let Level { depth, surface, .. } = level;
    check_range(*depth, "surface", surface)?;
    let [first, .., last] = surface.as_slice() else {
        let reason = format!("depth {depth}: a surface needs two points or more");
        return Err(refusal(reason));
    };
    for (i, point, expected) in [
        (0, *first, [0.0, ISO]),
        (surface.len() - 1, *last, [ISO, 0.0]),
    ] {
        if point != expected {
            return Err(refusal(format!(
                "depth {depth}, surface point {i}: {point:?} must be {expected:?}, where the other field is 0"
            )));
        }
    }
    Ok(())
}

/// Refuses a contact line of one point, or one that goes outward.
pub(super) fn check_contact(level: &Level) -> Result<()> {
    let Level { depth, contact, .. } = level;
    check_range(*depth, "contact", contact)?;
    if contact.len() == 1 {
        let reason = format!("depth {depth}, contact point 0: a line needs a second point");
        return Err(refusal(reason));
    }
    let outward = |w: &[[f64; 2]]| w[1][0] + w[1][1] < w[0][0] + w[0][1];
    match contact.windows(2).position(outward) {
        Some(i) => Err(refusal(format!(
            "depth {depth}, contact point {}: f1 + f2 descends, but the line must go inward",
            i + 1
        ))),
        None => Ok(()),
    }
}
