//! `dermis sphere-mesh rain`: what falls, where it goes, and what is refused.
#![allow(clippy::unwrap_used)]

mod common;

use std::{fs, path::Path};

use common::{asset, good, names, refused};
use serde_json::Value;

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A walk as a sphere-mesh.
fn walk(folder: &Path) -> String {
    let dsm = folder.join("walk.dsm");
    let file = asset("mannequin.glb");
    let clip = ["--clip", "walk", "--fps", "6", "-q"];
    let words = ["sphere-mesh", "build", &file, "-o", text(&dsm)];
    good(&[&words[..], &clip].concat());
    text(&dsm).to_owned()
}

#[test]
fn rain_bounces_off_a_walk_and_is_drawn() {
    if std::env::var("DERMIS_NO_GPU").is_ok_and(|v| v == "1") {
        eprintln!("skipped: DERMIS_NO_GPU=1");
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let dsm = walk(dir.path());
    let rain = |output: &str, more: &[&str]| -> Value {
        let words = ["sphere-mesh", "rain", &dsm, "--spheres", "20", "-o", output];
        let small = [
            "--size",
            "96x96",
            "--fps",
            "10",
            "--seconds",
            "1",
            "--json",
            "-",
            "-q",
        ];
        serde_json::from_str(&good(&[&words[..], &small, more].concat())).unwrap()
    };
    let (one, three) = (dir.path().join("one.png"), dir.path().join("three.png"));
    let (again, folder) = (dir.path().join("again.png"), dir.path().join("all"));
    let report = rain(text(&one), &["--validation", "--particles", "3000"]);
    assert_eq!(
        (&report["frames"], &report["spheres"]),
        (&10.into(), &20.into())
    );
    let contacts = report["contacts"].as_u64().unwrap();
    assert!(contacts > 100, "{report}");
    // The same rain again, and another.
    let same = rain(text(&again), &["--particles", "3000"]);
    assert_eq!(same["contacts"], contacts);
    assert_eq!(fs::read(&one).unwrap(), fs::read(&again).unwrap());
    let other = rain(
        text(&again),
        &["--particles", "3000", "--seed", "2", "--force"],
    );
    assert_ne!(other["contacts"], contacts);
    assert_ne!(fs::read(&one).unwrap(), fs::read(&again).unwrap());
    // Three moments make one sheet of one row; a folder has a file a frame.
    rain(
        text(&three),
        &["--moments", "3", "--loop", "--particles", "100"],
    );
    let width = |path: &Path| {
        let bytes = fs::read(path).unwrap();
        u32::from_be_bytes(bytes[16..20].try_into().unwrap())
    };
    assert_eq!(width(&one), 96);
    assert!(width(&three) > 3 * 96);
    rain(text(&folder), &["--particles", "100", "--device", "cpu"]);
    assert_eq!(names(&folder).len(), 10);
}

#[test]
fn what_cannot_rain_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let dsm = walk(dir.path());
    let rain = |more: &[&str]| {
        let words = ["sphere-mesh", "rain", &dsm, "-o"];
        refused(&[&words[..], more].concat())
    };
    let out = dir.path().join("rain.png");
    let out = text(&out);
    assert!(
        rain(&[out, "--spheres", "20", "--restitution", "1.5"])
            .contains("restitution: 1.5, not from 0 to 1")
    );
    assert!(rain(&[out, "--spheres", "0"]).contains("spheres"));
    assert!(rain(&["rain.gif", "--spheres", "20"]).contains(".png"));
    let missing = refused(&["sphere-mesh", "rain", "no.dsm", "--spheres", "2", "-o", out]);
    assert!(missing.contains("no.dsm"), "{missing}");
    assert_eq!(names(dir.path()), ["walk.dsm"]);
    let help = good(&["sphere-mesh", "rain", "--help"]);
    assert!(
        help.contains("Examples:") && help.contains("--json"),
        "{help}"
    );
}
