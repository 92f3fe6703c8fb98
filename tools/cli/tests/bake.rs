//! Baked files, benches and traces of real characters.
#![allow(clippy::unwrap_used)]

mod common;

use std::{fs, path::Path};

use common::{asset, data, dermis, good, names, stderr};
use glam::{Quat, Vec3};
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// Header of a PLY and the number of bytes behind it.
fn ply(path: &Path) -> (String, usize) {
    let bytes = fs::read(path).unwrap();
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    (
        String::from_utf8(bytes[..at].to_vec()).unwrap(),
        bytes.len() - at,
    )
}

#[test]
fn a_folder_gets_a_ply_a_frame() {
    let Some(file) = data("characters/khronos/SimpleSkin.gltf") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let report = good(&[
        "bake",
        &file,
        "-o",
        out.to_str().unwrap(),
        "--method",
        "lbs",
        "--frames",
        "0..3",
        "--json",
        "-",
    ]);
    assert_eq!(
        names(&out),
        ["frame_0000.ply", "frame_0001.ply", "frame_0002.ply"]
    );
    let (header, body) = ply(&out.join("frame_0002.ply"));
    assert!(
        header.contains("format binary_little_endian 1.0"),
        "{header}"
    );
    for property in ["x", "nx", "field", "iso", "state", "bone"] {
        assert!(
            header.lines().any(|l| l.ends_with(&format!(" {property}"))),
            "{header}"
        );
    }
    let comment = header.lines().find(|l| l.starts_with("comment ")).unwrap();
    for part in ["lbs", "clip_0", "0.066666"] {
        assert!(comment.contains(part), "{comment}");
    }
    // Ten vertices of 8 floats, a byte and a short; eight triangles of a count and three indices.
    assert_eq!(body, 10 * (8 * 4 + 1 + 2) + 8 * (1 + 3 * 4));
    let report = json(&report);
    assert_eq!(report["frames"].as_array().unwrap().len(), 3);
    assert_eq!(report["frames"][2]["vertices"], 10);
}

#[test]
fn a_glb_holds_the_clip_as_morph_targets() {
    let Some(file) = data("characters/khronos/CesiumMan.glb") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.glb");
    let summary = good(&[
        "bake",
        &file,
        "-o",
        out.to_str().unwrap(),
        "--frames",
        "0..4",
    ]);
    assert!(
        summary.contains("4 frames") && summary.contains("settled"),
        "{summary}"
    );
    assert_eq!(names(folder.path()), ["out.glb"]);
    let gltf = glb(&out);
    assert!(!gltf["animations"].as_array().unwrap().is_empty());
    let primitive = &gltf["meshes"][0]["primitives"][0];
    assert_eq!(primitive["targets"].as_array().unwrap().len(), 4);
    let positions = primitive["attributes"]["POSITION"].as_u64().unwrap() as usize;
    let original = json(&good(&["info", &file, "--json", "-"]));
    assert_eq!(gltf["accessors"][positions]["count"], original["vertices"]);
}

/// The JSON of a GLB.
fn glb(path: &Path) -> Value {
    let bytes = fs::read(path).unwrap();
    assert_eq!(&bytes[..4], b"glTF");
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

#[test]
fn a_glb_stands_upright_whatever_the_poses_come_from() {
    let Some(file) = data("characters/khronos/CesiumMan.glb") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.glb");
    let baked = |source: &[&str]| {
        let out = out.to_str().unwrap();
        let common = ["bake", &file, "-o", out, "--method", "lbs", "--quiet"];
        good(&[&common[..], source].concat());
        let gltf = glb(&folder.path().join("out.glb"));
        let numbers = |value: &Value| -> Vec<f32> {
            let list = value.as_array().unwrap().iter();
            list.map(|v| v.as_f64().unwrap() as f32).collect()
        };
        let turn = Quat::from_slice(&numbers(&gltf["nodes"][0]["rotation"]));
        let positions = &gltf["meshes"][0]["primitives"][0]["attributes"]["POSITION"];
        let accessor = &gltf["accessors"][positions.as_u64().unwrap() as usize];
        let corner = |key: &str| Vec3::from_slice(&numbers(&accessor[key]));
        let size = corner("max") - corner("min");
        (size, turn * size)
    };
    // The file's vertices lie down, its scene stands them up.
    let (lying, standing) = baked(&["--rest"]);
    assert!(lying.z > 1.2 * lying.y, "{lying}");
    assert!(standing.y.abs() > 1.2 * standing.z.abs(), "{standing}");
    let (walking, drawn) = baked(&["--frames", "0..1"]);
    assert_eq!(walking, drawn);
    assert!(walking.y > 1.2 * walking.z, "{walking}");
}

#[test]
fn a_cache_gives_the_same_skin_and_a_damaged_one_is_made_anew() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let bake = |name: &str| {
        let out = folder.path().join(name);
        let output = dermis(&[
            "bake",
            &asset("arm.glb"),
            "-o",
            out.to_str().unwrap(),
            "--cache",
            cache.to_str().unwrap(),
            "--rest",
        ]);
        assert!(output.status.success(), "{}", stderr(&output));
        let frame = fs::read(out.join("frame_0000.ply")).unwrap();
        (frame, stderr(&output).contains("made anew"))
    };
    let (made, anew) = bake("made");
    assert!(!anew);
    let entry = cache.join(&names(&cache)[0]);
    let whole = fs::read(&entry).unwrap();
    let (read, anew) = bake("read");
    assert!(read == made && !anew);
    fs::write(&entry, &whole[..whole.len() / 2]).unwrap();
    let (mended, anew) = bake("mended");
    assert!(mended == made && anew, "a damaged entry is noticed");
    assert!(fs::read(&entry).unwrap() == whole);
}

#[test]
fn implicit_skinning_settles_the_bent_arm() {
    let folder = tempfile::tempdir().unwrap();
    let pose = folder.path().join("pose.json");
    fs::write(&pose, r#"{"lower": {"axis": [0, 0, 1], "degrees": 90}}"#).unwrap();
    let out = folder.path().join("out");
    let report = json(&good(&[
        "bake",
        &asset("arm.glb"),
        "-o",
        out.to_str().unwrap(),
        "--pose",
        pose.to_str().unwrap(),
        "--format",
        "obj",
        "--json",
        "-",
    ]));
    assert_eq!(names(&out), ["frame_0000.obj"]);
    let frame = &report["frames"][0];
    assert!(frame["settled_share"].as_f64().unwrap() >= 0.995, "{frame}");
    assert!(frame["contact"].as_u64().unwrap() > 0, "{frame}");
}

#[test]
fn force_replaces_the_frames_of_an_earlier_bake() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let (arm, out_name) = (asset("arm.glb"), out.to_str().unwrap());
    let common = ["bake", &arm, "-o", out_name, "--method", "lbs", "--random"];
    good(&[&common[..], &["3"]].concat());
    fs::write(out.join("notes.txt"), "mine").unwrap();
    good(&[&common[..], &["2", "--force"]].concat());
    assert_eq!(
        names(&out),
        ["frame_0000.ply", "frame_0001.ply", "notes.txt"]
    );
}

#[test]
fn bench_reports_exactly_what_programs_expect() {
    let report = json(&good(&[
        "bench",
        &asset("arm.glb"),
        "-n",
        "3",
        "--warm-up",
        "1",
        "--json",
        "-",
    ]));
    assert_eq!(report["instances"], 1);
    assert_eq!(report["instance"]["wall_ms"], report["frame"]["wall_ms"]);
    let keys: Vec<&str> = report
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    let mut expected = [
        "device",
        "model",
        "method",
        "instances",
        "frames",
        "passes",
        "frame",
        "instance",
        "iterations",
        "memory",
        "ceiling",
        "fetches_per_frame",
    ];
    expected.sort_unstable();
    assert_eq!(keys, expected);
    assert!(report["frames"].as_u64().unwrap() >= 3);
    assert!(!report["passes"].as_array().unwrap().is_empty());
    for key in ["gpu_ms", "cpu_record_ms", "wall_ms"] {
        let spread = &report["frame"][key];
        let [min, p50, p95] = ["min", "p50", "p95"].map(|k| spread[k].as_f64().unwrap());
        assert!(min <= p50 && p50 <= p95, "{key}: {spread}");
    }
    assert!(report["memory"]["total"].as_u64().is_some());
}

#[test]
fn a_bench_of_instances_has_fields_once_and_the_share_of_one() {
    let bench = |instances: &str, more: &[&str]| {
        let file = asset("arm.glb");
        let all = ["bench", &file, "-n", "2", "--instances", instances];
        good(&[&all[..], more].concat())
    };
    let report = |instances| json(&bench(instances, &["--json", "-", "--quiet"]));
    let [one, six] = ["1", "6"].map(report);
    assert_eq!(six["instances"], 6);
    for class in ["fields", "operators", "mesh"] {
        assert!(
            six["memory"][class].as_u64().is_some_and(|bytes| bytes > 0),
            "{class}"
        );
    }
    assert_eq!(six["memory"]["fields"], one["memory"]["fields"]);
    assert_eq!(six["memory"]["operators"], one["memory"]["operators"]);
    for key in ["gpu_ms", "wall_ms"] {
        let [all, share] = ["frame", "instance"].map(|k| six[k][key]["min"].as_f64().unwrap());
        assert!((all - 6.0 * share).abs() <= 1e-9 * all, "{key}");
    }
    let text = bench("6", &[]);
    assert!(
        text.contains("frames of 6 instances") && text.contains("an instance"),
        "{text}"
    );
    let output = dermis(&["bench", &asset("arm.glb"), "--instances", "0"]);
    assert_eq!(output.status.code(), Some(2));
}

/// Begin and end of a process's spans, the longer first where two begin together.
fn sorted_spans(events: &[Value], pid: u64) -> Vec<(f64, f64)> {
    let spans = events.iter().filter(|e| e["ph"] == "X" && e["pid"] == pid);
    let times = |e: &Value| (e["ts"].as_f64().unwrap(), e["dur"].as_f64().unwrap());
    let mut sorted: Vec<_> = spans.map(times).map(|(ts, dur)| (ts, ts + dur)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    sorted
}

#[test]
fn a_trace_has_both_tracks() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("trace.json");
    good(&[
        "profile",
        &asset("arm.glb"),
        "-o",
        out.to_str().unwrap(),
        "-n",
        "2",
    ]);
    let trace = json(&fs::read_to_string(&out).unwrap());
    let events = trace["traceEvents"].as_array().unwrap();
    let spans = |pid: u64| {
        events
            .iter()
            .filter(|e| e["ph"] == "X" && e["pid"] == pid)
            .count()
    };
    assert!(spans(1) >= 6, "CPU spans");
    assert!(spans(2) >= 4, "GPU spans");
    assert!(events.iter().any(|e| e["ph"] == "C"));
    for track in [1, 2] {
        let mut open: Vec<f64> = Vec::new();
        for (begin, end) in sorted_spans(events, track) {
            assert!(begin >= 0.0 && end >= begin, "{begin} {end}");
            open.retain(|&until| until > begin + 1e-3);
            // A viewer draws spans below each other only where one holds the other.
            let around = open.last().copied().unwrap_or(f64::INFINITY);
            assert!(end <= around + 1e-3, "{begin} {end} {around}");
            open.push(end);
        }
    }
}

/// Same bits whatever the number of threads that the software rasteriser uses; other drivers ignore the variable.
#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    let folder = tempfile::tempdir().unwrap();
    let baked = ["0", "1", "2"].map(|threads| {
        let out = folder.path().join(threads);
        let status = std::process::Command::new(env!("CARGO_BIN_EXE_dermis"))
            .env("LP_NUM_THREADS", threads)
            .args([
                "bake",
                &asset("arm.glb"),
                "--random",
                "2",
                "--quiet",
                "--joint",
                "lower=blend",
            ])
            .arg("-o")
            .arg(&out)
            .status()
            .unwrap();
        assert!(status.success());
        ["frame_0000.ply", "frame_0001.ply"].map(|name| fs::read(out.join(name)).unwrap())
    });
    assert_ne!(baked[0][0], baked[0][1]);
    assert!(baked[0] == baked[1] && baked[0] == baked[2]);
}
