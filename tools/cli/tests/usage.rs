//! Help, usage errors and what goes to which stream.
#![allow(clippy::unwrap_used)]

mod common;

use common::{data, dermis, good, stderr};

#[test]
fn every_command_has_help_with_examples() {
    let general = good(&["--help"]);
    for command in ["devices", "info"] {
        assert!(general.contains(command), "{general}");
        let help = good(&[command, "--help"]);
        assert!(help.contains("Examples:"), "{command}: {help}");
        assert!(help.contains(&format!("dermis {command}")), "{help}");
        assert!(help.contains("--json"), "{help}");
    }
    assert!(good(&["--version"]).starts_with("dermis "));
}

#[test]
fn json_on_standard_output_is_alone_there() {
    let Some(file) = data("characters/khronos/CesiumMan.glb") else {
        return;
    };
    let output = dermis(&["info", &file, "--json", "-"]);
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
        "joints",
        "clips",
        "extensions",
        "warnings",
    ];
    expected.sort_unstable();
    assert_eq!(keys, expected);
    let joints = info["joints"].as_array().unwrap();
    let owned: u64 = joints.iter().map(|j| j["vertices"].as_u64().unwrap()).sum();
    assert_eq!(Some(owned), info["vertices"].as_u64());
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

#[test]
fn usage_errors_end_with_2() {
    let cases: [&[&str]; 4] = [&[], &["bend"], &["info"], &["devices", "--json"]];
    for case in cases {
        let output = dermis(case);
        let code = output.status.code();
        assert_eq!(code, Some(2), "{case:?}: {}", stderr(&output));
        assert!(output.stdout.is_empty(), "{case:?}");
    }
}
