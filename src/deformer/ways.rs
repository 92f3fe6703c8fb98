//! The ways of all instances through the sub-steps of a frame of tracking. A frame has as many as the instance that goes
//! furthest; the others arrive earlier and wait.

use super::{
    Settings,
    plan::Substep,
    pose::{PoseUpload, Turn},
    statics::Statics,
    substeps::Substeps,
    tracked::Followed,
};
use crate::{
    Result,
    field::AtlasLayout,
    rig::{Pose, Rig, Skeleton},
};

/// The way of an instance from the pose that its skin follows to the next one; its memory is reused from frame to frame.
#[derive(Debug)]
pub(super) struct Way {
    pub(super) steps: Substeps,
    start: Pose,
    /// What the skin followed before the sub-step: the end of the one before, at first its rest or the pose that it had.
    before: Pose,
    half: Pose,
    /// End of the sub-step; after the last one, of the way.
    pub(super) end: Pose,
}

impl Way {
    /// With room for all poses.
    pub(super) fn with_room(skeleton: &Skeleton) -> Self {
        let room = || Pose::rest(skeleton);
        Self {
            steps: Substeps::default(),
            start: room(),
            before: room(),
            half: room(),
            end: room(),
        }
    }

    /// Begins at where the skin is (none for rest), towards a validated pose.
    fn begin(&mut self, rig: &Rig, settings: &Settings, tracked: Option<&Pose>, pose: &Pose) {
        match tracked {
            Some(tracked) => {
                self.start.clone_from(tracked);
                self.before.clone_from(tracked);
            }
            // At rest the tracked skin is not yet where the root carries it.
            None => {
                self.before.put_rest(&rig.skeleton);
                put_at_root(rig, pose, &mut self.start);
            }
        }
        self.steps = Substeps::new(&rig.skeleton, settings, &self.start, pose);
    }

    /// Has not arrived before this sub-step, counted from 1.
    fn is_on_its_way(&self, step: u32) -> bool {
        step <= self.steps.count
    }

    /// Goes on to a sub-step towards a pose.
    fn go_on(&mut self, skeleton: &Skeleton, step: u32, pose: &Pose) -> Result<()> {
        if step > 1 {
            self.before.clone_from(&self.end);
        }
        let ends = [&self.start, pose];
        self.steps.put_pose(skeleton, ends, step, &mut self.end)?;
        if self.steps.halves {
            // What the skin followed before, unless that was its rest.
            let last = if step > 1 { &self.before } else { &self.start };
            self.half.put_between(skeleton, last, &self.end, 0.5)?;
        }
        Ok(())
    }

    /// The poses that a slice of a sub-step goes from and to: the whole, its first half, its second half. None where the
    /// instance has arrived, or does not go by halves.
    fn slice(&self, step: u32, slice: u32) -> Option<(&Pose, &Pose)> {
        let goes = self.is_on_its_way(step) && (slice == 0 || self.steps.halves);
        goes.then_some(match slice {
            0 => (&self.before, &self.end),
            1 => (&self.before, &self.half),
            _ => (&self.half, &self.end),
        })
    }
}

/// What goes into the uploads beside the ways.
pub(super) struct Context<'a> {
    pub(super) rig: &'a Rig,
    pub(super) settings: &'a Settings,
    pub(super) statics: &'a Statics,
    pub(super) layout: AtlasLayout,
}

impl Context<'_> {
    /// Fills an upload with the slices of all ways, from what the skins follow to validated poses.
    pub(super) fn upload(
        &self,
        ways: &mut [Way],
        skins: &[Followed],
        poses: &[Pose],
        upload: &mut PoseUpload,
    ) -> Result<()> {
        for ((way, skin), pose) in ways.iter_mut().zip(skins).zip(poses) {
            way.begin(self.rig, self.settings, skin.pose(), pose);
        }
        upload.clear(ways.len());
        let steps = ways.iter().map(|w| w.steps.count).max().unwrap_or(0);
        let mut round = 0;
        for step in 1..=steps {
            for (way, pose) in ways.iter_mut().zip(poses) {
                if way.is_on_its_way(step) {
                    way.go_on(&self.rig.skeleton, step, pose)?;
                }
            }
            let substep = substep(ways, step);
            for slice in 0..substep.slices() {
                for way in ways.iter() {
                    self.part(upload, way, (step, slice), round);
                }
                round += substep.rounds;
            }
            upload.end_substep(substep);
        }
        Ok(())
    }

    fn part(&self, upload: &mut PoseUpload, way: &Way, (step, slice): (u32, u32), round: u32) {
        let Some((from, to)) = way.slice(step, slice) else {
            return upload.repeat();
        };
        upload.push(self.rig, self.statics, &self.layout, Some(from), to);
        upload.set_turn(Turn {
            last_round: round + way.steps.rounds - 1,
            carried: true,
            halves: slice == 0 && way.steps.halves,
            degrees: way.steps.turned,
        });
    }
}

/// A sub-step of the frame: what the instances need that have not arrived.
fn substep(ways: &[Way], step: u32) -> Substep {
    let on_their_way = ways.iter().filter(|w| w.is_on_its_way(step));
    let all = on_their_way.map(|w| w.steps.substep());
    all.fold(Substep::default(), |a, b| Substep {
        rounds: a.rounds.max(b.rounds),
        halves: a.halves || b.halves,
    })
}

/// The rest pose with the roots where a pose has them.
fn put_at_root(rig: &Rig, pose: &Pose, start: &mut Pose) {
    start.put_rest(&rig.skeleton);
    for (j, joint) in rig.skeleton.joints.iter().enumerate() {
        start.matrices[j] = match joint.parent {
            Some(parent) => start.matrices[parent],
            None => pose.matrices[j],
        };
    }
}
