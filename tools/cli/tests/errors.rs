//! Bad input and bad places: one line that names the culprit, exit code 1, nothing half-written.
#![allow(clippy::unwrap_used)]

mod common;

use std::{fs, path::Path};

use common::{asset, names, refused};

/// `bake arm.glb -o OUT --device cpu …`, which must be refused and leave nothing behind.
fn refused_bake(more: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let arm = asset("arm.glb");
    refused_bake_of(&arm, folder.path(), more)
}

fn refused_bake_of(file: &str, folder: &Path, more: &[&str]) -> String {
    let out = folder.join("out");
    let before = names(folder);
    let mut args = vec!["bake", file, "-o", out.to_str().unwrap()];
    args.extend(more);
    if !more.contains(&"--device") {
        args.extend(["--device", "cpu"]);
    }
    let error = refused(&args);
    assert_eq!(names(folder), before, "nothing is left behind");
    error
}

#[test]
fn a_missing_file_is_named() {
    let error = refused(&["info", "no/such/file.glb"]);
    assert!(error.contains("no/such/file.glb"), "{error}");
}

#[test]
fn a_truncated_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let whole = fs::read(asset("arm.glb")).unwrap();
    let file = folder.path().join("cut.glb");
    for length in [0, 3, 12, 40, whole.len() / 2, whole.len() - 1] {
        fs::write(&file, &whole[..length]).unwrap();
        let error = refused_bake_of(file.to_str().unwrap(), folder.path(), &["--rest"]);
        assert!(error.contains("cut.glb"), "{length}: {error}");
    }
}

#[test]
fn an_unknown_joint_is_named() {
    let error = refused_bake(&["--joint", "knee=blend"]);
    assert!(error.contains("knee"), "{error}");
    let error = refused(&[
        "bench",
        &asset("arm.glb"),
        "--one-joint",
        "tail",
        "--device",
        "cpu",
    ]);
    assert!(error.contains("tail"), "{error}");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.png");
    let out = out.to_str().unwrap();
    let error = refused(&["render", &asset("arm.glb"), "-o", out, "--focus", "wing"]);
    assert!(error.contains("wing"), "{error}");
    let (file, above) = (asset("arm.glb"), ["--eye", "0,9,0", "--target", "0,-1,0"]);
    let error = refused(&[&["render", &file, "-o", out], &above[..]].concat());
    assert!(error.contains("upright"), "{error}");
}

#[test]
fn bad_poses_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("pose.json");
    let bad = [
        (r#"{"lower": [0, 0, 1e39, 1]}"#, "lower"),
        (r#"{"lower": [0, 0, 0, 0]}"#, "lower"),
        (r#"{"lower": [0, 0, NaN, 1]}"#, "pose.json"),
        (r#"{"lower": {"axis": [0, 0, 0], "degrees": 90}}"#, "lower"),
        (r#"{"wing": [0, 0, 0, 1]}"#, "wing"),
        (r#"{"lower": "#, "pose.json"),
    ];
    for (text, culprit) in bad {
        fs::write(&file, text).unwrap();
        let error = refused_bake(&["--pose", file.to_str().unwrap()]);
        assert!(error.contains(culprit), "{text}: {error}");
    }
}

#[test]
fn bad_primitives_are_named_with_their_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("muscles.json");
    let path = file.to_str().unwrap();
    let good = fs::read_to_string(asset("biceps.json")).unwrap();
    let bad = [
        (good.replace("\"upper\"", "\"wing\""), "joint: "),
        (good.replace("\"lower\"", "\"knee\""), "driver: "),
        (good.replace("\"lower\"", "\"upper\""), "driver: "),
        (good.replace("[0, 120]", "[120, 0]"), "degrees: "),
        (good.replace("\"scale\"", "\"size\""), "size"),
    ];
    for (text, culprit) in bad {
        fs::write(&file, &text).unwrap();
        let info = ["info", &asset("arm.glb"), "--primitives", path];
        for error in [refused_bake(&["--primitives", path]), refused(&info)] {
            for word in ["muscles.json", "\"biceps\"", culprit] {
                assert!(error.contains(word), "{text}: {error}");
            }
        }
    }
    fs::write(&file, "[{").unwrap();
    let error = refused_bake(&["--primitives", path]);
    assert!(error.contains("muscles.json"), "{error}");
    let error = refused_bake(&["--primitives", "no/muscles.json"]);
    assert!(error.contains("no/muscles.json"), "{error}");
}

#[test]
fn clips_and_frames_that_do_not_exist_are_named() {
    let error = refused_bake(&["--clip", "moonwalk"]);
    assert!(error.contains("moonwalk"), "{error}");
    let error = refused_bake(&["--rest", "--frames", "3..5"]);
    assert!(error.contains("--frames"), "{error}");
}

#[test]
fn operators_of_another_method_are_refused_by_joint() {
    let error = refused_bake(&["--method", "tracking", "--joint", "lower=blend"]);
    assert!(
        error.contains("lower") && error.contains("implicit"),
        "{error}"
    );
    let error = refused_bake(&["--joint", "lower=contact"]);
    assert!(
        error.contains("lower") && error.contains("tracking"),
        "{error}"
    );
}

#[test]
fn rigid_joints_and_controllers_name_the_joint() {
    for option in [["--rigid", "tail"], ["--controller", "tail=never"]] {
        let error = refused_bake(&[&["--method", "tracking"], &option[..]].concat());
        assert!(error.contains("tail"), "{error}");
    }
}

#[test]
fn spines_name_the_joint() {
    for (chain, named) in [
        ("upper:wing", "wing"),
        ("lower:upper", "no descendant"),
        ("wing:lower", "wing"),
    ] {
        let error = refused_bake(&["--spine", chain]);
        assert!(error.contains(named), "{error}");
    }
    let error = refused_bake(&["--spine", "upper:lower", "--spine", "lower:lower"]);
    assert!(error.contains("in two spines"), "{error}");
}

#[test]
fn bad_profiles_are_named_with_file_and_place() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("curve.json");
    let path = file.to_str().unwrap();
    let refused = |more: &[&str]| {
        let common = ["--method", "tracking", "--profile", path];
        refused_bake(&[&common[..], more].concat())
    };
    let using = ["--joint", "lower=profile"];
    assert!(refused(&using).contains("curve.json"), "it is missing");
    let good = r#"{"levels": [{"depth": 0.5, "surface": [[0, 0.5], [0.5, 0.5], [0.5, 0]]}]}"#;
    let point = "depth 0.5, surface point 1: [1.5, 0.5] is not in 0 to 1";
    for (from, to, expected) in [
        ("[0.5, 0.5]", "[1.5, 0.5]", point),
        ("0.5, 0.5", "0.5, 0.5, 0.5", "line 1 column"),
        ("surface", "face", "unknown field `face`"),
        ("]}]}", "]}]", "EOF"),
    ] {
        fs::write(&file, good.replace(from, to)).unwrap();
        let error = refused(&using);
        assert!(
            error.contains("curve.json") && error.contains(expected),
            "{error}"
        );
    }
    fs::write(&file, good).unwrap();
    let error = refused(&["--joint", "lower=bulge"]);
    assert!(
        error.contains("--profile: no joint uses it") && error.contains("=profile"),
        "{error}"
    );
    let error = refused_bake(&["--method", "tracking", "--joint", "lower=profile"]);
    assert!(error.contains("lower") && error.contains("none is given"));
}

#[test]
fn an_unknown_device_is_refused() {
    let error = refused_bake(&["--device", "no such device"]);
    assert!(
        error.contains("no such device") || error.contains("no Vulkan device"),
        "{error}"
    );
}

#[test]
fn places_that_cannot_be_written_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing/out.glb");
    let arm = asset("arm.glb");
    let error = refused(&["bake", &arm, "-o", missing.to_str().unwrap()]);
    assert!(error.contains("out.glb"), "{error}");
    let full = folder.path().join("full");
    fs::create_dir(&full).unwrap();
    fs::write(full.join("thesis.tex"), "").unwrap();
    let error = refused(&["bake", &arm, "-o", full.to_str().unwrap()]);
    assert!(error.contains("--force"), "{error}");
    assert_eq!(names(&full), ["thesis.tex"]);
    assert_eq!(names(folder.path()), ["full"]);
}

#[test]
fn a_wrong_name_of_the_output_is_explained() {
    let arm = asset("arm.glb");
    for case in [
        vec!["-o", "x.ply"],
        vec!["-o", "x.gltf"],
        vec!["-o", "x.glb", "--format", "ply"],
        vec!["-o", "x", "--format", "glb"],
    ] {
        let mut args = vec!["bake", &arm];
        args.extend(case);
        assert!(refused(&args).contains("--output"));
    }
}

#[test]
fn a_full_disk_is_named() {
    if !Path::new("/dev/full").exists() {
        eprintln!("skipped: this system has no /dev/full");
        return;
    }
    let error = refused(&["info", &asset("arm.glb"), "--json", "/dev/full"]);
    assert!(error.contains("/dev/full"), "{error}");
}

#[test]
fn a_budget_that_does_not_hold_the_character_is_refused() {
    if common::good(&["devices", "--json", "-"]).trim() == "[]" {
        eprintln!("skipped: no Vulkan device, and the CPU has no budget");
        return;
    }
    let error = refused_bake(&["--rest", "--budget", "1M", "--device", "auto"]);
    assert!(error.contains("budget of 1048576 bytes"), "{error}");
}
