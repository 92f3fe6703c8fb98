//! What is refused of primitives, and how a file of them is read.
#![allow(clippy::unwrap_used)]
use super::*;
use crate::rig::skeleton::tests::skeleton;

/// A biceps on the root of the test skeleton.
pub(crate) fn biceps() -> Primitive {
    Primitive {
        name: "biceps".into(),
        joint: "root".into(),
        start: [0.2, 0.1, 0.0],
        end: [0.8, 0.1, 0.0],
        radius: 0.15,
        driver: "elbow".into(),
        degrees: [0.0, 120.0],
        scale: [1.0, 1.5],
        along: None,
    }
}

/// What makes a primitive wrong.
type Change = fn(&mut Primitive);

fn refused(change: impl Fn(&mut Primitive)) -> String {
    let mut wrong = biceps();
    change(&mut wrong);
    let error = Primitive::check(&[wrong], &skeleton()).unwrap_err();
    assert!(matches!(error, Error::Primitive { .. }));
    error.to_string()
}

#[test]
fn wrong_primitives_are_refused_by_name_and_element() {
    assert!(Primitive::check(&[biceps()], &skeleton()).is_ok());
    let cases: [(Change, [&str; 2]); 16] = [
        (|p| p.joint = "wing".into(), ["joint", "wing"]),
        (|p| p.driver = "knee".into(), ["driver", "knee"]),
        (|p| p.driver = "root".into(), ["driver", "no parent"]),
        (|p| p.radius = 0.0, ["radius", "above 0"]),
        (|p| p.radius = -1.0, ["radius", "above 0"]),
        (|p| p.radius = f32::NAN, ["radius", "finite"]),
        (|p| p.start[1] = f32::INFINITY, ["start", "finite"]),
        (|p| p.end[2] = f32::NAN, ["end", "finite"]),
        (|p| p.end = p.start, ["end", "start"]),
        (|p| p.degrees = [90.0, 90.0], ["degrees", "ascend"]),
        (|p| p.degrees = [-10.0, 90.0], ["degrees", "ascend"]),
        (|p| p.degrees[1] = 200.0, ["degrees", "180"]),
        (|p| p.scale[0] = 0.0, ["scale", "above 0"]),
        (|p| p.scale[1] = f32::NAN, ["scale", "finite"]),
        (|p| p.along = Some(-0.5), ["along", "above 0"]),
        (|p| p.along = Some(f32::INFINITY), ["along", "finite"]),
    ];
    for (change, words) in cases {
        let error = refused(change);
        assert!(error.starts_with("primitive \"biceps\": "), "{error}");
        assert!(words.iter().all(|w| error.contains(w)), "{error}");
    }
    let twice = Primitive::check(&[biceps(), biceps()], &skeleton()).unwrap_err();
    assert!(twice.to_string().contains("name: it is used twice"));
}

#[test]
fn a_file_is_read_and_its_errors_name_file_and_primitive() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("muscles.json");
    let read = |text: &str| {
        std::fs::write(&path, text).unwrap();
        Primitive::read(&path)
    };
    let good = serde_json::to_string(&[biceps()]).unwrap();
    assert_eq!(read(&good).unwrap(), [biceps()]);
    assert!(!good.contains("along") && read("[]").unwrap().is_empty());
    let cases = [
        (good.replace("0.15", "-1"), "\"biceps\": radius"),
        (good.replace("0.15", "1e39"), "\"biceps\": radius"),
        (good.replace("radius", "width"), "\"biceps\""),
        (good.replace("\"radius\":0.15,", ""), "radius"),
        (good.replace("\"biceps\"", "7"), "primitive 0"),
        (good.replace(['[', ']'], ""), "JSON"),
        ("{}".into(), "list"),
        ("[3]".into(), "primitive 0"),
    ];
    for (text, culprit) in cases {
        let error = read(&text).unwrap_err().to_string();
        assert!(error.contains("muscles.json"), "{text}: {error}");
        assert!(error.contains(culprit), "{text}: {error}");
    }
    let missing = Primitive::read(&folder.path().join("no.json")).unwrap_err();
    assert!(missing.to_string().contains("no.json"));
}
