//! The bundled biceps on the bundled arm, by both methods with fields.
#![allow(clippy::unwrap_used)]

mod common;

use std::{path::Path, sync::Arc};

use dermis::{
    asset,
    deformer::{Deformer, Device, Method, Settings, Skin},
    gpu::Gpu,
    rig::{Options, Pose, Primitive, Rig},
};
use glam::{Mat4, Vec3};

const METHODS: [Method; 2] = [Method::Implicit, Method::Tracking];

fn arm(muscle: bool) -> Arc<Rig> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let model = asset::load(&assets.join("arm.glb")).unwrap();
    let mut options = Options::default();
    if muscle {
        options.primitives = Primitive::read(&assets.join("biceps.json")).unwrap();
    }
    Arc::new(Rig::prepare(&model, &options, &|_| {}).unwrap())
}

fn deformer(gpu: &Gpu, rig: &Arc<Rig>, method: Method) -> Deformer {
    let settings = Settings {
        method,
        ..Settings::default()
    };
    Deformer::new(&Device::Gpu(gpu.clone()), rig.clone(), &settings).unwrap()
}

fn bend(deformer: &mut Deformer, degrees: f32) -> Skin {
    let turn = Mat4::from_rotation_z(degrees.to_radians());
    let pose = Pose::from_local(&deformer.rig().skeleton, &[Mat4::IDENTITY, turn]).unwrap();
    deformer.advance(&pose).unwrap();
    deformer.read().unwrap()
}

/// Greatest distance of the middle of the upper arm's skin from the bone, towards the forearm.
fn thickness(skin: &Skin) -> f32 {
    let middle =
        |(p, bone): (&Vec3, &u16)| (*bone == 0 && (-0.16..-0.1).contains(&p.x)).then_some(p.y);
    let heights = skin.positions.iter().zip(&skin.bone).filter_map(middle);
    heights.fold(0.0, f32::max)
}

#[test]
fn a_bent_arm_is_thicker_with_its_muscle_and_on_its_iso_values() {
    let Some(gpu) = common::gpu() else { return };
    let (with, without) = (arm(true), arm(false));
    for method in METHODS {
        let mut last = 0.0;
        let mut plain = deformer(&gpu, &without, method);
        let mut strong = deformer(&gpu, &with, method);
        for degrees in [30.0, 60.0, 90.0] {
            let thin = thickness(&bend(&mut plain, degrees));
            let skin = bend(&mut strong, degrees);
            let thick = thickness(&skin);
            let settled = skin.state.iter().zip(skin.field.iter().zip(&skin.iso));
            let settled =
                settled.filter(|(state, (f, iso))| **state == 2 || (*f - *iso).abs() < 5e-3);
            let share = settled.count() as f32 / skin.state.len() as f32;
            eprintln!("{method:?} {degrees}: {thin:.4} → {thick:.4}, {share:.4} settled");
            assert!(thick > last && thick > thin, "{method:?} {degrees}");
            assert!(share > 0.98, "{method:?} {degrees}: {share}");
            last = thick;
        }
        assert!(last > 0.062, "{method:?}: {last}");
    }
    assert_eq!(gpu.validation_messages(), Vec::<String>::new());
}

#[test]
fn the_rest_pose_stays_a_fixed_point() {
    let Some(gpu) = common::gpu() else { return };
    let (with, without) = (arm(true), arm(false));
    for method in METHODS {
        let mut strong = deformer(&gpu, &with, method);
        let rest = bend(&mut strong, 0.0);
        let plain = bend(&mut deformer(&gpu, &without, method), 0.0);
        let rows = with.rows.vertex.iter();
        let file: Vec<Vec3> = rows.map(|v| with.mesh.positions[*v as usize]).collect();
        let away = |other: &[Vec3]| {
            let pairs = rest.positions.iter().zip(other);
            pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
        };
        let found = [away(&file), away(&plain.positions)];
        // Tracking moves a skin at rest by roundings in its first frame, with a muscle and without.
        let most = if method == Method::Tracking {
            1e-6
        } else {
            0.0
        };
        assert!(found.iter().all(|d| *d <= most), "{method:?}: {found:?}");
        bend(&mut strong, 60.0);
        strong.reset().unwrap();
        assert!(bend(&mut strong, 0.0) == rest, "{method:?}");
    }
    assert_eq!(gpu.validation_messages(), Vec::<String>::new());
}

#[test]
fn a_cached_preparation_takes_other_primitives() {
    let folder = tempfile::tempdir().unwrap();
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let model = asset::load(&assets.join("arm.glb")).unwrap();
    let mut options = Options::default();
    let fields = |options: &Options| {
        let rig = Rig::prepare_cached(folder.path(), &model, options, &|_| {}).unwrap();
        assert!(rig.warnings.is_empty(), "{:?}", rig.warnings);
        (rig.fields.len(), rig.primitives.len())
    };
    assert_eq!(fields(&options), (2, 0));
    options.primitives = Primitive::read(&assets.join("biceps.json")).unwrap();
    assert_eq!(fields(&options), (3, 1));
    options.primitives.clear();
    assert_eq!(fields(&options), (2, 0));
    assert_eq!(folder.path().read_dir().unwrap().count(), 1);
}
