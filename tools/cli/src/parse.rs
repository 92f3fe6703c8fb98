//! Value parsers of the command line: each turns one argument into a value or into a sentence that says what is wrong.

use std::{ops::Range, str::FromStr};

use dermis::{
    Error,
    compose::{Controller, OpeningCurve, Operator},
    flesh::Map,
    rig::SpineChain,
};
use glam::Vec3;

/// The device that the user asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum DeviceChoice {
    /// The best Vulkan device, else the CPU.
    Auto,
    /// The twins on the CPU.
    Cpu,
    /// Number in the list of `dermis devices`.
    Index(usize),
    /// Part of the name, whatever the case.
    Name(String),
}

impl FromStr for DeviceChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "" => Err("expected auto, cpu, a number or a part of a device's name".into()),
            "auto" => Ok(Self::Auto),
            "cpu" => Ok(Self::Cpu),
            other => Ok(other
                .parse()
                .map_or_else(|_| Self::Name(other.into()), Self::Index)),
        }
    }
}

/// Bytes with an optional binary unit: `4096`, `512K`, `64M`, `1.5G`.
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match text[digits.len()..].to_ascii_uppercase().as_str() {
        "" | "B" => 1.0,
        "K" | "KB" | "KIB" => 1024.0,
        "M" | "MB" | "MIB" => 1024.0 * 1024.0,
        "G" | "GB" | "GIB" => 1024.0 * 1024.0 * 1024.0,
        other => return Err(format!("unknown unit {other:?}: use K, M or G")),
    };
    match digits.trim().parse::<f64>() {
        Ok(number) if number.is_finite() && number >= 0.0 => Ok((number * unit) as u64),
        _ => Err("expected a number of bytes such as 4096, 512K, 64M or 1.5G".into()),
    }
}

/// Frames `A..B` (B not included) or `A..=B`.
pub(crate) fn frames(text: &str) -> Result<Range<usize>, String> {
    let usage = || "expected A..B (B not included) or A..=B, such as 0..30".to_string();
    let (first, last) = text.split_once("..").ok_or_else(usage)?;
    let number = |part: &str| part.trim().parse::<usize>().map_err(|_| usage());
    let end = match last.strip_prefix('=') {
        Some(inclusive) => number(inclusive)?.checked_add(1).ok_or_else(usage)?,
        None => number(last)?,
    };
    let range = number(first)?..end;
    if range.is_empty() {
        return Err(format!("{text} holds no frame"));
    }
    Ok(range)
}

/// A number from 0 to 1.
pub(crate) fn share(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok();
    let share = number.filter(|x| (0.0..=1.0).contains(x));
    share.ok_or_else(|| "expected a number from 0 to 1".into())
}

/// Width and height in pixels, `640x480`.
pub(crate) fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |part: &str| part.trim().parse().ok().filter(|&n: &u32| n > 0);
    let sides = text.split_once(['x', '×']);
    let size = sides.and_then(|(width, height)| side(width).zip(side(height)));
    size.ok_or_else(|| "expected WIDTHxHEIGHT in pixels, such as 640x480".into())
}

/// `NAME=union|blend|bulge|contact|profile`.
pub(crate) fn joint(text: &str) -> Result<(String, Operator), String> {
    const NAMES: &str = "union, blend, bulge, contact or profile";
    let (name, operator) = assignment(text, NAMES)?;
    let all = [
        Operator::Union,
        Operator::Blend,
        Operator::Bulge,
        Operator::Contact,
        Operator::Profile,
    ];
    let known = all.into_iter().find(|o| o.name() == operator);
    let operator = known.ok_or_else(|| format!("unknown operator {operator:?}: use {NAMES}"))?;
    Ok((name.into(), operator))
}

/// `NAME=elbow|finger|b:F,b:F,b:F`.
pub(crate) fn opening(text: &str) -> Result<(String, OpeningCurve), String> {
    const USAGE: &str = "elbow, finger or three points b:F,b:F,b:F";
    let (name, curve) = assignment(text, USAGE)?;
    let curve = match curve {
        "elbow" => OpeningCurve::elbow(),
        "finger" => OpeningCurve::finger(),
        text => OpeningCurve::new(points(text, USAGE)?, [1.0; 2]).map_err(refused(text))?,
    };
    Ok((name.into(), curve))
}

/// `NAME=elbow|finger|fold|never|c:d,c:d,c:d`.
pub(crate) fn controller(text: &str) -> Result<(String, Controller), String> {
    const USAGE: &str = "elbow, finger, fold, never or three points c:d,c:d,c:d";
    let (name, curve) = assignment(text, USAGE)?;
    let curve = match curve {
        "elbow" => Controller::elbow(),
        "finger" => Controller::finger(),
        "fold" => Controller::fold(),
        "never" => Controller::never(),
        text => Controller::new(points(text, USAGE)?, [1.0; 2]).map_err(refused(text))?,
    };
    Ok((name.into(), curve))
}

/// `ROOT:TIP[=radial|normal|binormal]`. Names of joints may have colons, equally many: the one in the middle is ours.
pub(crate) fn spine(text: &str) -> Result<SpineChain, String> {
    let (chain, map) = match text.rsplit_once('=') {
        None => (text, Map::Radial),
        Some((chain, "radial")) => (chain, Map::Radial),
        Some((chain, "normal")) => (chain, Map::Normal),
        Some((chain, "binormal")) => (chain, Map::Binormal),
        Some((_, map)) => {
            return Err(format!(
                "unknown map {map:?}: use radial, normal or binormal"
            ));
        }
    };
    let colons: Vec<usize> = chain.match_indices(':').map(|(at, _)| at).collect();
    let middle = colons
        .get(colons.len() / 2)
        .filter(|_| colons.len() % 2 == 1);
    let ends = middle.map(|at| (&chain[..*at], &chain[at + 1..]));
    match ends.filter(|(root, tip)| !root.is_empty() && !tip.is_empty()) {
        Some((root, tip)) => Ok(SpineChain {
            root: root.into(),
            tip: tip.into(),
            map,
        }),
        None => Err("expected two joints ROOT:TIP, such as tail_1:tail_6".into()),
    }
}

fn refused(text: &str) -> impl Fn(Error) -> String {
    move |error| format!("{text:?}: {error}")
}

fn points(text: &str, usage: &str) -> Result<[(f32, f32); 3], String> {
    let points: Vec<(f32, f32)> = text.split(',').map(point).collect::<Result<_, _>>()?;
    points
        .try_into()
        .map_err(|_| format!("{text:?}: expected {usage}"))
}

fn point(text: &str) -> Result<(f32, f32), String> {
    let wrong = || format!("{text:?}: expected a cosine and a value from 0 to 1, such as .7:.43");
    let (cosine, value) = text.split_once(':').ok_or_else(wrong)?;
    let cosine: f32 = cosine.trim().parse().map_err(|_| wrong())?;
    let value: f32 = value.trim().parse().map_err(|_| wrong())?;
    Ok((cosine, value))
}

fn assignment<'a>(text: &'a str, expected: &str) -> Result<(&'a str, &'a str), String> {
    match text.rsplit_once('=') {
        Some((name, value)) if !name.is_empty() && !value.is_empty() => Ok((name, value)),
        _ => Err(format!("expected NAME={expected}")),
    }
}

/// A point `X,Y,Z`.
pub(crate) fn place(text: &str) -> Result<Vec3, String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    let place = numbers.ok().and_then(|n| <[f32; 3]>::try_from(n).ok());
    let place = place.map(Vec3::from).filter(|p| p.is_finite());
    place.ok_or_else(|| "expected three numbers X,Y,Z, such as 0,1.5,-4".into())
}

/// A finite number above 0.
pub(crate) fn positive(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err("expected a number above 0".into()),
    }
}

/// A finite number of at least 0.
pub(crate) fn not_negative(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(number) if number.is_finite() && number >= 0.0 => Ok(number),
        _ => Err("expected a number of at least 0".into()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn bytes_take_binary_units_and_refuse_nonsense() {
        assert_eq!(bytes("4096"), Ok(4096));
        assert_eq!(bytes("1M"), Ok(1 << 20));
        assert_eq!(bytes("1.5g"), Ok(3 << 29));
        for wrong in ["", "-1", "nan", "3X", "M", "inf"] {
            assert!(bytes(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn frames_are_half_open_or_inclusive_and_never_empty() {
        assert_eq!(frames("2..5"), Ok(2..5));
        assert_eq!(frames("2..=5"), Ok(2..6));
        for wrong in [
            "",
            "3",
            "5..2",
            "2..2",
            "a..b",
            "-1..2",
            "0..=18446744073709551615",
        ] {
            assert!(frames(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn joints_name_an_operator() {
        assert_eq!(joint("a=b=blend"), Ok(("a=b".into(), Operator::Blend)));
        assert_eq!(joint("a=contact"), Ok(("a".into(), Operator::Contact)));
        assert!(joint("elbow=glue").unwrap_err().contains("contact"));
        assert!(joint("elbow").is_err() && joint("=blend").is_err() && joint("elbow=").is_err());
    }

    #[test]
    fn openings_are_presets_or_three_rising_points() {
        let (name, curve) = opening("elbow.L=-1:1,.2:.3,.75:1").unwrap();
        assert_eq!(name, "elbow.L");
        assert_eq!(curve.points, [(-1.0, 1.0), (0.2, 0.3), (0.75, 1.0)]);
        assert!(opening("a=elbow").is_ok() && opening("a=finger").is_ok());
        for wrong in [
            "a=knee",
            "a=1:1,0:1,2:1",
            "a=0:2,1:1,2:1",
            "a=0:1,1:1",
            "a=nan:1,1:1,2:1",
        ] {
            assert!(opening(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn controllers_are_presets_or_three_rising_points() {
        let (name, curve) = controller("elbow.L=-1:1,.2:.3,.75:0").unwrap();
        assert_eq!(name, "elbow.L");
        assert_eq!(curve.points, [(-1.0, 1.0), (0.2, 0.3), (0.75, 0.0)]);
        assert_eq!(controller("a=never").unwrap().1, Controller::never());
        assert!(controller("a=elbow").is_ok() && controller("a=finger").is_ok());
        for wrong in ["a=knee", "a=1:1,0:1,2:1", "a=0:2,1:1,2:1", "a=0:1,1:1", "a"] {
            assert!(controller(wrong).is_err(), "{wrong}");
        }
        assert!(controller("a=0:1,1:0").unwrap_err().contains("never"));
    }

    #[test]
    fn sizes_have_two_sides_of_at_least_a_pixel() {
        assert_eq!(size("640x480"), Ok((640, 480)));
        for wrong in ["640", "0x5", "5x", "-1x4", "axb", "1x2x3"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn places_are_three_numbers() {
        assert_eq!(place("-1, 2.5,3"), Ok(Vec3::new(-1.0, 2.5, 3.0)));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,nan", "1;2;3"] {
            assert!(place(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn devices_are_words_numbers_or_names() {
        assert_eq!("auto".parse(), Ok(DeviceChoice::Auto));
        assert_eq!("cpu".parse(), Ok(DeviceChoice::Cpu));
        assert_eq!("1".parse(), Ok(DeviceChoice::Index(1)));
        assert_eq!(
            "llvmpipe".parse(),
            Ok(DeviceChoice::Name("llvmpipe".into()))
        );
        assert!("".parse::<DeviceChoice>().is_err());
    }
}
