//! The ways of all instances through the sub-steps of a frame of tracking. A frame has as many as the instance that goes
//! furthest; the others arrive earlier and wait.

use super::{
    Settings,
    plan::Substep,
    pose::{PoseUpload, Turn},
    statics::Statics,
    substeps::{Substeps, substeps},
};
use crate::{
    Result,
    field::AtlasLayout,
    rig::{Pose, Rig},
};

/// The way of an instance from the pose that its skin follows to the next one.
pub(super) struct Way {
    before: Pose,
    steps: Substeps,
    /// Poses in the middle of each sub-step; none where it never goes by halves.
    halves: Vec<Pose>,
}

impl Way {
    /// From where the skin is (none for rest) to a validated pose.
    pub(super) fn new(
        rig: &Rig,
        settings: &Settings,
        tracked: Option<&Pose>,
        pose: &Pose,
    ) -> Result<Self> {
        let skeleton = &rig.skeleton;
        let start = tracked.cloned().unwrap_or_else(|| at_root(rig, pose));
        let steps = substeps(skeleton, settings, &start, pose)?;
        Ok(Self {
            // At rest the tracked skin is not yet where the root carries it.
            before: tracked.cloned().unwrap_or_else(|| Pose::rest(skeleton)),
            halves: steps.halves(skeleton, &start)?,
            steps,
        })
    }

    /// More sub-steps would have been needed than a frame may have.
    pub(super) fn is_capped(&self) -> bool {
        self.steps.capped
    }

    /// The poses that a slice of a sub-step goes from and to: the whole, its first half, its second half. None where the
    /// instance has arrived, or does not go by halves.
    fn slice(&self, step: usize, slice: u32) -> Option<(&Pose, &Pose)> {
        let to = self.steps.poses.get(step)?;
        let from = match step.checked_sub(1) {
            Some(before) => &self.steps.poses[before],
            None => &self.before,
        };
        match (slice, self.halves.get(step)) {
            (0, _) => Some((from, to)),
            (1, Some(half)) => Some((from, half)),
            (_, Some(half)) => Some((half, to)),
            (_, None) => None,
        }
    }
}

/// What goes into the uploads beside the ways.
pub(super) struct Context<'a> {
    pub(super) rig: &'a Rig,
    pub(super) statics: &'a Statics,
    pub(super) layout: AtlasLayout,
}

impl Context<'_> {
    /// Fills an upload with the slices of all ways.
    pub(super) fn upload(&self, ways: &[Way], upload: &mut PoseUpload) {
        upload.clear(ways.len());
        let steps = ways.iter().map(|w| w.steps.poses.len()).max().unwrap_or(0);
        let mut round = 0;
        for step in 0..steps {
            let substep = substep(ways, step);
            for slice in 0..substep.slices() {
                for way in ways {
                    self.part(upload, way, (step, slice), round);
                }
                round += substep.rounds;
            }
            upload.end_substep(substep);
        }
    }

    fn part(&self, upload: &mut PoseUpload, way: &Way, (step, slice): (usize, u32), round: u32) {
        let Some((from, to)) = way.slice(step, slice) else {
            return upload.repeat();
        };
        upload.push(self.rig, self.statics, &self.layout, Some(from), to);
        upload.set_turn(Turn {
            last_round: round + way.steps.rounds - 1,
            carried: true,
            halves: slice == 0 && way.steps.halves,
        });
    }
}

/// A sub-step of the frame: what the instances need that have not arrived.
fn substep(ways: &[Way], step: usize) -> Substep {
    let on_their_way = ways.iter().filter(|w| step < w.steps.poses.len());
    let all = on_their_way.map(|w| (w.steps.rounds, w.steps.halves));
    let (rounds, halves) = all.fold((0, false), |a, b| (a.0.max(b.0), a.1 || b.1));
    Substep { rounds, halves }
}

/// The rest pose with the roots where a pose has them.
fn at_root(rig: &Rig, pose: &Pose) -> Pose {
    let mut start = Pose::rest(&rig.skeleton);
    for (j, joint) in rig.skeleton.joints.iter().enumerate() {
        start.matrices[j] = match joint.parent {
            Some(parent) => start.matrices[parent],
            None => pose.matrices[j],
        };
    }
    start
}
