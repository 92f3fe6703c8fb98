//! Real characters through the whole of implicit skinning, on the device, validated.
#![allow(clippy::unwrap_used)]

mod common;

use std::{ops::AddAssign, sync::Arc};

use dermis::{
    asset::Model,
    deformer::{Deformer, Device, Settings, Skin},
    gpu::Gpu,
    rig::{Options, Pose, Rig, Skeleton},
};
use glam::{Quat, Vec3};

/// A deformer and what it deforms.
struct Case {
    name: &'static str,
    model: Model,
    deformer: Deformer,
}

impl Case {
    fn new(gpu: &Gpu, name: &'static str, model: Model) -> Self {
        let rig = Rig::prepare(&model, &Options::default(), &|_| {}).unwrap();
        let device = Device::Gpu(gpu.clone());
        let deformer = Deformer::new(&device, Arc::new(rig), &Settings::default()).unwrap();
        Self {
            name,
            model,
            deformer,
        }
    }

    fn skeleton(&self) -> Skeleton {
        self.deformer.rig().skeleton.clone()
    }

    fn play(&mut self, pose: &Pose) -> Skin {
        self.deformer.advance(pose).unwrap();
        self.deformer.read().unwrap()
    }

    /// Greatest distance of a vertex from its place in the file, as a share of the bounding box's diagonal.
    fn moved(&self, skin: &Skin) -> f32 {
        let rest = &self.model.positions;
        let low = rest.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = rest.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let distances = skin.positions.iter().zip(rest).map(|(a, b)| a.distance(*b));
        distances.fold(0.0, f32::max) / low.distance(high)
    }

    /// Three frames of every clip, and random poses.
    fn poses(&self) -> Vec<Pose> {
        let skeleton = self.skeleton();
        let clips = self.model.clips.iter().enumerate();
        let times = |seconds: f32| [0.2, 0.5, 0.9].map(|share| share * seconds);
        let of_clips = clips.flat_map(|(row, clip)| times(clip.seconds).map(|t| (row, t)));
        let of_clips = of_clips.map(|(row, t)| Pose::from_clip(&self.model, &skeleton, row, t));
        let random = (0..3).map(|seed| Pose::random(&skeleton, 90.0, seed));
        of_clips.chain(random).map(Result::unwrap).collect()
    }
}

/// Rows inside a field, and those of them on their iso-value or in contact.
#[derive(Clone, Copy, Default)]
struct Settled(usize, usize);

impl Settled {
    fn of(skin: &Skin) -> Self {
        let mut all = Self::default();
        for ((state, field), iso) in skin.state.iter().zip(&skin.field).zip(&skin.iso) {
            let inside = !matches!(state, 0 | 3);
            let good = *state == 2 || (field - iso).abs() <= 1e-3;
            all += Self(usize::from(inside), usize::from(inside && good));
        }
        all
    }

    fn share(self) -> f64 {
        self.1 as f64 / self.0 as f64
    }
}

impl AddAssign for Settled {
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
        self.1 += other.1;
    }
}

#[test]
fn characters_return_to_rest_and_settle_in_their_clips_and_random_poses() {
    let Some(gpu) = common::gpu() else { return };
    for (name, model) in common::characters() {
        let mut case = Case::new(&gpu, name, model);
        let mut all = Settled::default();
        let poses = case.poses();
        for pose in &poses {
            let skin = case.play(pose);
            assert!(skin.positions.iter().all(|p| p.is_finite()), "{name}");
            let unit = |n: &Vec3| (n.length() - 1.0).abs() < 1e-4;
            assert!(skin.normals.iter().all(unit), "{name}");
            assert!(case.moved(&skin) > 1e-3, "{name}: a pose must be noticed");
            all += Settled::of(&skin);
        }
        let (frames, share) = (poses.len(), all.share());
        // After all that motion, so that nothing of it may stay behind.
        let skin = case.play(&Pose::rest(&case.skeleton()));
        let (rest, at_rest) = (case.moved(&skin), Settled::of(&skin));
        eprintln!(
            "{}: {frames} frames, {:.3} % settled, rest off by {rest:e}",
            case.name,
            100.0 * share
        );
        assert!(share >= 0.995, "{name}: {share}");
        assert!(rest <= 1e-5, "{name}: {rest:e}");
        assert_eq!(at_rest.0, at_rest.1, "{name} at rest");
    }
    assert_eq!(gpu.validation_messages(), Vec::<String>::new());
}

#[test]
fn random_poses_turn_every_joint_about_its_origin_by_no_more_than_the_degrees() {
    for (name, model) in common::characters() {
        let skeleton = Skeleton::from_model(&model).unwrap();
        let mut greatest: f32 = 0.0;
        for seed in 0..20 {
            let pose = Pose::random(&skeleton, 90.0, seed).unwrap();
            for (row, joint) in skeleton.joints.iter().enumerate() {
                let Some(parent) = joint.parent else { continue };
                let turn = pose.matrices[parent].inverse() * pose.matrices[row];
                let angle = Quat::from_mat4(&turn).to_axis_angle().1;
                greatest = greatest.max(angle.min(std::f32::consts::TAU - angle).to_degrees());
                let origin = skeleton.origin(row);
                let slip = turn.transform_point3(origin).distance(origin);
                assert!(slip <= 1e-4 * (1.0 + origin.length()), "{name}: {slip}");
            }
        }
        assert!((80.0..=90.1).contains(&greatest), "{name}: {greatest}");
    }
}
