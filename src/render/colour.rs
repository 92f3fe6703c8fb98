//! What colour a vertex has: by contact state, field error, bone or normal.

use std::str::FromStr;

use glam::Vec3;

use crate::{Error, Result};

/// What a picture's colours mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shading {
    /// One clay colour.
    #[default]
    Skin,
    /// The state that projection left each vertex in ([`STATES`]).
    State,
    /// Distance of the field from its rest value, |f − iso|, on a scale from 0 to [`ERROR_SCALE`]; grey where no
    /// field holds the vertex (states untouched and outside).
    Error,
    /// Part of the character that the vertex belongs to.
    Bone,
    /// Unit normals, −1..1 of each axis as 0..1 of red, green and blue.
    Normals,
}

impl Shading {
    /// Names as [`FromStr`] takes them.
    pub const NAMES: [&str; 5] = ["skin", "state", "error", "bone", "normals"];
}

impl FromStr for Shading {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        match name {
            "skin" => Ok(Self::Skin),
            "state" => Ok(Self::State),
            "error" => Ok(Self::Error),
            "bone" => Ok(Self::Bone),
            "normals" => Ok(Self::Normals),
            _ => Err(Error::argument(
                "shade",
                format!("{name:?} is none of {}", Self::NAMES.join(", ")),
            )),
        }
    }
}

/// Field error that has the last colour of the scale; larger errors have it too.
pub const ERROR_SCALE: f32 = 5e-3;

/// Names of the states, by number.
pub const STATES: [&str; 6] = [
    "untouched",
    "on iso-value",
    "contact",
    "outside",
    "limit",
    "spine's limit",
];

/// Lightness, chroma and hue (degrees) in OKLCH of each state.
const STATE_COLOURS: [[f32; 3]; 6] = [
    [0.72, 0.0, 0.0],
    [0.84, 0.045, 65.0],
    [0.74, 0.165, 55.0],
    [0.60, 0.14, 255.0],
    [0.55, 0.22, 27.0],
    [0.42, 0.16, 310.0],
];

/// Lightness falls steadily, so that the order of the scale survives shading and colour blindness.
const ERROR_RAMP: [[f32; 3]; 6] = [
    [0.93, 0.020, 110.0],
    [0.87, 0.120, 95.0],
    [0.76, 0.160, 65.0],
    [0.62, 0.190, 35.0],
    [0.47, 0.180, 15.0],
    [0.32, 0.130, -25.0],
];

const CLAY: [f32; 3] = [0.80, 0.042, 58.0];

/// Per-vertex columns of a deformed skin; a shading reads only those that it shows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Attributes<'a> {
    /// Unit normals; their number is the number of vertices.
    pub normals: &'a [Vec3],
    /// Field value of each vertex.
    pub field: &'a [f32],
    /// Field value of each vertex at rest.
    pub iso: &'a [f32],
    /// State of each vertex, an index of [`STATES`].
    pub state: &'a [u8],
    /// Joint row of each vertex's part.
    pub bone: &'a [u16],
}

/// Linear RGB of each vertex. Fails where a column that `shading` reads has another length than `normals`.
pub fn colours(shading: Shading, skin: &Attributes) -> Result<Vec<Vec3>> {
    let count = skin.normals.len();
    let expect = |name: &str, len: usize| match len == count {
        true => Ok(()),
        false => Err(Error::argument(
            name,
            format!("{len} rows for {count} vertices"),
        )),
    };
    Ok(match shading {
        Shading::Skin => vec![oklch(CLAY); count],
        Shading::State => {
            expect("state", skin.state.len())?;
            skin.state.iter().map(|&s| state_colour(s)).collect()
        }
        Shading::Error => {
            expect("field", skin.field.len())?;
            expect("iso", skin.iso.len())?;
            expect("state", skin.state.len())?;
            let error = |v: usize| match skin.state[v] {
                0 | 3 => state_colour(0),
                _ => error_colour((skin.field[v] - skin.iso[v]).abs()),
            };
            (0..count).map(error).collect()
        }
        Shading::Bone => {
            expect("bone", skin.bone.len())?;
            skin.bone.iter().map(|&b| bone_colour(b)).collect()
        }
        Shading::Normals => skin.normals.iter().map(|n| (n + 1.0) / 2.0).collect(),
    })
}

/// Colour of a state; what is no state looks like the last.
pub(super) fn state_colour(state: u8) -> Vec3 {
    let last = STATE_COLOURS.len() - 1;
    oklch(STATE_COLOURS[(state as usize).min(last)])
}

/// Colour of an absolute field error; one that is not finite looks like the largest.
pub(super) fn error_colour(error: f32) -> Vec3 {
    let last = ERROR_RAMP.len() - 1;
    let share = if error.is_nan() {
        1.0
    } else {
        error / ERROR_SCALE
    };
    let at = share.clamp(0.0, 1.0) * last as f32;
    let i = (at as usize).min(last - 1);
    let (a, b) = (Vec3::from(ERROR_RAMP[i]), Vec3::from(ERROR_RAMP[i + 1]));
    oklch(a.lerp(b, at - i as f32).to_array())
}

/// Colour of a bone: hues by the golden angle, so that neighbours in the list differ, in three lightnesses.
pub(super) fn bone_colour(bone: u16) -> Vec3 {
    const GOLDEN_ANGLE: f32 = 137.507_77;
    let lightness = [0.74, 0.62, 0.84][bone as usize % 3];
    oklch([lightness, 0.12, (bone as f32 * GOLDEN_ANGLE) % 360.0])
}

/// Linear RGB, clipped to the display's gamut, of lightness, chroma and hue in degrees (Ottosson 2020, OKLab).
fn oklch([lightness, chroma, hue]: [f32; 3]) -> Vec3 {
    let (sin, cos) = hue.to_radians().sin_cos();
    let (a, b) = (chroma * cos, chroma * sin);
    let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let m = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
    let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    Vec3::new(
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    )
    .clamp(Vec3::ZERO, Vec3::ONE)
}

/// 8-bit sRGB of a linear colour.
pub(super) fn encode(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|c| {
        let c = c.clamp(0.0, 1.0);
        let encoded = if c <= 0.003_130_8 {
            12.92 * c
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        };
        (encoded * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn luminance(c: Vec3) -> f32 {
        c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
    }

    #[test]
    fn oklch_gives_the_known_primaries() {
        let red = oklch([0.627_955, 0.257_683, 29.234]);
        assert!(red.distance(Vec3::X) < 2e-3, "{red}");
        assert!(oklch([1.0, 0.0, 0.0]).distance(Vec3::ONE) < 1e-3);
        assert_eq!(encode(Vec3::new(1.0, 0.0, 0.215_861)), [255, 0, 128]);
    }

    #[test]
    fn the_error_ramp_darkens_steadily_and_saturates() {
        let steps = (0..=50).map(|i| luminance(error_colour(ERROR_SCALE * i as f32 / 50.0)));
        let steps: Vec<f32> = steps.collect();
        assert!(steps.windows(2).all(|w| w[1] < w[0]), "{steps:?}");
        assert_eq!(error_colour(1.0), error_colour(ERROR_SCALE));
        assert_eq!(error_colour(f32::NAN), error_colour(ERROR_SCALE));
    }

    #[test]
    fn states_and_neighbouring_bones_are_told_apart() {
        let apart = |a: Vec3, b: Vec3| {
            let difference = |i: usize| encode(a)[i].abs_diff(encode(b)[i]) as u32;
            (0..3).map(difference).sum::<u32>() > 40
        };
        for a in 0..6 {
            assert!((0..a).all(|b| apart(state_colour(a), state_colour(b))));
        }
        for bone in 0..80 {
            assert!((1..6).all(|d| apart(bone_colour(bone), bone_colour(bone + d))));
        }
    }

    #[test]
    fn only_vertices_that_a_field_holds_have_an_error() {
        let skin = Attributes {
            normals: &[Vec3::Z; 4],
            field: &[0.5, 0.5, 0.5, 0.5],
            iso: &[0.4, 0.4, 0.4, 0.5],
            state: &[0, 3, 1, 1],
            bone: &[],
        };
        let grey = state_colour(0);
        let expected = [grey, grey, error_colour(0.1), error_colour(0.0)];
        let found = colours(Shading::Error, &skin).unwrap();
        let near = |(a, b): (&Vec3, Vec3)| a.distance(b) < 1e-4;
        assert!(found.iter().zip(expected).all(near), "{found:?}");
    }

    #[test]
    fn a_short_column_is_refused_by_name() {
        let normals = [Vec3::Z; 3];
        let skin = Attributes {
            normals: &normals,
            state: &[0, 1],
            ..Default::default()
        };
        assert_eq!(colours(Shading::Skin, &skin).unwrap().len(), 3);
        let message = colours(Shading::State, &skin).unwrap_err().to_string();
        assert_eq!(message, "state: 2 rows for 3 vertices");
    }
}
