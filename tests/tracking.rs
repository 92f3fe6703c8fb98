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
use glam::{Mat4, Vec3};

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
        Self::bundled(gpu, "arm")
    }

    fn bundled(gpu: &Gpu, name: &str) -> Self {
        let model = asset::load(&Path::new("assets").join(name).with_extension("glb")).unwrap();
        Self::new(
            gpu,
            Rig::prepare(&model, &Options::default(), &|_| {}).unwrap(),
        )
    }

    fn deformer(&self) -> Deformer {
        self.deformer_by(Method::Tracking)
    }

    fn deformer_by(&self, method: Method) -> Deformer {
        let settings = Settings {
            method,
            ..Settings::default()
        };
        Deformer::new(&self.device, self.rig.clone(), &settings).unwrap()
    }

    /// The arm's elbow bent by `degrees`.
    fn bent(&self, degrees: f32) -> Pose {
        self.turned("lower", Mat4::from_rotation_z(degrees.to_radians()))
    }

    /// The mannequin's knee bent by `degrees`.
    fn knee(&self, degrees: f32) -> Pose {
        self.turned("left_shin", Mat4::from_rotation_x(degrees.to_radians()))
    }

    /// The pose at rest with one joint turned.
    fn turned(&self, joint: &str, turn: Mat4) -> Pose {
        let skeleton = &self.rig.skeleton;
        let mut local = vec![Mat4::IDENTITY; skeleton.joints.len()];
        local[skeleton.find(joint).unwrap()] = turn;
        Pose::from_local(skeleton, &local).unwrap()
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

/// Accelerations of all vertices over frames in a row, ascending.
fn accelerations(frames: &[Vec<Vec3>]) -> Vec<f32> {
    let at = |w: &[Vec<Vec3>], v: usize| (w[0][v] - 2.0 * w[1][v] + w[2][v]).length();
    let mut all: Vec<f32> = frames
        .windows(3)
        .flat_map(|w| (0..w[0].len()).map(move |v| at(w, v)))
        .collect();
    all.sort_by(f32::total_cmp);
    all
}

#[test]
fn a_folded_skin_that_hardly_moves_does_not_tremble() {
    let Some(gpu) = common::gpu() else { return };
    let mannequin = Case::bundled(&gpu, "mannequin");
    let poses: Vec<Pose> = (0..44)
        .map(|k| mannequin.knee(140.0 + 0.25 * (0.3 * k as f32).sin()))
        .collect();
    let [geometric, tracked] = [Method::Dqs, Method::Tracking].map(|method| {
        let mut deformer = mannequin.deformer_by(method);
        let mut frame = |pose: &Pose| {
            deformer.advance(pose).unwrap();
            deformer.read().unwrap().positions
        };
        // The first frames bend the knee, and let the skin come to rest in its fold.
        let frames: Vec<_> = poses.iter().map(&mut frame).skip(10).collect();
        let all = accelerations(&frames);
        all[all.len() * 999 / 1000]
    });
    // 16 where the iteration takes whole steps.
    assert!(tracked < 3.0 * geometric, "{tracked} of {geometric}");
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
