//! `dermis sphere-mesh rig`: from sequences to a character that the other commands take as it is.
#![allow(clippy::unwrap_used)]

mod common;

use std::{fs, path::Path};

use common::{asset, data, good, names, refused};
use dermis::{
    asset::{Room, Sequence, load_sequence},
    sphere_mesh::Hierarchy,
};
use serde_json::{Value, json};

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn report(args: &[&str]) -> Value {
    let all = [&["sphere-mesh", "rig"], args, &["--json", "-", "-q"]].concat();
    serde_json::from_str(&good(&all)).unwrap()
}

fn sequence(folder: &Path) -> Sequence {
    let room = Room {
        bytes: u64::MAX,
        need: |_| 1,
    };
    load_sequence(folder, room).unwrap()
}

/// E_RMS of what was played against what was captured, over welded vertices.
fn error(captured: &Sequence, played: &Sequence, hierarchy: &Hierarchy) -> f64 {
    assert_eq!(captured.frames.len(), played.frames.len());
    let mut first = vec![usize::MAX; hierarchy.vertices];
    for (row, &vertex) in hierarchy.vertex.iter().enumerate().rev() {
        first[vertex as usize] = row;
    }
    let mut sum = 0.0;
    for (a, b) in captured.frames.iter().zip(&played.frames) {
        let squares = first.iter().map(|&row| a[row].distance_squared(b[row]));
        sum += squares.map(f64::from).sum::<f64>();
    }
    let count = 3 * first.len() * captured.frames.len();
    2000.0 * (sum / count as f64).sqrt() / hierarchy.diagonal
}

#[test]
fn a_clip_becomes_a_character_that_plays_it() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let (arm, dsm, glb) = (asset("arm.glb"), at("arm.dsm"), at("rig.glb"));
    let (dsm, glb) = (text(&dsm), text(&glb));
    let captured = at("captured");
    let lbs = ["--method", "lbs", "--device", "cpu", "--fps", "10", "-o"];
    good(&[&["bake", &arm], &lbs[..], &[text(&captured)]].concat());
    good(&["sphere-mesh", "build", text(&captured), "-o", dsm]);
    let captured_twice = [text(&captured), text(&captured)];
    let rate = ["--spheres", "6", "-o", glb, "--fps", "10"];
    let result = report(&[&[dsm], &captured_twice[..], &rate[..]].concat());
    let e_rms = result["e_rms"].as_f64().unwrap();
    assert!(e_rms > 0.0 && e_rms < 10.0, "{result}");
    assert_eq!(result["clips"][1]["name"], "captured_2");
    assert_eq!(result["joints"].as_array().unwrap().len(), 6);
    assert!(result["iterations"].as_u64().unwrap() > 0);
    let frames = names(&captured).len();
    assert_eq!(result["clips"][0]["mse"].as_array().unwrap().len(), frames);
    assert_eq!(result["frames"], 2 * frames);

    let played = at("played");
    let clip = ["bake", glb, "--clip", "captured_2"];
    good(&[&clip[..], &lbs[..], &[text(&played)]].concat());
    let hierarchy = Hierarchy::load(Path::new(dsm)).unwrap();
    let found = error(&sequence(&captured), &sequence(&played), &hierarchy);
    assert!((found - e_rms).abs() < 5e-3, "{found} {e_rms}");

    for method in ["implicit", "tracking"] {
        let out = at(&format!("{method}.glb"));
        let few = ["--frames", "0..2", "--fps", "10"];
        good(
            &[
                &["bake", glb, "--method", method, "-o", text(&out)],
                &few[..],
            ]
            .concat(),
        );
    }
}

#[test]
fn what_does_not_fit_is_refused_and_nothing_is_written() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let (arm, dsm, glb) = (asset("arm.glb"), at("arm.dsm"), at("rig.glb"));
    let (dsm, glb) = (text(&dsm), text(&glb));
    good(&["sphere-mesh", "build", &arm, "--fps", "4", "-o", dsm]);
    let mesh = at("other.obj");
    fs::write(&mesh, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let (mesh, text_file) = (text(&mesh), at("rig.txt"));
    let cases: [(&[&str], &str); 8] = [
        (
            &[mesh, "--spheres", "4", "-o", glb],
            "other.obj: frame 0: 3 vertices",
        ),
        (
            &[&arm, mesh, "--spheres", "4", "-o", glb],
            "other.obj: frame 0",
        ),
        (&[&arm, "--spheres", "0", "-o", glb], "spheres: 0"),
        (&[&arm, "--spheres", "99999", "-o", glb], "spheres: 99999"),
        (&[&arm, "--spheres", "4", "-o", text(&text_file)], "no .glb"),
        (
            &[&arm, "--spheres", "4", "-o", "/nowhere/rig.glb"],
            "nowhere",
        ),
        (
            &[&arm, "--spheres", "4", "--max-influences", "99", "-o", glb],
            "influences: 99",
        ),
        (
            &[&arm, "--spheres", "4", "--tolerance", "2", "-o", glb],
            "tolerance",
        ),
    ];
    for (args, word) in cases {
        let error = refused(&[&["sphere-mesh", "rig", dsm], args].concat());
        assert!(error.contains(word), "{word}: {error}");
    }
    assert_eq!(names(dir.path()), ["arm.dsm", "other.obj"]);
}

#[test]
fn captured_sequences_are_met_closer_than_by_dem_bones() {
    // Dem Bones with as many bones and 4 influences, on the file's rest pose or the first frame, has 3.5 and 6.0 to 6.9.
    for (name, spheres, most) in [("horse-gallop", "30", 2.4), ("cat-poses", "25", 5.8)] {
        let Some(rest) = data(&format!("sequences/{name}/rest.obj")) else {
            return;
        };
        let sequence = rest.trim_end_matches("/rest.obj");
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        let (dsm, glb) = (at("a.dsm"), at("a.glb"));
        let (dsm, glb) = (text(&dsm), text(&glb));
        good(&["sphere-mesh", "build", sequence, "-o", dsm]);
        let result = report(&[dsm, sequence, "--spheres", spheres, "-o", glb]);
        assert!(result["e_rms"].as_f64().unwrap() < most, "{result}");
    }
}

#[test]
fn a_captured_horse_lifts_its_leg() {
    let Some(rest) = data("sequences/horse-gallop/rest.obj") else {
        return;
    };
    let gallop = rest.trim_end_matches("/rest.obj").to_owned();
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let (dsm, glb) = (at("gallop.dsm"), at("horse.glb"));
    let (dsm, glb) = (text(&dsm), text(&glb));
    good(&["sphere-mesh", "build", &gallop, "-o", dsm]);
    let result = report(&[dsm, &gallop, "--spheres", "46", "-o", glb]);
    // Dem Bones, 46 bones and 4 influences on the file's rest pose: 2.9.
    assert!(result["e_rms"].as_f64().unwrap() < 1.75, "{result}");
    assert!(result["mse"].as_f64().unwrap() < 1.7e-6, "{result}");

    // The joint three above the front hoof.
    let joints = result["joints"].as_array().unwrap();
    let parent = |joint: &Value| {
        let named = |j: &&Value| j["name"] == joint["parent"];
        joints.iter().find(named).unwrap_or(joint).clone()
    };
    let number = |joint: &Value, k: usize| joint["origin"][k].as_f64().unwrap();
    let front = joints.iter().filter(|j| number(j, 2) > 0.3);
    let hoof = front.min_by(|a, b| number(a, 1).total_cmp(&number(b, 1)));
    let upper = parent(&parent(&parent(hoof.unwrap())));
    let pose = at("pose.json");
    let lift = json!({ upper["name"].as_str().unwrap(): { "axis": [1, 0, 0], "degrees": -40 } });
    fs::write(&pose, lift.to_string()).unwrap();
    let bake = |pose: &[&str], out: &str| {
        let out = at(out);
        good(
            &[
                &["bake", glb, "--method", "tracking", "-o", text(&out)],
                pose,
            ]
            .concat(),
        );
        sequence(&out)
    };
    let (still, lifted) = (
        bake(&["--rest"], "still"),
        bake(&["--pose", text(&pose)], "lifted"),
    );
    let ends = |s: &Sequence| s.frames.last().unwrap().clone();
    let (still, lifted) = (ends(&still), ends(&lifted));
    let far = still.iter().zip(&lifted).map(|(a, b)| a.distance(*b));
    let far: Vec<f32> = far.collect();
    let moved = far.iter().filter(|d| **d > 0.1).count();
    assert!(
        moved > 200 && moved < far.len() / 4,
        "{moved} of {}",
        far.len()
    );
    assert!(lifted.iter().all(|p| p.is_finite()));
}
