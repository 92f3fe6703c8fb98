//! `dermis flesh`: meshes along spines, from the command line.
#![allow(clippy::unwrap_used)]

mod common;

use std::{
    fs,
    path::{Path, PathBuf},
};

use common::{asset, data, good, names, refused, stderr};
use serde_json::{Value, json};

/// A bar from x = 0 to 4, 0.8 thick, finely enough divided, as OBJ; and spines for it.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let bench = Self { folder };
        fs::write(bench.path("bar.obj"), bar()).unwrap();
        bench.spine(
            "line.json",
            &json!({"kind": "polyline", "points": [[0, 0, 0], [4, 0, 0]]}),
        );
        bench.spine("arc.json", &arc(4.0));
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().into()
    }

    fn spine(&self, name: &str, value: &Value) {
        fs::write(self.path(name), value.to_string()).unwrap();
    }

    fn args(&self, output: &str, more: &[&str]) -> Vec<String> {
        let fixed = [
            "--rest",
            &self.text("line.json"),
            "--bent",
            &self.text("arc.json"),
        ];
        let bar = self.text("bar.obj");
        let mut args: Vec<String> = vec!["flesh".into(), bar, "-o".into(), self.text(output)];
        if !more.contains(&"--rest") {
            args.extend(fixed.map(String::from));
        }
        args.extend(more.iter().map(|a| (*a).to_string()));
        args
    }

    fn json(&self, output: &str, more: &[&str]) -> Value {
        let args = self.args(output, &[more, &["--json", "-"]].concat());
        serde_json::from_str(&good(&args)).unwrap()
    }

    /// Refused, with nothing left behind.
    fn refused(&self, output: &str, more: &[&str]) -> String {
        let before = names(self.folder.path());
        let error = refused(&self.args(output, more));
        assert_eq!(names(self.folder.path()), before, "{error}");
        error
    }
}

fn arc(length: f64) -> Value {
    json!({"kind": "arc", "start": [0, 0, 0], "tangent": [1, 0, 0], "normal": [0, 1, 0], "radius": 2, "length": length})
}

/// Quads of a box, cut in two.
fn bar() -> String {
    let (long, thin) = (80, 16);
    let mut points = Vec::new();
    let mut faces = Vec::new();
    let mut row = |at: [f64; 3]| {
        points.push(format!(
            "v {} {} {}",
            at[0] * 4.0,
            at[1] * 0.8 - 0.4,
            at[2] * 0.8 - 0.4
        ));
        points.len()
    };
    // Each side of the box by the axis across it; rows at one place are welded where that matters.
    for (axis, [nu, nv]) in [(0, [thin, thin]), (1, [thin, long]), (2, [long, thin])] {
        for end in [0.0, 1.0] {
            let mut at = |u: i32, v: i32| {
                let mut p = [end; 3];
                p[(axis + 1) % 3] = f64::from(u) / f64::from(nu);
                p[(axis + 2) % 3] = f64::from(v) / f64::from(nv);
                row(p)
            };
            let grid: Vec<Vec<usize>> = (0..=nu)
                .map(|u| (0..=nv).map(|v| at(u, v)).collect())
                .collect();
            for pair in grid.windows(2) {
                for v in 0..nv as usize {
                    let [a, b, c, d] = [pair[0][v], pair[1][v], pair[1][v + 1], pair[0][v + 1]];
                    faces.push(match end == 1.0 {
                        true => format!("f {a} {b} {c} {d}"),
                        false => format!("f {d} {c} {b} {a}"),
                    });
                }
            }
        }
    }
    points.join("\n") + "\n" + &faces.join("\n") + "\n"
}

#[test]
fn a_bar_keeps_its_volume_by_every_map() {
    let bench = Bench::new();
    for map in ["radial", "normal", "binormal"] {
        let report = bench.json("out.ply", &["--map", map, "--report"]);
        assert_eq!(report["open_edges"], 0);
        assert!((report["volume"].as_f64().unwrap() - 4.0 * 0.64).abs() < 1e-6);
        let frame = &report["frames"][0];
        assert!(
            frame["volume_error"].as_f64().unwrap().abs() < 2e-4,
            "{map}: {frame}"
        );
        assert_eq!(
            (&frame["invalid_vertices"], &frame["torn_triangles"]),
            (&json!(0), &json!(0))
        );
        let local = &report["local"];
        let pieces = local["cubes"]
            .as_array()
            .unwrap()
            .iter()
            .chain([&local["surface"]]);
        for piece in pieces {
            let number = |key: &str| piece[key].as_f64().unwrap();
            assert!(number("cells") > 20.0, "{map}: {piece}");
            assert!(
                number("mean_error") < 0.1 * number("plain_mean_error"),
                "{map}: {piece}"
            );
        }
    }
    let plain = bench.json("out.ply", &["--strength", "0"]);
    // The middle of the bar is on the spine: as much is won outside as is lost inside.
    assert!(plain["frames"][0]["volume_error"].as_f64().unwrap().abs() < 1e-3);
}

#[test]
fn every_format_has_the_vertices_of_the_file_in_order() {
    let bench = Bench::new();
    let points = |name: &str| dermis::asset::load_surface(&bench.path(name)).unwrap();
    let before = points("bar.obj");
    for name in ["out.obj", "out.ply", "out.off"] {
        good(&bench.args(
            name,
            &[
                "--bent",
                &bench.text("line.json"),
                "--rest",
                &bench.text("line.json"),
            ],
        ));
        let after = points(name);
        assert_eq!(after.triangles, before.triangles);
        for (a, b) in after.positions.iter().zip(&before.positions) {
            assert!(a.distance(*b) < 1e-6, "{name}");
        }
    }
    // There and back.
    good(&bench.args("bent.ply", &[]));
    let (line, arc) = (bench.text("line.json"), bench.text("arc.json"));
    let out = bench.text("back.ply");
    good(&[
        "flesh",
        &bench.text("bent.ply"),
        "--rest",
        &arc,
        "--bent",
        &line,
        "-o",
        &out,
    ]);
    for (a, b) in points("back.ply").positions.iter().zip(&before.positions) {
        assert!(a.distance(*b) < 2e-6, "{a} {b}");
    }
}

#[test]
fn a_movement_slides_along_a_longer_path() {
    let bench = Bench::new();
    bench.spine("path.json", &arc(8.0));
    let path = bench.text("path.json");
    let line = bench.text("line.json");
    let slide = [
        "--rest", &line, "--bent", &path, "--slide", "0..1", "--frames", "5",
    ];
    let report = bench.json("frames", &slide);
    assert_eq!(names(&bench.path("frames")).len(), 5);
    for (row, frame) in report["frames"].as_array().unwrap().iter().enumerate() {
        assert_eq!(frame["slide"], row as f64 / 4.0);
        assert!(
            frame["volume_error"].as_f64().unwrap().abs() < 2e-4,
            "{frame}"
        );
    }
    good(&bench.args("swim.glb", &slide));
    assert!(
        fs::read(bench.path("swim.glb"))
            .unwrap()
            .starts_with(b"glTF")
    );
    let error = bench.refused("out.obj", &slide);
    assert!(error.contains("--output"), "{error}");
    let error = bench.refused("out.glb", &["--slide", "0..1"]);
    assert!(error.contains("--frames"), "{error}");
}

#[test]
fn limits_are_flagged_and_told() {
    let bench = Bench::new();
    let mut tight = arc(1.2);
    tight["radius"] = json!(0.3);
    bench.spine("tight.json", &tight);
    let tight = bench.text("tight.json");
    let args = bench.args(
        "out.ply",
        &["--rest", &bench.text("line.json"), "--bent", &tight],
    );
    let output = common::dermis(&args);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("past a limit"),
        "{}",
        stderr(&output)
    );
    let after = dermis::asset::load_surface(&bench.path("out.ply")).unwrap();
    assert!(after.positions.iter().all(|p| p.is_finite()));
}

#[test]
fn bad_spines_are_refused_with_file_and_key() {
    let bench = Bench::new();
    let point = |y: f64| json!({"kind": "bspline", "points": [[0, 0, 0], [1, y, 0], [2, 0, 0]]});
    let mut cases = vec![
        (json!([]), "object"),
        (json!({}), "kind"),
        (
            json!({"kind": "bspline", "points": [[0, 0, 0], [0, 0, 0]]}),
            "points/1",
        ),
        (
            json!({"kind": "polyline", "points": [[0, 0, 0], [0, 0, 0]]}),
            "points",
        ),
        (
            json!({"kind": "bspline", "points": [[0, 0, 0], [1, 2]]}),
            "points/1",
        ),
    ];
    for (key, value) in [
        ("color", json!(1)),
        ("radius", json!(0)),
        ("length", json!(-4)),
        ("tangent", json!([0, 0, 0])),
        ("up", json!([1, 0, 0])),
        ("twist_degrees", json!("x")),
    ] {
        let mut spine = arc(4.0);
        spine[key] = value;
        cases.push((spine, key));
    }
    cases.push((point(1e308), "points"));
    for (spine, culprit) in cases {
        bench.spine("bad.json", &spine);
        let (bad, line) = (bench.text("bad.json"), bench.text("line.json"));
        for more in [
            ["--rest", &bad, "--bent", &line],
            ["--rest", &line, "--bent", &bad],
        ] {
            let error = bench.refused("out.ply", &more);
            assert!(
                error.contains("bad.json") && error.contains(culprit),
                "{spine}: {error}"
            );
        }
    }
    fs::write(
        bench.path("bad.json"),
        r#"{"kind": "bspline", "points": [[NaN, 0, 0]]}"#,
    )
    .unwrap();
    let bad = bench.text("bad.json");
    let error = bench.refused("out.ply", &["--rest", &bad, "--bent", &bad]);
    assert!(error.contains("bad.json"), "{error}");
}

#[test]
fn closed_spines_bend_to_closed_ones_only() {
    let bench = Bench::new();
    let circle = |radius: f64| {
        let mut circle = arc(radius * std::f64::consts::TAU);
        circle["radius"] = json!(radius);
        circle
    };
    bench.spine("ring.json", &circle(2.0));
    bench.spine("wide.json", &circle(2.5));
    let [ring, wide, line] = ["ring.json", "wide.json", "line.json"].map(|n| bench.text(n));
    let error = bench.refused("out.ply", &["--rest", &ring, "--bent", &line]);
    assert!(
        error.contains("line.json") && error.contains("closed"),
        "{error}"
    );
    let error = bench.refused("out.ply", &["--rest", &ring, "--bent", &wide]);
    assert!(
        error.contains("wide.json") && error.contains("stretch"),
        "{error}"
    );
    good(&bench.args("out.ply", &["--rest", &ring, "--bent", &wide, "--stretch"]));
}

#[test]
fn bad_meshes_and_places_are_named() {
    let bench = Bench::new();
    let (line, arc) = (bench.text("line.json"), bench.text("arc.json"));
    let spines = ["--rest", &line, "--bent", &arc];
    fs::write(
        bench.path("bad.obj"),
        "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n",
    )
    .unwrap();
    for (mesh, output, culprit) in [
        ("bad.obj", "out.ply", "bad.obj"),
        ("no.obj", "out.ply", "no.obj"),
        ("line.json", "out.ply", "line.json"),
        ("bar.obj", "no/out.ply", "out.ply"),
        ("bar.obj", "out.stl", "--output"),
        ("bar.obj", "out", "--output"),
    ] {
        let (mesh, output) = (bench.text(mesh), bench.text(output));
        let error = refused(&[&["flesh", &mesh, "-o", &output], &spines[..]].concat());
        assert!(error.contains(culprit), "{mesh}: {error}");
    }
    let error = bench.refused("out.ply", &["--mask", "neck"]);
    assert!(error.contains("neck"), "{error}");
    let error = bench.refused(
        "out.ply",
        &["--rest", &line, "--bent", &arc, "--bent", &arc],
    );
    assert!(error.contains("--bent"), "{error}");
}

/// The lower arm of the project's own arm, by its weights: the rest stays.
#[test]
fn a_mask_of_joints_leaves_the_rest() {
    let bench = Bench::new();
    let spine = |bent: bool| match bent {
        false => json!({"kind": "polyline", "points": [[0, 0, 0], [2, 0, 0]]}),
        true => {
            json!({"kind": "arc", "start": [0, 0, 0], "tangent": [1, 0, 0], "normal": [0, 1, 0], "radius": 3, "length": 2})
        }
    };
    bench.spine("a.json", &spine(false));
    bench.spine("b.json", &spine(true));
    let (a, b, out) = (
        bench.text("a.json"),
        bench.text("b.json"),
        bench.text("out.ply"),
    );
    let file = asset("arm.glb");
    good(&[
        "flesh", &file, "--rest", &a, "--bent", &b, "--mask", "lower", "-o", &out,
    ]);
    let before = dermis::asset::load(Path::new(&file)).unwrap();
    let after = dermis::asset::load_surface(Path::new(&out)).unwrap();
    let (mut still, mut moved) = (0, 0);
    for (row, (a, b)) in before.positions.iter().zip(&after.positions).enumerate() {
        let lower = |joint: u16| before.joints[usize::from(joint)].name == "lower";
        if before.influences[row].iter().all(|i| !lower(i.joint)) {
            assert!(a.distance(*b) < 1e-6);
            still += 1;
        } else if a.distance(*b) > 1e-3 {
            moved += 1;
        }
    }
    assert!(still > 100 && moved > 100, "{still} {moved}");
}

#[test]
fn a_picture_shows_all_maps() {
    if std::env::var("DERMIS_NO_GPU").is_ok_and(|v| v == "1") {
        eprintln!("skipped: DERMIS_NO_GPU=1");
        return;
    }
    let bench = Bench::new();
    let picture = bench.text("out.png");
    good(&bench.args(
        "out.obj",
        &[
            "--picture",
            &picture,
            "--view",
            "front",
            "--size",
            "64x48",
            "--validation",
        ],
    ));
    let bytes = fs::read(&picture).unwrap();
    assert!(bytes.starts_with(b"\x89PNG"));
    // The header's width: five parts.
    let width = u32::from_be_bytes(bytes[16..20].try_into().unwrap());
    assert!(width > 5 * 64, "{width}");
}

#[test]
fn models_keep_their_volume() {
    let Some(bunny) = data("static/libigl-tutorial/bunny.off") else {
        return;
    };
    let bench = Bench::new();
    let middle = [-0.0169, 0.0332, 0.0];
    let [x, y, z] = middle.map(|v: f64| v);
    bench.spine(
        "line.json",
        &json!({"kind": "bspline", "points": [[x, y, z], [x, y + 0.154, z]]}),
    );
    bench.spine(
        "arc.json",
        &json!({"kind": "arc", "start": [x, y, z], "tangent": [0, 1, 0], "normal": [1, 0, 0],
        "radius": 0.22, "length": 0.154}),
    );
    let (line, arc, out) = (
        bench.text("line.json"),
        bench.text("arc.json"),
        bench.text("out.off"),
    );
    for map in ["radial", "normal", "binormal"] {
        let json = good(&[
            "flesh", &bunny, "--rest", &line, "--bent", &arc, "--map", map, "-o", &out, "--json",
            "-",
        ]);
        let report: Value = serde_json::from_str(&json).unwrap();
        let error = report["frames"][0]["volume_error"].as_f64().unwrap();
        assert!(error.abs() < 5e-4, "{map}: {error}");
    }
}
