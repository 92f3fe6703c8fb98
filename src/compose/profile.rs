//! Profile curves: where an operator of the 2014 method is 0.5, at every depth of contact (section 4, Eq. 2).
//!
//! A slice of the operator's volume has a *surface* curve, which runs from (0, 0.5) to (0.5, 0) and is the composite's skin, and
//! a *contact* line, which begins on the surface and goes inward: the sheet where both parts meet.

use std::{f64::consts::FRAC_1_SQRT_2, path::Path};

use crate::{Error, Result};

use super::{
    profile_check::{check_contact, check_depth, check_surface, refusal},
    spline::cubic,
};

/// Greatest magnitude of [`Profile::bulge`], which lifts the skin by 0.16 in f; far beyond it g ceases to rise with its fields outside.
pub const MAX_BULGE: f32 = 2.0;

/// The iso-value of the skin.
pub(super) const ISO: f64 = 0.5;

/// How the control points of a surface curve are joined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// By straight segments.
    #[default]
    Polyline,
    /// By a uniform cubic B-spline that begins at the first point and ends at the last; a point given three times is a corner.
    Spline,
}

/// The profile at one depth; points are (f1, f2), field values in [0, 1].
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Level {
    /// Depth of contact d in [0, 1].
    pub depth: f64,
    /// Control points of the surface, from (0, 0.5) to (0.5, 0).
    pub surface: Vec<[f64; 2]>,
    /// Points of the contact line, joined by straight segments, f1 + f2 not descending; none where nothing touches.
    /// A line of no length (its first point, repeated) is one that has yet to grow.
    #[serde(default)]
    pub contact: Vec<[f64; 2]>,
}

/// Profile of an operator at all depths: linear between its levels, constant before the first and behind the last.
///
/// As JSON: `{"form": "spline", "levels": [{"depth": 0, "surface": [[0, 0.5], [0.5, 0.5], [0.5, 0]], "contact": []}]}`.
/// It need not be symmetric; an operator is symmetric in its fields where the points are.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Raw")]
pub struct Profile {
    form: Form,
    levels: Vec<Level>,
}

/// A profile as read, before it is checked.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    #[serde(default)]
    form: Form,
    levels: Vec<Level>,
}

impl TryFrom<Raw> for Profile {
    type Error = Error;

    fn try_from(raw: Raw) -> Result<Self> {
        Self::new(raw.form, raw.levels)
    }
}

/// The profile at a depth as two polylines in (f1, f2).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Outline {
    pub(super) surface: Vec<[f64; 2]>,
    pub(super) contact: Vec<[f64; 2]>,
}

impl Profile {
    /// A profile through the user's points.
    ///
    /// # Errors
    /// [`Error::Argument`] with subject `profile`, naming the depth and the point, where there is no level, depths do not ascend in
    /// [0, 1], a point is not in [0, 1]², a surface does not run from (0, 0.5) to (0.5, 0), a contact line is a single point or
    /// goes outward, or a level has another number of points than the first.
    pub fn new(form: Form, levels: Vec<Level>) -> Result<Self> {
        let first = levels.first().ok_or_else(|| refusal("it has no level"))?;
        for (k, level) in levels.iter().enumerate() {
            let before = k.checked_sub(1).map(|k| levels[k].depth);
            check_depth(level.depth, before)?;
            check_surface(level)?;
            check_contact(level)?;
            for (name, points, expected) in [
                ("surface", &level.surface, first.surface.len()),
                ("contact", &level.contact, first.contact.len()),
            ] {
                if points.len() != expected {
                    return Err(refusal(format!(
                        "depth {}: {} {name} points, but the first level has {expected}",
                        level.depth,
                        points.len()
                    )));
                }
            }
        }
        Ok(Self { form, levels })
    }

    /// Reads a profile from a JSON file.
    ///
    /// # Errors
    /// [`Error::File`] where it cannot be read; [`Error::Asset`] with line and column where it is no such JSON, with the depth and
    /// the point where [`Profile::new`] refuses it.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|e| Error::file(path, e))?;
        let raw: Raw = serde_json::from_slice(&bytes)
            .map_err(|e| Error::asset(path, "JSON", e.to_string()))?;
        Self::new(raw.form, raw.levels).map_err(|error| match error {
            Error::Argument { argument, reason } => Error::asset(path, argument, reason),
            other => other,
        })
    }

    /// Contact g_dc (figure 5): the union's corner at (0.5, 0.5), and from it a contact line along f1 = f2 to 0.5 + d/√2.
    ///
    /// It reaches the corner (1, 1) at d = 1/√2; deeper slices are alike.
    pub fn contact() -> Self {
        let surface = vec![[0.0, ISO], [ISO, ISO], [ISO, 0.0]];
        let levels = PRESET_DEPTHS.map(|depth| level(depth, surface.clone(), ISO));
        Self {
            form: Form::Polyline,
            levels: levels.into(),
        }
    }

    /// Bulge in contact g_db (figure 6): besides the contact line, both surfaces swell to lobes that touch along the diagonal.
    ///
    /// Control points go linearly from aligned (the union) at d = 0 to the full bulge at d = 1; `magnitude` scales their way,
    /// 0 being [`Profile::contact`] and 1 a bulge that lifts the skin by 0.08 in f.
    ///
    /// # Errors
    /// [`Error::Argument`] with subject `magnitude` unless it is in [0, [`MAX_BULGE`]].
    pub fn bulge(magnitude: f32) -> Result<Self> {
        if !(0.0..=MAX_BULGE).contains(&magnitude) {
            let reason = format!("{magnitude} is not in 0 to {MAX_BULGE}");
            return Err(Error::argument("magnitude", reason));
        }
        let levels = PRESET_DEPTHS.map(|depth| {
            let share = depth * magnitude as f64;
            let lobe: Vec<[f64; 2]> = BULGE
                .iter()
                .map(|(flat, full)| [0, 1].map(|c| flat[c] + share * (full[c] - flat[c])))
                .collect();
            let meeting = lobe[lobe.len() - 1];
            let mirrored = lobe.iter().rev().map(|&[f1, f2]| [f2, f1]);
            // The meeting point stands three times: a corner.
            let surface = lobe.iter().copied().chain([meeting]).chain(mirrored);
            level(depth, surface.collect(), meeting[0])
        });
        Ok(Self {
            form: Form::Spline,
            levels: levels.into(),
        })
    }

    /// How surface points are joined.
    pub fn form(&self) -> Form {
        self.form
    }

    /// The levels, depths ascending.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// The curves at a depth.
    pub(super) fn outline(&self, depth: f64) -> Outline {
        let above = self.levels.partition_point(|l| l.depth <= depth);
        let low = &self.levels[above.saturating_sub(1)];
        let high = &self.levels[above.min(self.levels.len() - 1)];
        let span = high.depth - low.depth;
        let share = if span > 0.0 {
            ((depth - low.depth) / span).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let surface = between(&low.surface, &high.surface, share);
        Outline {
            surface: match self.form {
                Form::Polyline => surface,
                Form::Spline => cubic(&surface),
            },
            contact: between(&low.contact, &high.contact, share),
        }
    }
}

/// Levels of the presets: everything is linear in d up to 1/√2, where the contact line meets the corner (1, 1), and from there.
const PRESET_DEPTHS: [f64; 3] = [0.0, FRAC_1_SQRT_2, 1.0];

/// Control points (f1, f2) of one lobe of the bulge at d = 0 and d = 1. The paper prints no numbers; in ours the lobes meet at an
/// angle of some 75 degrees, because between lobes that touch tangentially g is flat: |∇g| fell to 0.01 there, and g was not monotone.
const BULGE: [([f64; 2], [f64; 2]); 7] = [
    ([0.00, 0.50], [0.00, 0.500]),
    ([0.10, 0.50], [0.10, 0.500]),
    ([0.20, 0.50], [0.20, 0.495]),
    ([0.30, 0.50], [0.27, 0.450]),
    ([0.40, 0.50], [0.34, 0.420]),
    ([0.46, 0.50], [0.385, 0.420]),
    ([0.50, 0.50], [0.425, 0.425]),
];

/// A preset's level: its contact line runs along the diagonal from `start` to 0.5 + d/√2, at most 1.
fn level(depth: f64, surface: Vec<[f64; 2]>, start: f64) -> Level {
    let tip = (ISO + depth * FRAC_1_SQRT_2).min(1.0);
    Level {
        depth,
        surface,
        contact: vec![[start; 2], [tip; 2]],
    }
}

/// Points between those of two levels.
fn between(low: &[[f64; 2]], high: &[[f64; 2]], share: f64) -> Vec<[f64; 2]> {
    low.iter()
        .zip(high)
        .map(|(a, b)| [0, 1].map(|c| a[c] + share * (b[c] - a[c])))
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn presets_obey_the_rules_for_users() {
        for profile in [
            Profile::contact(),
            Profile::bulge(1.0).unwrap(),
            Profile::bulge(MAX_BULGE).unwrap(),
        ] {
            let again = Profile::new(profile.form(), profile.levels().to_vec()).unwrap();
            assert_eq!(again, profile);
            let json = serde_json::to_string(&profile).unwrap();
            let read: Profile = serde_json::from_str(&json).unwrap();
            // serde_json may miss a number's last bit.
            let [a, b] = [&read, &profile].map(|p| p.outline(0.6).surface);
            assert_eq!((a.len(), read.form()), (b.len(), profile.form()));
            assert!((0..a.len()).all(|i| (a[i][0] - b[i][0]).abs() < 1e-14));
        }
    }

    #[test]
    fn the_contact_line_grows_as_the_paper_says_and_the_surface_stays() {
        for d in [0.0, 0.1, 0.4, 0.7] {
            let outline = Profile::contact().outline(d);
            let tip = 0.5 + d / 2f64.sqrt();
            assert!((outline.contact[1][0] - tip).abs() < 1e-12, "{d}");
            assert_eq!(outline.surface, [[0.0, 0.5], [0.5, 0.5], [0.5, 0.0]]);
        }
        assert_eq!(Profile::contact().outline(1.0).contact[1], [1.0, 1.0]);
    }

    #[test]
    fn lobes_swell_with_depth_and_magnitude_and_stay_on_their_side() {
        let least = |m: f32, d: f64| {
            let outline = Profile::bulge(m).unwrap().outline(d);
            let half = outline.surface.len() / 2;
            for [f1, f2] in &outline.surface[..half] {
                assert!(*f1 <= f2 + 1e-12, "{m} {d}: {f1} {f2}");
            }
            let lobe = outline.surface[..half].iter().map(|p| p[1]);
            lobe.fold(f64::MAX, f64::min)
        };
        assert!((least(1.0, 0.0) - 0.5).abs() < 1e-12);
        assert!(least(1.0, 0.5) < 0.47 && least(1.0, 1.0) < least(1.0, 0.5) - 0.03);
        assert!(least(MAX_BULGE, 1.0) < least(1.0, 1.0) - 0.05);
        assert!(Profile::bulge(2.1).is_err() && Profile::bulge(f32::NAN).is_err());
    }

    /// Reads a profile whose second level is the given JSON.
    fn second(level: &str) -> String {
        let first = r#"{"depth": 0, "surface": [[0,0.5],[0.4,0.4],[0.5,0]]}"#;
        let json = format!(r#"{{"levels": [{first}, {level}]}}"#);
        match serde_json::from_str::<Profile>(&json) {
            Ok(_) => "read".into(),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn errors_name_the_depth_and_the_point() {
        let good = r#"{"depth": 0.25, "surface": [[0,0.5],[0.3,0.5],[0.5,0]]}"#;
        assert_eq!(second(good), "read");
        for (from, to, expected) in [
            ("0.25", "0", "depth 0 does not ascend from 0"),
            ("0.25", "1.5", "depth 1.5 is not in"),
            ("0.3,", "1.3,", "depth 0.25, surface point 1: [1.3, 0.5]"),
            ("[0,0.5]", "[0,0.4]", "depth 0.25, surface point 0"),
            ("[0.5,0]", "[0.5,0.1]", "depth 0.25, surface point 2"),
            (",[0.3,0.5]", "", "depth 0.25: 2 surface points"),
            (
                "]]}",
                r#"]], "contact": [[0.6,0.6],[0.5,0.5]]}"#,
                "depth 0.25, contact point 1",
            ),
            (
                "]]}",
                r#"]], "contact": [[0.6,0.6]]}"#,
                "depth 0.25, contact point 0",
            ),
            ("depth", "dept", "unknown field"),
        ] {
            let message = second(&good.replace(from, to));
            assert!(message.contains(expected), "{message} lacks {expected}");
        }
        let nan = vec![[0.0, 0.5], [f64::NAN, 0.5], [0.5, 0.0]];
        let levels = vec![Level {
            depth: 0.0,
            surface: nan,
            contact: vec![],
        }];
        let error = Profile::new(Form::Spline, levels).unwrap_err().to_string();
        assert!(error.starts_with("profile: depth 0, surface point 1"));
        assert!(Profile::new(Form::Spline, vec![]).is_err());
    }
}
