//! Twist of a frame along its spine.

use crate::{Error, Result};

/// How much a frame is turned about the tangent, right-handed, against the one that does not turn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Twist {
    /// All along, in degrees.
    pub degrees: f64,
    /// More, along the spine: share of its length from 0 to 1, rising, and degrees there; monotone in between, constant before
    /// the first and past the last.
    pub profile: Vec<[f64; 2]>,
}

impl Twist {
    /// # Errors
    /// [`Error::Argument`] for what is not finite, shares out of range or not rising, and, in a ring, where the ends of the
    /// profile are not whole turns apart.
    pub(super) fn check(&self, closed: bool) -> Result<()> {
        let fault = |reason: String| Err(Error::argument("twist_degrees", reason));
        let mut numbers = self.profile.iter().flatten();
        if !(self.degrees.is_finite() && numbers.all(|n| n.is_finite())) {
            return fault("is not finite".into());
        }
        let outside = |p: &[f64; 2]| !(0.0..=1.0).contains(&p[0]);
        if let Some(row) = self.profile.iter().position(outside) {
            return fault(format!("entry {row}: the share is not from 0 to 1"));
        }
        if let Some(row) = self.profile.windows(2).position(|p| p[1][0] <= p[0][0]) {
            return fault(format!("entry {}: shares have to rise", row + 1));
        }
        let total = match (self.profile.first(), self.profile.last()) {
            (Some(first), Some(last)) => last[1] - first[1],
            _ => 0.0,
        };
        match closed && (total / 360.0 - (total / 360.0).round()).abs() > 1e-9 {
            true => fault(format!(
                "{total} degrees around a closed spine are no whole turns"
            )),
            false => Ok(()),
        }
    }

    /// Angle in radians and its derivative by the share of the length.
    pub(super) fn at(&self, share: f64) -> (f64, f64) {
        let p = &self.profile;
        let (angle, rate) = match (p.first(), p.last()) {
            (Some(first), _) if share <= first[0] => (first[1], 0.0),
            (_, Some(last)) if share >= last[0] => (last[1], 0.0),
            (None, _) | (_, None) => (0.0, 0.0),
            _ => self.between(share),
        };
        ((self.degrees + angle).to_radians(), rate.to_radians())
    }

    /// Cubic with slopes that keep it monotone (Fritsch and Butland 1984).
    fn between(&self, share: f64) -> (f64, f64) {
        let p = &self.profile;
        let row = p.partition_point(|e| e[0] <= share) - 1;
        let (a, b) = (p[row], p[row + 1]);
        let step = b[0] - a[0];
        let u = (share - a[0]) / step;
        let (v0, v1) = (step * self.slope(row), step * self.slope(row + 1));
        let gap = b[1] - a[1];
        let (c, d) = (3.0 * gap - 2.0 * v0 - v1, v0 + v1 - 2.0 * gap);
        (
            a[1] + u * (v0 + u * (c + u * d)),
            (v0 + u * (2.0 * c + u * 3.0 * d)) / step,
        )
    }

    /// Harmonic mean of the slopes on either side; level at the ends, beyond which the twist is constant.
    fn slope(&self, row: usize) -> f64 {
        let p = &self.profile;
        if row == 0 || row + 1 == p.len() {
            return 0.0;
        }
        let chord = |i: usize| (p[i + 1][1] - p[i][1]) / (p[i + 1][0] - p[i][0]);
        let (a, b) = (chord(row - 1), chord(row));
        match a * b > 0.0 {
            true => 2.0 * a * b / (a + b),
            false => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_profile_is_met_and_monotone() {
        let twist = Twist {
            degrees: 10.0,
            profile: vec![[0.1, 0.0], [0.4, 90.0], [0.5, 100.0], [0.9, 400.0]],
        };
        twist.check(false).unwrap();
        assert!(twist.check(true).is_err());
        for entry in &twist.profile {
            assert!((twist.at(entry[0]).0 - (10.0 + entry[1]).to_radians()).abs() < 1e-12);
        }
        let mut before = twist.at(0.0).0;
        for i in 1..=1000 {
            let share = f64::from(i) / 1000.0;
            let (angle, rate) = twist.at(share);
            assert!(angle >= before, "{share}");
            let slope = (twist.at(share + 1e-6).0 - twist.at(share - 1e-6).0) / 2e-6;
            assert!((slope - rate).abs() < 1e-3 * (1.0 + rate), "{share}");
            before = angle;
        }
    }

    #[test]
    fn what_is_wrong_is_said() {
        let wrong = |profile: &[[f64; 2]]| {
            let twist = Twist {
                degrees: 0.0,
                profile: profile.to_vec(),
            };
            twist.check(false).unwrap_err().to_string()
        };
        assert!(wrong(&[[0.0, f64::NAN]]).contains("finite"));
        assert!(wrong(&[[0.0, 1.0], [1.5, 0.0]]).contains("entry 1"));
        assert!(wrong(&[[0.5, 1.0], [0.5, 0.0]]).contains("rise"));
    }
}
