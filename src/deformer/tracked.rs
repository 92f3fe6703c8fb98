//! State of a tracked skin: what the next frame goes on from.

mod bytes;

use glam::Vec3;

use super::{
    Deformer, Method, Resource, Settings, plan,
    plan::Substep,
    ways::{Context, Way},
};
use crate::{
    Error, Result,
    report::Iterations,
    rig::{Pose, Rig, Skeleton},
};

/// What a tracked skin goes on from: a pose and the vertices that follow it.
///
/// Belongs to the rig and the settings of the deformer that saved it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackedState {
    /// None where the next pose is reached from rest.
    pub(super) pose: Option<Pose>,
    /// Welded vertices in model space; w: movement in the last iteration, over the radius.
    pub(super) tracked: Vec<[f32; 4]>,
    /// The same one iteration ago.
    pub(super) before: Vec<[f32; 4]>,
    /// Gradients of the last evaluation.
    pub(super) slopes: Vec<[f32; 4]>,
    /// What settling and smoothing added to each vertex, turned back to rest with its part.
    pub(super) corrections: Vec<[f32; 4]>,
    /// Fields that moved with each vertex in the last sub-step.
    pub(super) around: Vec<u32>,
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

    pub(super) fn rest(rig: &Rig) -> Self {
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

    pub(super) fn fits(&self, rig: &Rig) -> bool {
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
    /// An instance each.
    pub(super) skins: Vec<Followed>,
    /// The frame that is in the upload.
    ways: Vec<Way>,
    /// The last frame.
    substeps: Vec<Substep>,
    capped: bool,
}

/// What the skin of an instance follows.
#[derive(Debug)]
pub(super) struct Followed {
    pose: Pose,
    /// It follows that pose; else the next one is reached from rest.
    posed: bool,
    /// A reset or restore failed halfway: what lies on the device is no state.
    pub(super) broken: bool,
}

impl Followed {
    /// None where the next pose is reached from rest.
    pub(super) fn pose(&self) -> Option<&Pose> {
        self.posed.then_some(&self.pose)
    }

    /// Goes on from a state's pose.
    pub(super) fn set(&mut self, pose: Option<&Pose>) {
        self.posed = pose.is_some();
        if let Some(pose) = pose {
            self.pose.clone_from(pose);
        }
    }

    /// # Errors
    /// [`Error::Argument`] where there is no state to go on from.
    pub(super) fn check(&self) -> Result<()> {
        if self.broken {
            let reason = "a reset or restore failed halfway; it has to be done again";
            return Err(Error::argument("state", reason));
        }
        Ok(())
    }
}

impl Tracking {
    /// With room for all poses.
    pub(super) fn with_room(skeleton: &Skeleton, settings: &Settings) -> Self {
        let skin = || Followed {
            pose: Pose::rest(skeleton),
            posed: false,
            broken: false,
        };
        let instances = 0..settings.instances;
        Self {
            skins: instances.clone().map(|_| skin()).collect(),
            ways: instances.map(|_| Way::with_room(skeleton)).collect(),
            substeps: Vec::with_capacity(settings.max_substeps as usize),
            capped: false,
        }
    }
}

impl Deformer {
    /// Forgets the tracked skins of all instances: their next poses are reached from rest, whatever came before. For cuts, and
    /// to make a frame depend on its poses alone. Nothing else than tracking has such a state.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn reset(&mut self) -> Result<()> {
        (0..self.instances()).try_for_each(|row| self.instance(row)?.reset())
    }

    /// The state that the next frame of the first instance goes on from; none for methods other than tracking. Waits for the
    /// last frame. [`Deformer::instance`] has the others.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn save(&mut self) -> Result<Option<TrackedState>> {
        self.instance(0)?.save()
    }

    /// Lets the first instance go on from a saved state. [`Deformer::instance`] has the others.
    ///
    /// # Errors
    /// [`Error::Argument`] with subject `state` where the method is not tracking or the state is
    /// another character's; Vulkan errors.
    pub fn restore(&mut self, state: &TrackedState) -> Result<()> {
        self.instance(0)?.restore(state)
    }

    /// Fills the upload with the sub-steps to validated poses, one an instance.
    pub(super) fn upload_substeps(&mut self, poses: &[Pose]) -> Result<()> {
        let tracking = &mut self.tracking;
        tracking.skins.iter().try_for_each(Followed::check)?;
        let context = Context {
            rig: &self.rig,
            settings: &self.settings,
            statics: &self.statics,
            layout: self.machine.layout(),
        };
        context.upload(&mut tracking.ways, &tracking.skins, poses, &mut self.upload)
    }

    /// The frame in the upload is on its way: the tracked skins follow its poses.
    pub(super) fn follow(&mut self) {
        if self.settings.method != Method::Tracking {
            return;
        }
        let tracking = &mut self.tracking;
        for (skin, way) in tracking.skins.iter_mut().zip(&mut tracking.ways) {
            std::mem::swap(&mut skin.pose, &mut way.end);
            skin.posed = true;
        }
        tracking.substeps.clear();
        tracking.substeps.extend_from_slice(self.upload.substeps());
        tracking.capped = tracking.ways.iter().any(|way| way.steps.capped);
    }

    /// Iterations of the last tracked frame.
    pub(super) fn tracking_iterations(&mut self) -> Result<Iterations> {
        let rows = plan::rows::COUNT as usize;
        let history = self.machine.heads(Resource::History, rows)?;
        let seeds = &self.machine.heads(Resource::SeedDispatches, rows)?[0];
        let substeps = &self.tracking.substeps;
        let rounds = substeps.iter().map(|s| (s.rounds * s.slices()) as usize);
        let heads = &history[..rounds.sum()];
        let live = heads.iter().map(|h| h.count(plan::rows::LIVE as usize));
        let run = live.clone().filter(|count| *count > 0).count() as u32;
        let each = plan::ROUND / plan::STRIDE;
        let evaluations = live.sum::<u64>() * u64::from(each);
        // The first round of a first half tells whether there are halves.
        let mut halved = 0;
        let mut first = 0;
        for substep in substeps {
            let half = first + substep.rounds as usize;
            first += (substep.rounds * substep.slices()) as usize;
            let redo = substep.halves && heads[half].groups(plan::rows::REDO as usize) > 0;
            halved += u32::from(redo);
        }
        let seeds = seeds.count(plan::rows::SEEDS as usize);
        Ok(Iterations {
            newton_mean: evaluations as f64 / seeds.max(1) as f64,
            newton_max: run * each,
            rounds: run,
            jacobi: run * plan::ROUND,
            substeps: substeps.len() as u32,
            halved,
            capped: self.tracking.capped,
            evaluations,
            fetches: 0,
        })
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
