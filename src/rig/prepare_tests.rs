#![allow(clippy::unwrap_used)]
use std::{fs, sync::Mutex, time::Instant};

use glam::Vec3;

use super::*;
use crate::{
    asset::{Influence, Primitive},
    compose::Operator,
    rig::{character_tests::character, skeleton::tests::model as skeleton_model},
};

/// A tube around the test skeleton, weights by heat, and a small rigid shell inside it.
fn tube() -> Model {
    let (n, m) = (16u32, 60u32);
    let mut model = skeleton_model();
    let mut add = |from: f32, to: f32, radius: f32, m: u32| {
        let base = model.positions.len() as u32;
        for j in 0..=m {
            for i in 0..n {
                let a = i as f32 / n as f32 * std::f32::consts::TAU;
                let x = from + (to - from) * j as f32 / m as f32;
                let p = Vec3::new(x, radius * a.cos(), radius * a.sin());
                model.positions.push(p);
                model.normals.push(p.with_x(0.0).normalize());
            }
        }
        let mut t = Vec::new();
        for j in 0..m {
            for i in 0..n {
                let (a, b) = (j * n + i, j * n + (i + 1) % n);
                t.extend([[a, b, a + n], [b, b + n, a + n]]);
            }
        }
        for k in 1..n - 1 {
            t.extend([[0, k + 1, k], [m * n, m * n + k, m * n + k + 1]]);
        }
        model
            .triangles
            .extend(t.iter().map(|t| t.map(|v| v + base)));
    };
    add(-1.5, 2.7, 0.3, m);
    add(0.4, 0.6, 0.05, 2);
    let rows = model.positions.len();
    model.primitives.push(Primitive {
        name: "tube/0".into(),
        vertices: 0..rows,
        triangles: 0..model.triangles.len(),
        base_color: [1.0; 4],
    });
    let tube = ((m + 1) * n) as usize;
    let rigid = Influence {
        joint: 0,
        weight: 1.0,
    };
    model.influences = (0..rows)
        .map(|v| if v < tube { vec![] } else { vec![rigid] })
        .collect();
    model.path = "folder/tube.glb".into();
    model
}

fn quiet(_: Progress) {}

/// Equal bit for bit, wherever their caches are.
fn same(a: &Rig, b: &Rig) {
    let text = |rig: &Rig| {
        let cache = None;
        format!(
            "{:?}",
            Rig {
                cache,
                ..rig.clone()
            }
        )
    };
    assert!(text(a) == text(b), "the rigs differ");
}

/// All rows that later steps index with are in range and of one length.
fn check_shapes(rig: &Rig, model: &Model) {
    let (n, joints, fields) = (
        rig.mesh.positions.len(),
        rig.skeleton.joints.len(),
        rig.fields.len(),
    );
    assert_eq!(rig.rows.vertex.len(), rig.rows.normals.len());
    assert!(rig.rows.vertex.len() >= model.positions.len());
    assert_eq!(rig.part.len(), n);
    assert_eq!(rig.geometric.len(), n);
    assert_eq!(rig.rigid.len(), n);
    assert_eq!(rig.neighbourhood.len(), n);
    assert_eq!(rig.mean_value.len(), rig.mesh.one_ring.items.len());
    assert_eq!(rig.weights.weights.len(), n * rig.weights.width);
    assert_eq!(rig.radius.len(), joints);
    assert!(rig.radius.iter().all(|r| r.is_finite() && *r > 0.0));
    assert_eq!(rig.composition.parent.len(), fields);
    for (row, parent) in rig.composition.parent.iter().enumerate() {
        assert!(*parent == u32::MAX || (*parent as usize) < row);
    }
    for v in 0..n {
        let row = &rig.weights.weights[v * rig.weights.width..(v + 1) * rig.weights.width];
        assert!((row.iter().sum::<f32>() - 1.0).abs() < 1e-4);
    }
}

#[test]
fn a_tube_gets_weights_fields_and_a_geometric_shell() {
    let model = tube();
    let stages = Mutex::new(Vec::new());
    let report = |p: Progress| stages.lock().unwrap().push((p.stage, p.done, p.total));
    let rig = Rig::prepare(&model, &Options::default(), &report).unwrap();
    check_shapes(&rig, &model);
    assert_eq!(rig.name, "tube.glb");
    assert_eq!(rig.fields.len(), 4, "{:?}", rig.warnings);
    let tube = 61 * 16;
    assert!(
        rig.geometric[..tube].iter().all(|g| !g),
        "{:?}",
        rig.warnings
    );
    assert!(rig.geometric[tube..].iter().all(|g| *g));
    let told = |what: &str| rig.warnings.iter().any(|w| w.contains(what));
    assert!(
        told("heat diffusion") && told("rigid shells"),
        "{:?}",
        rig.warnings
    );
    // The shell inside has not dented the field: the tube's skin lies on the iso-surface around it.
    let root = &rig.fields[0];
    let skin = (0..tube).filter(|&v| (0.3..0.7).contains(&rig.mesh.positions[v].x));
    for v in skin {
        let (f, _) = root.evaluate(rig.mesh.positions[v]);
        assert!((f - 0.5).abs() < 0.05, "{f}");
    }
    let stages = stages.into_inner().unwrap();
    assert!(stages.is_sorted_by_key(|s| s.1));
    assert_eq!(stages.last().map(|s| s.1), stages.last().map(|s| s.2));
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let model = tube();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let options = Options::default();
        pool.unwrap()
            .install(|| Rig::prepare(&model, &options, &quiet).unwrap())
    };
    same(&with(1), &with(3));
}

#[test]
fn subdivision_keeps_the_shape_and_multiplies_triangles() {
    let model = tube();
    let options = Options {
        subdivide: 1,
        ..Options::default()
    };
    let rig = Rig::prepare(&model, &options, &quiet).unwrap();
    check_shapes(&rig, &model);
    assert_eq!(rig.rows.triangles.len(), 4 * model.triangles.len());
}

#[test]
fn a_cached_preparation_is_the_same_bit_for_bit_and_damage_is_mended() {
    let dir = tempfile::tempdir().unwrap();
    let model = tube();
    let options = Options::default();
    let cached = |options: &Options| {
        let computed = Mutex::new(false);
        let report = |p: Progress| *computed.lock().unwrap() |= p.stage == "fields";
        let rig = Rig::prepare_cached(dir.path(), &model, options, &report).unwrap();
        (rig, computed.into_inner().unwrap())
    };
    let plain = Rig::prepare(&model, &options, &quiet).unwrap();
    let (first, computed) = cached(&options);
    assert!(computed);
    same(&first, &plain);
    let (second, computed) = cached(&options);
    assert!(!computed, "the cache was not used");
    same(&second, &plain);
    // Operators and rigid regions do not touch what is cached; weights do.
    let blend = vec![("elbow".into(), Operator::Blend)];
    let mut painted = model.clone();
    painted.rigid = vec![0.5; painted.positions.len()];
    let report = |p: Progress| assert_ne!(p.stage, "fields");
    let soft = Rig::prepare_cached(dir.path(), &painted, &options, &report).unwrap();
    assert!(soft.rigid.iter().all(|x| *x == 0.5) && plain.rigid.iter().all(|x| *x == 0.0));
    let (other, computed) = cached(&Options {
        joints: blend,
        rigid: vec!["elbow".into()],
        ..options.clone()
    });
    assert!(!computed && other.composition.operator[1] == Some(Operator::Blend));
    for (rigid, part) in other.rigid.iter().zip(&other.part) {
        assert_eq!(*rigid, f32::from(u8::from(*part == 1)));
    }
    assert!(
        cached(&Options {
            heat_weights: true,
            ..options.clone()
        })
        .1
    );

    for file in fs::read_dir(dir.path()).unwrap() {
        let path = file.unwrap().path();
        let mut bytes = fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&path, bytes).unwrap();
    }
    let (mended, computed) = cached(&options);
    assert!(computed);
    assert!(
        mended.warnings.iter().any(|w| w.contains("damaged")),
        "{:?}",
        mended.warnings
    );
    assert_eq!(mended.fields.len(), plain.fields.len());
    assert!(!cached(&options).1);
}

#[test]
fn a_cache_that_cannot_be_written_is_a_warning() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("file");
    fs::write(&file, "").unwrap();
    let rig = Rig::prepare_cached(&file, &tube(), &Options::default(), &quiet).unwrap();
    assert!(
        rig.warnings.iter().any(|w| w.contains("not cached")),
        "{:?}",
        rig.warnings
    );
}

#[test]
fn inconsistent_models_and_options_are_refused() {
    let refused = |change: fn(&mut Model, &mut Options)| {
        let (mut model, mut options) = (tube(), Options::default());
        change(&mut model, &mut options);
        Rig::prepare(&model, &options, &quiet)
            .unwrap_err()
            .to_string()
    };
    assert!(refused(|m, _| m.positions[7].y = f32::NAN).contains("vertex 7"));
    assert!(refused(|m, _| m.triangles[3][1] = 1 << 30).contains("triangle 3"));
    assert!(refused(|m, _| m.triangles.clear()).contains("no triangles"));
    assert!(refused(|m, _| m.normals.truncate(3)).contains("differ in number"));
    assert!(refused(|m, _| m.rigid = vec![0.0; 3]).contains("differ in number"));
    assert!(refused(|m, _| m.rigid = vec![f32::NAN; m.positions.len()]).contains("vertex 0"));
    assert!(refused(|_, o| o.rigid.push("knee".into())).contains("knee"));
    assert!(refused(|m, _| m.primitives.clear()).contains("primitives"));
    assert!(
        refused(|m, _| m.influences[2] = vec![Influence {
            joint: 77,
            weight: 1.0
        }])
        .contains("vertex 2")
    );
    assert!(refused(|_, o| o.joints.push(("knee".into(), Operator::Bulge))).contains("knee"));
    assert!(refused(|_, o| o.part = Some(vec![0; 3])).contains("part"));
    assert!(refused(|_, o| o.subdivide = 30).contains("subdivide"));
    assert!(refused(|_, o| o.magnitude = -1.0).contains("magnitude"));
}

#[test]
fn real_characters_are_prepared() {
    for name in [
        "khronos/CesiumMan.glb",
        "khronos/Fox.glb",
        "khronos/RiggedFigure.glb",
        "khronos/RiggedSimple.glb",
        "mesh2motion/horse-animations.glb",
        "mesh2motion/shark-animations.glb",
        "mesh2motion/human-male.glb",
        "mesh2motion/human-sintel.glb",
    ] {
        let Some(model) = character(name) else { return };
        let started = Instant::now();
        let rig = Rig::prepare(&model, &Options::default(), &quiet).unwrap();
        let seconds = started.elapsed().as_secs_f32();
        check_shapes(&rig, &model);
        let n = rig.mesh.positions.len();
        let geometric = rig.geometric.iter().filter(|g| **g).count();
        println!(
            "{name}: {} fields, {geometric} of {n} vertices geometric, {seconds:.2} s",
            rig.fields.len()
        );
        for warning in &rig.warnings {
            println!("    {warning}");
        }
        assert!(!rig.fields.is_empty());
        assert!(geometric * 2 < n, "{name}: {geometric} of {n}");
    }
}
