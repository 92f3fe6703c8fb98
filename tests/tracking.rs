//! Sequences of poses through iso-surface tracking, on the device, validated.
#![allow(clippy::unwrap_used)]

mod common;

use std::{path::Path, sync::Arc};

use dermis::{
    asset,
    deformer::{Deformer, Device, Method, Settings, Skin},
    gpu::Gpu,
    rig::{Options, Pose, Rig},
};
use glam::Mat4;

const CONTACT: u8 = 2;
const OUTSIDE: u8 = 3;

/// A prepared character and what tracks it.
struct Case {
    rig: Arc<Rig>,
    device: Device,
}

impl Case {
    fn new(gpu: &Gpu, rig: Rig) -> Self {
        Self {
            rig: Arc::new(rig),
            device: Device::Gpu(gpu.clone()),
        }
    }

    /// The bundled arm.
    fn arm(gpu: &Gpu) -> Self {
        let model = asset::load(Path::new("assets/arm.glb")).unwrap();
        Self::new(
            gpu,
            Rig::prepare(&model, &Options::default(), &|_| {}).unwrap(),
        )
    }

    fn deformer(&self) -> Deformer {
        let settings = Settings {
            method: Method::Tracking,
            ..Settings::default()
        };
        Deformer::new(&self.device, self.rig.clone(), &settings).unwrap()
    }

    /// The arm's elbow bent by `degrees`.
    fn bent(&self, degrees: f32) -> Pose {
        let mut local = vec![Mat4::IDENTITY; self.rig.skeleton.joints.len()];
        let lower = self.rig.skeleton.find("lower").unwrap();
        local[lower] = Mat4::from_rotation_z(degrees.to_radians());
        Pose::from_local(&self.rig.skeleton, &local).unwrap()
    }

    /// Root mean square distance from rest, over the radius of each vertex's part.
    fn away(&self, skin: &Skin) -> f32 {
        let rows = self.rig.rows.vertex.iter().zip(&skin.positions);
        let squares = rows.map(|(v, p)| {
            let v = *v as usize;
            let radius = self.rig.radius[self.rig.part[v] as usize];
            ((*p - self.rig.mesh.positions[v]).length() / radius).powi(2)
        });
        (squares.sum::<f32>() / skin.positions.len() as f32).sqrt()
    }

    /// Triangles whose normal lies against those of all three corners: slivers in a fold, at best.
    fn inverted(&self, skin: &Skin) -> usize {
        let normal = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|row| skin.positions[row as usize]);
            (b - a).cross(c - a)
        };
        let against = |t: &&[u32; 3]| {
            let n = normal(t);
            t.iter().all(|row| skin.normals[*row as usize].dot(n) < 0.0)
        };
        self.rig.rows.triangles.iter().filter(against).count()
    }
}

/// Share of the vertices in reach of a field that are within 5e-3 of their iso-value or in contact.
fn settled(skin: &Skin) -> f64 {
    let rows = skin.state.iter().zip(skin.field.iter().zip(&skin.iso));
    let (mut all, mut good) = (0, 0);
    for (state, (field, iso)) in rows.filter(|r| *r.0 != 0 && *r.0 != OUTSIDE) {
        all += 1;
        good += u32::from(*state == CONTACT || (field - iso).abs() <= 5e-3);
    }
    f64::from(good) / f64::from(all.max(1))
}

fn finite(skin: &Skin) -> bool {
    let rows = skin.positions.iter().chain(&skin.normals);
    rows.into_iter().all(|p| p.is_finite())
}

#[test]
fn an_arm_folds_and_comes_back_to_rest() {
    let Some(gpu) = common::gpu() else { return };
    let arm = Case::arm(&gpu);
    let mut deformer = arm.deformer();
    let up = (0..=15).map(|k| 10.0 * k as f32);
    let down = (0..15).rev().map(|k| 10.0 * k as f32);
    let mut skin = Skin::default();
    for degrees in up.chain(down) {
        deformer.advance(&arm.bent(degrees)).unwrap();
        skin = deformer.read().unwrap();
        assert!(finite(&skin));
        assert!(settled(&skin) >= 0.99, "{degrees}: {}", settled(&skin));
        let inverted = arm.inverted(&skin);
        assert!(inverted <= 20, "{degrees}: {inverted} of 14,080 triangles");
        let contacts = skin.state.iter().filter(|s| **s == CONTACT).count();
        assert!(contacts == 0 || degrees > 30.0, "{degrees}: {contacts}");
        assert!(contacts > 0 || degrees < 110.0, "{degrees}: {contacts}");
    }
    assert!(arm.away(&skin) < 5e-3, "{}", arm.away(&skin));
    assert_eq!(gpu.validation_messages(), Vec::<String>::new());
}

#[test]
fn a_result_does_not_depend_on_frames_in_flight() {
    let Some(gpu) = common::gpu() else { return };
    let arm = Case::arm(&gpu);
    let degrees = [20.0, 45.0, 80.0, 70.0, 95.0];
    let mut skins = [true, false].map(|wait| {
        let mut deformer = arm.deformer();
        for d in degrees {
            deformer.advance(&arm.bent(d)).unwrap();
            if wait {
                deformer.wait().unwrap();
            }
        }
        deformer.read().unwrap()
    });
    let [a, b] = &mut skins;
    assert!(a == b);
}

#[test]
fn scrubbing_and_cuts_leave_a_good_skin() {
    let Some(gpu) = common::gpu() else { return };
    let arm = Case::arm(&gpu);
    let mut deformer = arm.deformer();
    for degrees in [130.0, 5.0, 110.0, 60.0] {
        deformer.advance(&arm.bent(degrees)).unwrap();
        assert!(deformer.iterations().unwrap().substeps > 2);
        let skin = deformer.read().unwrap();
        assert!(finite(&skin) && settled(&skin) >= 0.99, "{degrees}");
    }
    let scrubbed = deformer.read().unwrap();
    deformer.reset().unwrap();
    deformer.advance(&arm.bent(60.0)).unwrap();
    let cut = deformer.read().unwrap();
    // Both are the skin of one pose, by different ways.
    let radius = arm.rig.radius[0];
    let apart = scrubbed.positions.iter().zip(&cut.positions);
    let most = apart.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(most < 0.3 * radius, "{}", most / radius);
}

#[test]
fn real_characters_stay_on_their_iso_values() {
    let Some(gpu) = common::gpu() else { return };
    for (name, model) in common::characters() {
        let case = Case::new(
            &gpu,
            Rig::prepare(&model, &Options::default(), &|_| {}).unwrap(),
        );
        let mut deformer = case.deformer();
        let skeleton = &case.rig.skeleton;
        let (rest, far) = (
            Pose::rest(skeleton),
            Pose::random(skeleton, 60.0, 3).unwrap(),
        );
        for t in [0.3, 0.6, 1.0, 0.5, 0.0] {
            let pose = Pose::interpolate(skeleton, &rest, &far, t).unwrap();
            deformer.advance(&pose).unwrap();
            let skin = deformer.read().unwrap();
            assert!(finite(&skin), "{name}");
            assert!(settled(&skin) >= 0.995, "{name} {t}: {}", settled(&skin));
        }
        let away = case.away(&deformer.read().unwrap());
        assert!(away < 0.01, "{name}: {away}");
    }
    assert_eq!(gpu.validation_messages(), Vec::<String>::new());
}
