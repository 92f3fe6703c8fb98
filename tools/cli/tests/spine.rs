//! A chain of joints that bends by fleshing.
#![allow(clippy::unwrap_used)]

mod common;

use std::{fs, path::Path};

use common::{asset, good};
use glam::DVec3;

/// Volume that an OBJ's triangles enclose.
fn volume(path: &Path) -> f64 {
    let text = fs::read_to_string(path).unwrap();
    let mut positions = Vec::new();
    let mut sum = 0.0;
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let x: Vec<f64> = words.take(3).map(|w| w.parse().unwrap()).collect();
                positions.push(DVec3::from_slice(&x));
            }
            Some("f") => {
                let row = |w: &str| w.split('/').next().unwrap().parse::<usize>().unwrap() - 1;
                let [a, b, c] = [0; 3].map(|_| positions[row(words.next().unwrap())]);
                sum += a.dot(b.cross(c)) / 6.0;
            }
            _ => (),
        }
    }
    sum
}

#[test]
fn a_tail_keeps_its_volume_by_every_method_and_map() {
    let folder = tempfile::tempdir().unwrap();
    let tail = asset("tail.glb");
    let baked = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let to = out.to_str().unwrap();
        let args = ["bake", &tail, "--format", "obj", "-o", to, "--quiet"];
        good(&[&args[..], more].concat());
        volume(&out.join("frame_0000.obj"))
    };
    let bent = ["--clip", "lift", "--fps", "30", "--frames", "15..16"];
    let rest = baked(
        "rest",
        &["--clip", "lift", "--fps", "30", "--frames", "0..1"],
    );
    let change = |name: &str, more: &[&str]| baked(name, &[&bent[..], more].concat()) / rest - 1.0;
    let plain = change("plain", &["--method", "dqs"]);
    // The stump that holds the tail bends at the seam, by its own method.
    assert!(plain.abs() > 0.06, "{plain}");
    for map in ["radial", "normal", "binormal"] {
        let spine = format!("tail_1:tail_8={map}");
        for method in ["lbs", "dqs", "implicit", "tracking"] {
            let name = format!("{map}-{method}");
            let change = change(&name, &["--method", method, "--spine", &spine]);
            assert!(change.abs() < 0.025, "{map} {method}: {change} for {plain}");
        }
    }
}
