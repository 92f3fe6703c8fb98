//! Extra implicit primitives as the user describes them: a biceps that swells as the elbow bends (2014, section 6.2).

use std::{collections::BTreeSet, path::Path};

use serde_json::Value;

use super::Skeleton;
use crate::{Error, Result};

/// An ellipsoid that a joint carries and that swells with the bend of another.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Primitive {
    /// Unique name.
    pub name: String,
    /// Joint that carries it.
    pub joint: String,
    /// One end of its axis, from the joint's origin along the joint's axes, in units of the file.
    pub start: [f32; 3],
    /// The other end.
    pub end: [f32; 3],
    /// Half its thickness in the middle, in units of the file.
    pub radius: f32,
    /// Joint whose bend swells it: the angle of that joint's rotation against its parent since rest.
    pub driver: String,
    /// From the first bend to the second, in degrees from 0 to 180, it goes from the first scale to the second.
    pub degrees: [f32; 2],
    /// Scales across its axis. It has the first already at rest where the first bend is 0.
    pub scale: [f32; 2],
    /// Scale along its axis at the second bend, from 1 at the first; 1 where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along: Option<f32>,
}

impl Primitive {
    /// Reads a list of primitives from a JSON file, and checks all of them that can be checked without a character.
    ///
    /// # Errors
    /// [`Error::File`] where it cannot be read; [`Error::Asset`] naming file, primitive and element for all that is wrong.
    pub fn read(path: &Path) -> Result<Vec<Self>> {
        let bytes = std::fs::read(path).map_err(|e| Error::file(path, e))?;
        let json: Value = serde_json::from_slice(&bytes)
            .map_err(|e| Error::asset(path, "JSON", e.to_string()))?;
        let Value::Array(list) = json else {
            let reason = "a list of primitives is wanted";
            return Err(Error::asset(path, "JSON", reason));
        };
        let parse = |(row, value): (usize, Value)| {
            let name = value["name"].as_str();
            let element = name.map_or(format!("primitive {row}"), |n| format!("primitive {n:?}"));
            serde_json::from_value(value).map_err(|e| Error::asset(path, element, e.to_string()))
        };
        let list: Vec<Self> = list
            .into_iter()
            .enumerate()
            .map(parse)
            .collect::<Result<_>>()?;
        check_numbers(&list).map_err(|e| e.in_file(path))?;
        Ok(list)
    }

    /// Checks primitives against the skeleton that is to carry them.
    ///
    /// # Errors
    /// [`Error::Primitive`] naming primitive and element for a name used twice, joints that do not exist, a driver without a
    /// parent, numbers that are not finite or out of range, an axis without length.
    pub fn check(list: &[Self], skeleton: &Skeleton) -> Result<()> {
        check_numbers(list)?;
        for primitive in list {
            let find = |element, name: &str| {
                let found = skeleton.find(name);
                found.map_err(|e| primitive.wrong(element, e.to_string()))
            };
            find("joint", &primitive.joint)?;
            let driver = find("driver", &primitive.driver)?;
            if skeleton.joints[driver].parent.is_none() {
                let reason = format!("joint {:?} has no parent to bend against", primitive.driver);
                return Err(primitive.wrong("driver", reason));
            }
        }
        Ok(())
    }

    /// An error that names this primitive.
    pub(super) fn wrong(&self, element: &'static str, reason: impl Into<String>) -> Error {
        Error::Primitive {
            primitive: self.name.clone(),
            element,
            reason: reason.into(),
        }
    }

    fn check_own(&self) -> Result<()> {
        let finite = |element, numbers: &[f32]| match numbers.iter().find(|x| !x.is_finite()) {
            Some(x) => Err(self.wrong(element, format!("{x} is not a finite number"))),
            None => Ok(()),
        };
        let positive = |element, numbers: &[f32]| match numbers.iter().find(|x| **x <= 0.0) {
            Some(x) => Err(self.wrong(element, format!("{x} is not above 0"))),
            None => Ok(()),
        };
        let along = self.along.as_slice();
        finite("start", &self.start)?;
        finite("end", &self.end)?;
        finite("radius", &[self.radius])?;
        finite("degrees", &self.degrees)?;
        finite("scale", &self.scale)?;
        finite("along", along)?;
        positive("radius", &[self.radius])?;
        positive("scale", &self.scale)?;
        positive("along", along)?;
        if self.start == self.end {
            return Err(self.wrong("end", "it is where the start is"));
        }
        let [first, last] = self.degrees;
        if !(0.0 <= first && first < last && last <= 180.0) {
            let reason = format!("{first} and {last} do not ascend between 0 and 180");
            return Err(self.wrong("degrees", reason));
        }
        Ok(())
    }
}

fn check_numbers(list: &[Primitive]) -> Result<()> {
    let mut names = BTreeSet::new();
    for primitive in list {
        if !names.insert(&primitive.name) {
            return Err(primitive.wrong("name", "it is used twice"));
        }
        primitive.check_own()?;
    }
    Ok(())
}

#[cfg(test)]
#[path = "primitive_tests.rs"]
pub(crate) mod tests;
