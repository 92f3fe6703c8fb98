//! `dermis sphere-mesh render`: pictures, and what is refused.
#![allow(clippy::unwrap_used)]

mod common;

use std::{fs, path::Path};

use common::{asset, good, names, refused};
use serde_json::Value;

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Width and height of a PNG.
fn size(path: &Path) -> (u32, u32) {
    let bytes = fs::read(path).unwrap();
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    (number(16), number(20))
}

/// A few frames of the bundled tail.
fn tail(folder: &Path) -> String {
    let dsm = folder.join("tail.dsm");
    let file = asset("tail.glb");
    good(&[
        "sphere-mesh",
        "build",
        &file,
        "--fps",
        "4",
        "-o",
        text(&dsm),
        "-q",
    ]);
    text(&dsm).into()
}

#[test]
fn a_level_is_drawn_in_all_styles_and_several_side_by_side() {
    let dir = tempfile::tempdir().unwrap();
    let dsm = tail(dir.path());
    let out = dir.path().join("tail.png");
    let draw = |more: &[&str]| -> Value {
        let words = ["sphere-mesh", "render", &dsm, "-o", text(&out)];
        let rest = ["--size", "120x80", "--validation", "--json", "-", "-q"];
        serde_json::from_str(&good(&[&words[..], &rest[..], more].concat())).unwrap()
    };
    let report = draw(&["--spheres", "12", "--frame", "1"]);
    assert_eq!(size(&out), (120, 80));
    assert_eq!(report["levels"][0]["spheres"], 12);
    assert_eq!(report["pictures"][0]["frame"], 1);
    assert!(report["pictures"][0]["draw_ms"].as_f64() > Some(0.0));
    let plain = fs::read(&out).unwrap();
    // The CPU draws nothing: what does is named.
    let other = draw(&["--spheres", "12", "--frame", "1", "--device", "cpu"]);
    assert_eq!(other["device"], report["device"]);
    assert_eq!(fs::read(&out).unwrap(), plain);
    draw(&["--spheres", "12", "--frame", "1", "--up", "-x"]);
    assert_ne!(fs::read(&out).unwrap(), plain);
    let all = "mesh,regions,skeleton,surface,extracted";
    draw(&[
        "--spheres",
        "12",
        "--style",
        all,
        "--cells",
        "40",
        "--orthographic",
    ]);
    let (width, height) = size(&out);
    assert!(width > 5 * 120 && height < 2 * 80, "{width} {height}");
    // The mesh once, then a surface a level.
    draw(&["--compare", "4,8,12", "--style", "mesh,surface"]);
    assert_eq!(size(&out), (width * 4 / 5 + 2, height));
    let report = draw(&["--compare", "4,8", "--style", "mesh,regions,surface"]);
    let (width, height) = size(&out);
    assert!(
        width > 3 * 120 && width < 4 * 120 && height > 2 * 80,
        "{width} {height}"
    );
    assert_eq!(report["levels"].as_array().unwrap().len(), 2);
    assert!(draw(&["--error", "1000"])["levels"][0]["spheres"].as_u64() >= Some(1));
    assert_eq!(names(dir.path()), ["tail.dsm", "tail.png"]);
}

#[test]
fn frames_and_turntables_fill_a_folder() {
    let dir = tempfile::tempdir().unwrap();
    let dsm = tail(dir.path());
    let out = dir.path().join("frames");
    let draw = |more: &[&str]| {
        let words = [
            "sphere-mesh",
            "render",
            &dsm,
            "--spheres",
            "10",
            "-o",
            text(&out),
        ];
        good(&[&words[..], &["--size", "64x64", "-q"], more].concat())
    };
    draw(&["--frames", "0..3"]);
    let name = |k: usize| format!("frame_{k:04}.png");
    assert_eq!(names(&out), [0, 1, 2].map(name));
    let pictures: Vec<_> = (0..3)
        .map(|k| fs::read(out.join(name(k))).unwrap())
        .collect();
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2]);
    draw(&[
        "--turntable",
        "2",
        "--frame",
        "1",
        "--style",
        "skeleton",
        "--force",
    ]);
    assert_eq!(names(&out), [0, 1].map(name));
}

#[test]
fn what_cannot_be_drawn_is_refused_and_leaves_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let dsm = tail(dir.path());
    let out = dir.path().join("a.png");
    let refuse = |file: &str, more: &[&str]| {
        let words = ["sphere-mesh", "render", file, "-o", text(&out)];
        refused(&[&words[..], more].concat())
    };
    assert!(refuse("missing.dsm", &["--spheres", "9"]).contains("missing.dsm"));
    assert!(refuse(&asset("tail.glb"), &["--spheres", "9"]).contains("tail.glb"));
    assert!(refuse(&dsm, &["--spheres", "0"]).contains("spheres: 0, but levels have 1"));
    assert!(refuse(&dsm, &["--compare", "5,9999999"]).contains("spheres: 9999999"));
    assert!(refuse(&dsm, &["--spheres", "9", "--frame", "900"]).contains("--frame: 900"));
    assert!(refuse(&dsm, &["--spheres", "9", "--frames", "0..900"]).contains("--frames: 0..900"));
    let cells = ["--spheres", "9", "--style", "extracted", "--cells", "2"];
    assert!(refuse(&dsm, &cells).contains("cells"));
    assert!(refuse(&dsm, &["--spheres", "9", "--size", "1x99999999"]).contains("size"));
    for (place, named) in [("nowhere/a.png", "nowhere"), ("a.gif", "--output")] {
        let error = refused(&["sphere-mesh", "render", &dsm, "--spheres", "9", "-o", place]);
        assert!(error.contains(named), "{error}");
    }
    assert_eq!(names(dir.path()), ["tail.dsm"]);
}
