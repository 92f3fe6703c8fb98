//! Circular arcs and helices.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{CLOSED, Jet, Path, Round};
use crate::{Error, Result};

impl Round {
    /// Whether it is a full circle; more than one is refused.
    pub(super) fn closed(&self) -> Result<bool> {
        let turns = self.length / (TAU * self.radius);
        if turns > 1.0 + CLOSED {
            let reason = format!("{} is more than a full circle", self.length);
            return Err(Error::argument("length", reason));
        }
        Ok(turns >= 1.0 - CLOSED)
    }
}

/// A helix by arc length: centre + radius (sin(a) across - cos(a) inward) + rise s axis, a = turn s.
pub(super) struct Helix {
    centre: DVec3,
    across: DVec3,
    inward: DVec3,
    axis: DVec3,
    radius: f64,
    turn: f64,
    rise: f64,
    length: f64,
}

impl Helix {
    pub(super) fn new(round: &Round, pitch: f64) -> Result<Self> {
        let positive = [("radius", round.radius), ("length", round.length)];
        for (name, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                let reason = format!("{value} is not a positive length");
                return Err(Error::argument(name, reason));
            }
        }
        if !pitch.is_finite() {
            return Err(Error::argument("pitch", "is not finite"));
        }
        if !round.start.is_finite() {
            return Err(Error::argument("start", "is not finite"));
        }
        let tangent = direction(round.tangent, "tangent")?;
        let normal = direction(round.normal, "normal")?;
        let inward = normal.reject_from_normalized(tangent);
        if inward.length() < 1e-9 {
            return Err(Error::argument("normal", "is along the tangent"));
        }
        let inward = inward.normalize();
        // The tangent rises by the slope of the pitch over the circle.
        let (rise, level) = (pitch / TAU).atan2(round.radius).sin_cos();
        let binormal = tangent.cross(inward);
        Ok(Self {
            centre: round.start + round.radius * inward,
            across: level * tangent - rise * binormal,
            inward,
            axis: rise * tangent + level * binormal,
            radius: round.radius,
            turn: level / round.radius,
            rise,
            length: round.length,
        })
    }
}

fn direction(vector: DVec3, name: &str) -> Result<DVec3> {
    let unit = vector.try_normalize();
    unit.ok_or_else(|| Error::argument(name, "has no direction"))
}

impl Path for Helix {
    fn breaks(&self) -> Vec<f64> {
        vec![0.0, self.length]
    }

    fn jet(&self, s: f64) -> Jet {
        let (sin, cos) = (self.turn * s).sin_cos();
        let (r, w) = (self.radius, self.turn);
        Jet {
            point: self.centre
                + r * (sin * self.across - cos * self.inward)
                + self.rise * s * self.axis,
            first: r * w * (cos * self.across + sin * self.inward) + self.rise * self.axis,
            second: r * w * w * (cos * self.inward - sin * self.across),
        }
    }
}
