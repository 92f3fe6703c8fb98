//! Virtual sub-steps of tracking (2014, section 5.2): poses between two poses, so that no joint turns too far at once.

use glam::Mat4;

use super::{
    Settings,
    plan::{ROUND, Substep},
};
use crate::{
    Result,
    rig::{Pose, Skeleton, degrees},
};

/// How a frame goes from one pose to another, over poses in even steps between them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Substeps {
    /// Their number, at least one.
    pub(super) count: u32,
    /// The furthest that any joint turns on the way, degrees.
    pub(super) turned: f32,
    /// Rounds of iterations of each.
    pub(super) rounds: u32,
    /// They are large enough to be done again in halves.
    pub(super) halves: bool,
    /// More would have been needed than a frame may have.
    pub(super) capped: bool,
}

impl Substeps {
    /// The sub-steps between two validated poses.
    pub(super) fn new(skeleton: &Skeleton, settings: &Settings, from: &Pose, to: &Pose) -> Self {
        let joints = 0..skeleton.joints.len();
        let turns = joints.filter_map(|j| Turn::of(skeleton, from, to, j));
        let (needed, turned) = turns.fold((1, 0.0), |(needed, turned), turn| {
            let (wanted, degrees) = (turn.substeps(settings), turn.degrees);
            (wanted.max(needed), f32::max(turned, degrees))
        });
        let count = needed.min(settings.max_substeps);
        Self {
            count,
            turned,
            rounds: rounds(settings, turned / count as f32),
            halves: turned / count as f32 > settings.halving_degrees,
            capped: needed > count,
        }
    }

    /// Each of them.
    pub(super) fn substep(&self) -> Substep {
        Substep {
            rounds: self.rounds,
            halves: self.halves,
        }
    }

    /// The pose at the end of sub-step `k`, from 1 on; the last is `to`. Keeps the memory that `pose` has.
    pub(super) fn put_pose(
        &self,
        skeleton: &Skeleton,
        [from, to]: [&Pose; 2],
        k: u32,
        pose: &mut Pose,
    ) -> Result<()> {
        pose.put_between(skeleton, from, to, k as f32 / self.count as f32)
    }
}

/// Rounds of a sub-step in which no joint turns further than `degrees`.
fn rounds(settings: &Settings, degrees: f32) -> u32 {
    let share = (degrees / settings.full_turn_degrees).min(1.0);
    let iterations = (share * settings.iterations as f32).ceil() as u32;
    iterations.max(settings.least_iterations).div_ceil(ROUND)
}

/// What a joint does between two poses. The rotation of a root bends nothing.
struct Turn {
    /// By how far it turns, degrees.
    degrees: f32,
    /// Its rotation against its parent at the end.
    end: Mat4,
}

impl Turn {
    fn of(skeleton: &Skeleton, from: &Pose, to: &Pose, j: usize) -> Option<Self> {
        let parent = skeleton.joints[j].parent?;
        let local = |pose: &Pose| pose.matrices[parent].inverse() * pose.matrices[j];
        let (before, end) = (local(from), local(to));
        Some(Self {
            degrees: degrees(&(end * before.inverse())),
            end,
        })
    }

    /// A joint may turn by a third of its bend, and never by more than a given angle.
    fn substeps(&self, settings: &Settings) -> u32 {
        let most = |bend: f32| (bend / 3.0).min(settings.substep_degrees);
        let least_bend = settings.least_bend_degrees;
        if self.degrees <= most(least_bend) {
            // Whatever its bend, which takes as long to find as the turn.
            return 1;
        }
        let bend = degrees(&self.end).max(least_bend);
        (self.degrees / most(bend) - 1e-3).ceil().max(1.0) as u32
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::rig::skeleton::tests::skeleton;

    fn bent(degrees: [f32; 4]) -> Pose {
        let turn = |d: f32| Mat4::from_rotation_x(d.to_radians());
        Pose::from_local(&skeleton(), &degrees.map(turn)).unwrap()
    }

    fn count(from: [f32; 4], to: [f32; 4]) -> (u32, bool) {
        let s = skeleton();
        let (from, to) = (bent(from), bent(to));
        let made = Substeps::new(&s, &Settings::default(), &from, &to);
        let mut last = Pose::default();
        made.put_pose(&s, [&from, &to], made.count, &mut last)
            .unwrap();
        assert_eq!(last, to);
        (made.count, made.capped)
    }

    #[test]
    fn small_turns_take_one_step_and_large_ones_a_third_of_their_bend() {
        assert_eq!(count([0.0; 4], [0.0; 4]), (1, false));
        assert_eq!(count([0.0; 4], [0.0, 10.0, 0.0, 0.0]), (1, false));
        assert_eq!(count([0.0; 4], [0.0, 30.0, 0.0, 0.0]), (3, false));
        assert_eq!(count([0.0; 4], [0.0, 150.0, 0.0, 0.0]), (10, false));
        // Back at rest a bend is none, and its least counts.
        assert_eq!(count([0.0, 150.0, 0.0, 0.0], [0.0; 4]), (15, false));
    }

    #[test]
    fn small_turns_take_fewer_iterations() {
        let settings = Settings::default();
        let at = |degrees| rounds(&settings, degrees) * ROUND;
        assert_eq!([at(0.0), at(3.0), at(6.0), at(15.0)], [12, 12, 24, 36]);
    }

    #[test]
    fn a_root_turns_at_once_and_a_cap_is_told() {
        assert_eq!(count([0.0; 4], [170.0, 0.0, 0.0, 0.0]), (1, false));
        let settings = Settings {
            max_substeps: 4,
            ..Settings::default()
        };
        let (rest, far) = (bent([0.0; 4]), bent([0.0, 150.0, 0.0, 0.0]));
        let made = Substeps::new(&skeleton(), &settings, &rest, &far);
        assert!(made.capped && made.count == 4);
    }

    #[test]
    fn angles_are_those_of_the_rotation_whatever_the_scale() {
        for angle in [0.0f32, 1e-3, 1.0, 3.1] {
            let m = Mat4::from_rotation_y(angle) * Mat4::from_scale(glam::Vec3::splat(0.3));
            assert!((degrees(&m) - angle.to_degrees()).abs() < 1e-2, "{angle}");
        }
    }
}
