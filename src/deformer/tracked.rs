//! State of a tracked skin: what the next frame goes on from.

mod bytes;

use glam::Vec3;

use super::{Deformer, Method, Resource, plan, substeps::Substeps};
use crate::{
    Error, Result,
    layout::Dispatch,
    report::Iterations,
    rig::{Pose, Rig, Skeleton},
};

/// What a tracked skin goes on from: a pose and the vertices that follow it.
///
/// Belongs to the rig and the settings of the deformer that saved it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackedState {
    /// None where the next pose is reached from rest.
    pose: Option<Pose>,
    /// Welded vertices in model space; w: movement in the last iteration, over the radius.
    tracked: Vec<[f32; 4]>,
    /// The same one iteration ago.
    before: Vec<[f32; 4]>,
    /// Gradients of the last evaluation.
    slopes: Vec<[f32; 4]>,
    /// What settling and smoothing added to each vertex, turned back to rest with its part.
    corrections: Vec<[f32; 4]>,
    /// Fields that moved with each vertex in the last sub-step.
    around: Vec<u32>,
}

impl TrackedState {
    /// The pose that the skin follows; none where it is at rest and the next pose is reached from there.
    pub fn pose(&self) -> Option<&Pose> {
        self.pose.as_ref()
    }

    /// Positions of the welded vertices in model space, before they are smoothed at contacts.
    pub fn positions(&self) -> impl Iterator<Item = Vec3> {
        self.tracked.iter().map(|p| Vec3::from_slice(p))
    }

    fn rest(rig: &Rig) -> Self {
        let positions = rig.mesh.positions.iter();
        let tracked: Vec<[f32; 4]> = positions.map(|p| p.extend(0.0).to_array()).collect();
        Self {
            pose: None,
            before: tracked.clone(),
            // Without a slope the first evaluation comes before the first slide.
            slopes: vec![[0.0; 4]; tracked.len()],
            corrections: vec![[0.0; 4]; tracked.len()],
            tracked,
            around: vec![0; rig.mesh.positions.len()],
        }
    }

    fn fits(&self, rig: &Rig) -> bool {
        let vertices = rig.mesh.positions.len();
        let fits = |rows: &Vec<[f32; 4]>| {
            rows.len() == vertices && rows.iter().flatten().all(|x| x.is_finite())
        };
        let all = [&self.tracked, &self.before, &self.slopes, &self.corrections];
        let posed = self.pose.as_ref();
        all.into_iter().all(fits)
            && self.around.len() == vertices
            && posed.is_none_or(|pose| pose.validate(&rig.skeleton).is_ok())
    }
}

/// What the façade keeps of tracking, with memory that is reused from frame to frame.
#[derive(Debug, Default)]
pub(super) struct Tracking {
    /// What the skin follows.
    pose: Pose,
    /// It follows a pose; else the next one is reached from rest.
    posed: bool,
    /// A reset or restore failed halfway: what lies on the device is no state.
    broken: bool,
    /// The last frame.
    frame: Substeps,
    /// The frame that is in the upload, and its pose.
    next: Substeps,
    next_pose: Pose,
    way: Way,
}

/// Poses on the way to another.
#[derive(Debug, Default)]
struct Way {
    start: Pose,
    /// End of the sub-step before.
    last: Pose,
    /// What the skin followed then.
    before: Pose,
    half: Pose,
}

impl Tracking {
    /// With room for all poses.
    pub(super) fn with_room(skeleton: &Skeleton) -> Self {
        let room = || Pose::rest(skeleton);
        Self {
            pose: room(),
            next_pose: room(),
            way: Way {
                start: room(),
                last: room(),
                before: room(),
                half: room(),
            },
            ..Self::default()
        }
    }
}

impl Deformer {
    /// Forgets the tracked skin: the next pose is reached from rest, whatever came before. For cuts, and to make a frame
    /// depend on its pose alone. Nothing else than tracking has such a state.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn reset(&mut self) -> Result<()> {
        if self.settings.method == Method::Tracking {
            let rest = TrackedState::rest(&self.rig);
            self.put_state(&rest)?;
            self.tracking.posed = false;
        }
        Ok(())
    }

    /// The state that the next frame goes on from; none for methods other than tracking. Waits for the last frame.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn save(&mut self) -> Result<Option<TrackedState>> {
        if self.settings.method != Method::Tracking {
            return Ok(None);
        }
        self.check_state()?;
        Ok(Some(TrackedState {
            pose: self.tracking.posed.then(|| self.tracking.pose.clone()),
            tracked: self.machine.read(Resource::Tracked)?,
            before: self.machine.read(Resource::TrackedBefore)?,
            slopes: self.machine.read(Resource::TrackedSlopes)?,
            corrections: self.machine.read(Resource::Corrections)?,
            around: self.machine.read(Resource::Around)?,
        }))
    }

    /// Goes on from a saved state.
    ///
    /// # Errors
    /// [`Error::Argument`] with subject `state` where the method is not tracking or the state is another character's;
    /// Vulkan errors.
    pub fn restore(&mut self, state: &TrackedState) -> Result<()> {
        if self.settings.method != Method::Tracking {
            return Err(Error::argument("state", "only tracking has one"));
        }
        if !state.fits(&self.rig) {
            return Err(Error::argument("state", "it is of another character"));
        }
        self.put_state(state)?;
        self.tracking.posed = state.pose.is_some();
        if let Some(pose) = &state.pose {
            self.tracking.pose.clone_from(pose);
        }
        Ok(())
    }

    fn put_state(&mut self, state: &TrackedState) -> Result<()> {
        self.machine.wait()?;
        self.tracking.broken = true;
        self.machine.write(Resource::Tracked, &state.tracked)?;
        self.machine.write(Resource::TrackedBefore, &state.before)?;
        self.machine.write(Resource::TrackedSlopes, &state.slopes)?;
        self.machine
            .write(Resource::Corrections, &state.corrections)?;
        self.machine.write(Resource::Around, &state.around)?;
        self.tracking.broken = false;
        Ok(())
    }

    fn check_state(&self) -> Result<()> {
        if self.tracking.broken {
            let reason = "a reset or restore failed halfway; it has to be done again";
            return Err(Error::argument("state", reason));
        }
        Ok(())
    }

    /// Fills the upload with the sub-steps to a validated pose.
    pub(super) fn upload_substeps(&mut self, pose: &Pose) -> Result<()> {
        self.check_state()?;
        let layout = self.machine.layout();
        let Self {
            rig,
            statics,
            settings,
            upload,
            tracking,
            ..
        } = self;
        let skeleton = &rig.skeleton;
        let Way {
            start,
            last,
            before,
            half,
        } = &mut tracking.way;
        if tracking.posed {
            start.clone_from(&tracking.pose);
            before.clone_from(start);
        } else {
            // At rest the tracked skin is not yet where the root carries it.
            before.put_rest(skeleton);
            put_at_root(rig, pose, start);
        }
        last.clone_from(start);
        let steps = Substeps::new(skeleton, settings, start, pose);
        let substep = steps.substep();
        let end = &mut tracking.next_pose;
        upload.begin(steps.turned);
        for k in 1..=steps.count {
            steps.put_pose(skeleton, [start, pose], k, end)?;
            let mut push = |from: &Pose, to: &Pose| {
                upload.push(rig, statics, &layout, Some(from), to);
            };
            push(before, end);
            if substep.halves {
                half.put_between(skeleton, last, end, 0.5)?;
                push(before, half);
                push(half, end);
            }
            upload.end_substep(substep);
            last.clone_from(end);
            before.clone_from(end);
        }
        tracking.next = steps;
        Ok(())
    }

    /// The frame in the upload is on its way: a tracked skin follows its pose.
    pub(super) fn follow(&mut self) {
        if self.settings.method != Method::Tracking {
            return;
        }
        let tracking = &mut self.tracking;
        std::mem::swap(&mut tracking.pose, &mut tracking.next_pose);
        (tracking.posed, tracking.frame) = (true, tracking.next);
    }

    /// Iterations of the last tracked frame.
    pub(super) fn tracking_iterations(&mut self) -> Result<Iterations> {
        let history = self.machine.read::<Dispatch>(Resource::History)?;
        let frame = self.tracking.frame;
        let substep = frame.substep();
        let rounds = (substep.rounds * substep.slices()) as usize;
        let heads: Vec<_> = history
            .chunks_exact(plan::rows::COUNT as usize)
            .take(frame.count as usize * rounds)
            .collect();
        let live = heads
            .iter()
            .map(|heads| heads[plan::rows::LIVE as usize].count);
        let run = live.clone().filter(|count| *count > 0).count() as u32;
        let evaluations: u64 = live
            .map(|count| u64::from(count * (plan::ROUND / plan::STRIDE)))
            .sum();
        // The first round of a first half tells whether there are halves.
        let mut halved = 0;
        for first in (0..frame.count as usize).map(|k| k * rounds) {
            let half = first + substep.rounds as usize;
            let redo = substep.halves && heads[half][plan::rows::REDO as usize].groups[0] > 0;
            halved += u32::from(redo);
        }
        let seeds = self.machine.read::<Dispatch>(Resource::SeedDispatches)?[0].count;
        Ok(Iterations {
            newton_mean: evaluations as f64 / f64::from(seeds.max(1)),
            newton_max: run * (plan::ROUND / plan::STRIDE),
            rounds: run,
            jacobi: run * plan::ROUND,
            substeps: frame.count,
            halved,
            capped: frame.capped,
            evaluations,
            fetches: 0,
        })
    }
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

/// Vertices at rest with a triangle whose normal faces along the gradient (`shaders/judge.comp`).
pub(super) fn rest_faults(rig: &Rig, seeds: &[u32], directions: &[[f32; 4]]) -> u32 {
    let place = |v: u32| rig.mesh.positions[v as usize];
    let inverted = |v: &&u32| {
        let (x, inward) = (place(**v), Vec3::from_slice(&directions[**v as usize]));
        let corners = rig.mesh.corners.row(**v as usize).chunks_exact(2);
        let normals = corners.map(|c| (place(c[0]) - x).cross(place(c[1]) - x));
        normals
            .into_iter()
            .any(|n| n.dot(inward) > 0.5 * n.length())
    };
    seeds.iter().filter(inverted).count() as u32
}
