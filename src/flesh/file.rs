//! Spines from JSON files.

use std::{fs, path::Path};

use glam::DVec3;
use serde_json::{Map, Value};

use super::{
    curve::{Curve, Round},
    spine::{Spine, SpineDesc},
    twist::Twist,
};
use crate::{Error, Result};

/// Element and what is wrong with it.
type Fault = (String, String);

impl SpineDesc {
    /// Reads a spine from a JSON object: `kind` (`polynomial`, `bspline` or `polyline` with `points`; `arc` or `helix` with `start`,
    /// `tangent`, `normal`, `radius`, `length` and, of a helix, `pitch`), `up` and `twist_degrees`, a number or a list of pairs of
    /// share of the length and degrees. `up` and `twist_degrees` may be left out.
    ///
    /// # Errors
    /// [`Error::File`] where the file cannot be read, [`Error::Asset`] naming the file and the key that is unknown, missing or
    /// wrong.
    pub fn read(path: &Path) -> Result<Self> {
        let text = fs::read(path).map_err(|e| Error::file(path, e))?;
        parse(&text).map_err(|(element, reason)| Error::asset(path, element, reason))
    }
}

impl Spine {
    /// Reads and prepares a spine, like another where one is given: [`SpineDesc::read`], then [`Spine::new`] or [`Spine::like`].
    ///
    /// # Errors
    /// As these, naming the file.
    pub fn read(path: &Path, rest: Option<&Self>) -> Result<Self> {
        let desc = SpineDesc::read(path)?;
        let spine = match rest {
            Some(rest) => Self::like(&desc, rest),
            None => Self::new(&desc),
        };
        spine.map_err(|error| match error {
            Error::Argument { argument, reason } => Error::asset(path, argument, reason),
            other => other,
        })
    }
}

fn fault<T>(element: impl Into<String>, reason: impl Into<String>) -> Result<T, Fault> {
    Err((element.into(), reason.into()))
}

fn parse(text: &[u8]) -> Result<SpineDesc, Fault> {
    let value = serde_json::from_slice(text).map_err(|e| ("JSON".into(), e.to_string()))?;
    let Value::Object(map) = value else {
        return fault("JSON", "is not an object");
    };
    let mut keys = Keys(map);
    let kind = keys.take("kind")?;
    let kind = kind.as_str().unwrap_or_default();
    let curve = match kind {
        "polynomial" => Curve::Polynomial(keys.points()?),
        "bspline" => Curve::BSpline(keys.points()?),
        "polyline" => Curve::Polyline(keys.points()?),
        "arc" => Curve::Arc(keys.round()?),
        "helix" => Curve::Helix {
            round: keys.round()?,
            pitch: keys.number("pitch")?,
        },
        _ => return fault("kind", "is not polynomial, bspline, polyline, arc or helix"),
    };
    let mut desc = SpineDesc::new(curve);
    if let Some(up) = keys.0.remove("up") {
        desc.up = Some(vector("up", &up)?);
    }
    if let Some(twist) = keys.0.remove("twist_degrees") {
        desc.twist = twisted(&twist)?;
    }
    match keys.0.keys().next() {
        Some(key) => fault(key, format!("is no key of a spine of kind {kind}")),
        None => Ok(desc),
    }
}

/// Entries that nothing has taken yet.
struct Keys(Map<String, Value>);

impl Keys {
    fn take(&mut self, key: &str) -> Result<Value, Fault> {
        self.0
            .remove(key)
            .ok_or_else(|| (key.into(), "is missing".into()))
    }

    fn number(&mut self, key: &str) -> Result<f64, Fault> {
        let value = self.take(key)?;
        number(key, &value)
    }

    fn vector(&mut self, key: &str) -> Result<DVec3, Fault> {
        let value = self.take(key)?;
        vector(key, &value)
    }

    fn points(&mut self) -> Result<Vec<DVec3>, Fault> {
        let value = self.take("points")?;
        let Value::Array(rows) = value else {
            return fault("points", "is not a list of points [x, y, z]");
        };
        let point = |(row, value)| vector(&format!("points/{row}"), value);
        rows.iter().enumerate().map(point).collect()
    }

    fn round(&mut self) -> Result<Round, Fault> {
        Ok(Round {
            start: self.vector("start")?,
            tangent: self.vector("tangent")?,
            normal: self.vector("normal")?,
            radius: self.number("radius")?,
            length: self.number("length")?,
        })
    }
}

fn number(element: &str, value: &Value) -> Result<f64, Fault> {
    value
        .as_f64()
        .ok_or_else(|| (element.into(), "is not a number".into()))
}

fn numbers<const N: usize>(element: &str, value: &Value, form: &str) -> Result<[f64; N], Fault> {
    let row = value.as_array().filter(|row| row.len() == N);
    let row = row.ok_or_else(|| (element.to_string(), format!("is not {form}")))?;
    let mut out = [0.0; N];
    for (place, value) in out.iter_mut().zip(row) {
        *place = number(element, value)?;
    }
    Ok(out)
}

fn vector(element: &str, value: &Value) -> Result<DVec3, Fault> {
    numbers(element, value, "[x, y, z]").map(DVec3::from_array)
}

fn twisted(value: &Value) -> Result<Twist, Fault> {
    const KEY: &str = "twist_degrees";
    let pair = |(row, value)| numbers(&format!("{KEY}/{row}"), value, "[share, degrees]");
    match value {
        Value::Array(rows) => Ok(Twist {
            degrees: 0.0,
            profile: rows
                .iter()
                .enumerate()
                .map(pair)
                .collect::<Result<_, _>>()?,
        }),
        _ => Ok(Twist {
            degrees: number(KEY, value)?,
            profile: Vec::new(),
        }),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const ARC: &str = r#"{"kind": "arc", "start": [1, 2, 3], "tangent": [1, 0, 0], "normal": [0, 1, 0], "radius": 2,
        "length": 3, "up": [0, 0, 1], "twist_degrees": 15}"#;

    fn said(text: &str) -> String {
        let (element, reason) = parse(text.as_bytes()).unwrap_err();
        format!("{element}: {reason}")
    }

    #[test]
    fn all_kinds_are_read() {
        let arc = parse(ARC.as_bytes()).unwrap();
        assert_eq!((arc.up, arc.twist.degrees), (Some(DVec3::Z), 15.0));
        let helix = ARC.replace("\"arc\"", "\"helix\", \"pitch\": -1.5");
        let Curve::Helix { round, pitch } = parse(helix.as_bytes()).unwrap().curve else {
            panic!("not a helix");
        };
        assert_eq!((Curve::Arc(round), pitch), (arc.curve, -1.5));
        for kind in ["polynomial", "bspline", "polyline"] {
            let text = format!(
                r#"{{"kind": "{kind}", "points": [[0, 0, 0], [1, 2, 3.5]], "twist_degrees": [[0, 0], [1, 90]]}}"#
            );
            let desc = parse(text.as_bytes()).unwrap();
            assert_eq!(desc.twist.profile, [[0.0, 0.0], [1.0, 90.0]]);
            assert!(Spine::new(&desc).is_ok());
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        assert!(said("[1, 2]").contains("not an object"));
        assert!(said("{").starts_with("JSON"));
        assert_eq!(said("{}"), "kind: is missing");
        assert!(said(r#"{"kind": "nurbs"}"#).starts_with("kind: is not polynomial"));
        assert_eq!(said(r#"{"kind": "bspline"}"#), "points: is missing");
        assert_eq!(said(&ARC.replace("radius", "radios")), "radius: is missing");
        assert_eq!(
            said(&ARC.replace("\"up\"", "\"colour\"")),
            "colour: is no key of a spine of kind arc"
        );
        assert!(
            said(&ARC.replace("\"length\"", "\"pitch\": 1, \"length\""))
                .starts_with("pitch: is no key")
        );
        assert_eq!(
            said(&ARC.replace("[1, 2, 3]", "[1, 2]")),
            "start: is not [x, y, z]"
        );
        assert_eq!(
            said(&ARC.replace("15", "\"x\"")),
            "twist_degrees: is not a number"
        );
        let points = r#"{"kind": "bspline", "points": [[0, 0, 0], [1, null, 3]]}"#;
        assert_eq!(said(points), "points/1: is not a number");
        let points = r#"{"kind": "bspline", "points": [[0, 0, 0], [1, 1e999, 3]]}"#;
        assert!(said(points).starts_with("JSON: number out of range"));
    }

    #[test]
    fn errors_of_a_file_name_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("spine.json");
        assert!(
            Spine::read(&path, None)
                .unwrap_err()
                .to_string()
                .contains("spine.json")
        );
        fs::write(&path, ARC.replace("\"radius\": 2", "\"radius\": -2")).unwrap();
        let said = Spine::read(&path, None).unwrap_err().to_string();
        assert!(said.contains("spine.json: radius: -2"), "{said}");
        fs::write(&path, ARC).unwrap();
        let spine = Spine::read(&path, None).unwrap();
        assert!(Spine::read(&path, Some(&spine)).is_ok());
    }
}
