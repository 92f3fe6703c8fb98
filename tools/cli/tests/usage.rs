//! Help, usage errors and what goes to which stream.
#![allow(clippy::unwrap_used)]

mod common;

use common::{asset, dermis, good, stderr};

#[test]
fn every_command_has_help_with_examples() {
    let general = good(&["--help"]);
    for command in ["devices", "info", "bake", "render", "bench", "profile"] {
        assert!(general.contains(command), "{general}");
        let help = good(&[command, "--help"]);
        assert!(help.contains("Examples:"), "{command}: {help}");
        assert!(help.contains(&format!("dermis {command}")), "{help}");
        assert!(help.contains("--json"), "{help}");
    }
    assert!(good(&["--version"]).starts_with("dermis "));
}

#[test]
fn commands_that_deform_share_their_options() {
    let shared = [
        "--device",
        "--validation",
        "--budget",
        "--method",
        "--clip",
        "--fps",
        "--frames",
        "--pose",
        "--joint",
        "--opening",
        "--controller",
        "--profile",
        "--rigid",
        "--magnitude",
        "--primitives",
        "--subdivide",
        "--cache",
        "--json",
        "--quiet",
    ];
    for command in ["bake", "render", "bench", "profile"] {
        let help = good(&[command, "--help"]);
        for option in shared {
            assert!(help.contains(option), "{command} {option}: {help}");
        }
    }
}

#[test]
fn usage_errors_end_with_2() {
    let cases: [&[&str]; 11] = [
        &[],
        &["bend"],
        &["bake", "a.glb"],
        &["bake", "a.glb", "-o", "x", "--method", "magic"],
        &["bake", "a.glb", "-o", "x", "--frames", "5..2"],
        &["bake", "a.glb", "-o", "x", "--joint", "elbow=glue"],
        &["bake", "a.glb", "-o", "x", "--opening", "elbow=1:1,0:0,2:1"],
        &[
            "bake",
            "a.glb",
            "-o",
            "x",
            "--controller",
            "elbow=0:1,1:2,2:0",
        ],
        &["bake", "a.glb", "-o", "x", "--fps", "nan"],
        &["bake", "a.glb", "-o", "x", "--budget", "much"],
        &["bake", "a.glb", "-o", "x", "--rest", "--clip", "walk"],
    ];
    for case in cases {
        let output = dermis(case);
        assert_eq!(
            output.status.code(),
            Some(2),
            "{case:?}: {}",
            stderr(&output)
        );
        assert!(output.stdout.is_empty(), "{case:?}");
    }
}

#[test]
fn json_on_standard_output_is_alone_there() {
    let output = dermis(&["info", &asset("arm.glb"), "--json", "-"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let info: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(
        stderr(&output).contains("vertices"),
        "the text is on stderr"
    );
    let keys: Vec<&str> = info
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    let mut expected = [
        "file",
        "vertices",
        "welded_vertices",
        "triangles",
        "components",
        "rigid_vertices",
        "spines",
        "joints",
        "clips",
        "extensions",
        "primitives",
        "warnings",
    ];
    expected.sort_unstable();
    assert_eq!(keys, expected);
    let joints = info["joints"].as_array().unwrap();
    let owned: u64 = joints.iter().map(|j| j["vertices"].as_u64().unwrap()).sum();
    assert_eq!(Some(owned), info["vertices"].as_u64());
}

#[test]
fn info_lists_primitives() {
    let (arm, file) = (asset("arm.glb"), asset("biceps.json"));
    let text = good(&["info", &arm, "--fields", "--primitives", &file]);
    let fields = "3 fields, 1 of them a primitive's";
    assert!(
        text.contains("primitive \"biceps\"") && text.contains(fields),
        "{text}"
    );
    let json = good(&["info", &arm, "--primitives", &file, "--json", "-"]);
    let info: serde_json::Value = serde_json::from_str(&json).unwrap();
    let expected = serde_json::json!([{"name": "biceps", "joint": "upper", "driver": "lower"}]);
    assert_eq!(info["primitives"], expected);
}

#[test]
fn quiet_says_nothing() {
    let output = dermis(&["info", &asset("arm.glb"), "--quiet"]);
    assert!(output.status.success());
    assert!(output.stdout.is_empty() && output.stderr.is_empty());
}

#[test]
fn a_closed_pipe_is_no_error() {
    use std::process::{Command, Stdio};
    let mut child = Command::new(env!("CARGO_BIN_EXE_dermis"))
        .args(["info", &asset("arm.glb")])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(output.stderr.is_empty(), "{}", stderr(&output));
}

#[test]
fn devices_are_listed_with_the_cpu_last() {
    let text = good(&["devices"]);
    assert!(text.lines().last().unwrap().starts_with("cpu"), "{text}");
    let json = good(&["devices", "--json", "-"]);
    let devices: serde_json::Value = serde_json::from_str(&json).unwrap();
    for device in devices.as_array().unwrap() {
        assert!(device["name"].is_string(), "{device}");
    }
}
