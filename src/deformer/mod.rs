//! The façade: a rig, a device and a method; poses in, skin out.

mod cpu;
mod embed;
mod heads;
mod instance;
mod machine;
mod places;
mod plan;
mod pose;
mod resource;
mod resources;
mod settings;
mod statics;
mod substeps;
mod tracked;
mod volumes;
mod ways;

use std::{sync::Arc, time::Instant};

use glam::Vec3;

pub use embed::{Normals, Output, VertexLayout};
pub(crate) use embed::{frame_slot, no_commands};
pub use instance::{Instance, Poses};
pub use places::Places;
pub use plan::{Extent, Pass, Sizes, Step};
pub use resource::{Kind, Resource};
pub use settings::{Method, Settings};
pub use tracked::TrackedState;

use crate::{
    Result,
    gpu::Gpu,
    layout::state,
    report::{FrameTimings, Iterations, MemoryReport},
    rig::{Pose, Rig},
};
use machine::Machine;
use pose::PoseUpload;
use statics::Statics;
use tracked::{Tracking, rest_faults};

/// Where a deformer runs.
#[derive(Clone)]
pub enum Device {
    /// The twins of all passes, in order: the same results, slowly.
    Cpu,
    /// A Vulkan device.
    Gpu(Gpu),
}

/// A deformed character, in model space, a row a vertex of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Positions.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Composed field at the vertex; 0 for geometric methods and vertices.
    pub field: Vec<f32>,
    /// Iso-value of the vertex; 0 for geometric methods and vertices.
    pub iso: Vec<f32>,
    /// 0 untouched, 1 on its iso-value, 2 stopped in contact, 3 outside every field, 4 iteration limit or, in tracking, on its way,
    /// 5 past the limit of its spine's map.
    pub state: Vec<u8>,
    /// Joint row of the vertex's part.
    pub bone: Vec<u16>,
}

/// A character on a device, following poses: one instance of it, or several ([`Settings::instances`]).
pub struct Deformer {
    rig: Arc<Rig>,
    settings: Settings,
    statics: Statics,
    upload: PoseUpload,
    machine: Machine,
    tracking: Tracking,
    record_ns: u64,
}

impl Deformer {
    /// Uploads the rig, samples its fields, builds the frame and measures the iso-values at rest.
    ///
    /// # Errors
    /// Memory, Vulkan and shader errors; [`crate::Error::Argument`] for settings or rigs out of range.
    pub fn new(device: &Device, rig: Arc<Rig>, settings: &Settings) -> Result<Self> {
        settings.check()?;
        // On the CPU instances run one after the other, each with buffers of its own.
        let instances = match device {
            Device::Cpu => 1,
            Device::Gpu(_) => settings.instances,
        };
        let together = Settings {
            instances,
            ..*settings
        };
        let statics = Statics::new(&rig, &together)?;
        let volumes = volumes::prepare(device, &rig, &statics, settings)?;
        let mut deformer = Self {
            machine: Machine::new(device, &statics, volumes, settings)?,
            upload: PoseUpload::with_room(&statics, settings),
            tracking: Tracking::with_room(&rig.skeleton, settings),
            settings: *settings,
            statics,
            rig,
            record_ns: 0,
        };
        deformer.measure_rest()?;
        deformer.reset()?;
        Ok(deformer)
    }

    /// Deforms all instances, each for its pose; one pose will do for one instance. On a GPU the work is submitted, not waited
    /// for.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] with subject `poses` where there are not as many as instances; [`crate::Error::Pose`] where
    /// a matrix is not finite or not invertible; Vulkan errors. Nothing has changed then.
    pub fn advance<'a>(&mut self, poses: impl Into<Poses<'a>>) -> Result<()> {
        self.set_poses(poses.into())?;
        let begin = Instant::now();
        self.machine.advance(&self.upload)?;
        self.follow();
        self.record_ns = begin.elapsed().as_nanos() as u64;
        Ok(())
    }

    /// Fills the upload for poses; what fails leaves the skin as it was.
    fn set_poses(&mut self, poses: Poses<'_>) -> Result<()> {
        let poses = poses.checked(&self.rig, self.instances())?;
        if self.settings.method == Method::Tracking {
            self.upload_substeps(poses)?;
        } else {
            let layout = self.machine.layout();
            self.upload.set(&self.rig, &self.statics, &layout, poses);
        }
        Ok(())
    }

    /// Waits until the last poses are deformed.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn wait(&mut self) -> Result<()> {
        self.machine.wait()
    }

    /// The last deformed skin of the first instance; waits for it. [`Deformer::instance`] has the others.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn read(&mut self) -> Result<Skin> {
        self.instance(0)?.read()
    }

    /// GPU times of the last completed frame, where timestamps are on; none on the CPU.
    pub fn timings(&self) -> Option<FrameTimings> {
        self.machine.timings()
    }

    /// CPU time that the last [`Deformer::advance`] took to record and submit, nanoseconds.
    pub fn record_ns(&self) -> u64 {
        self.record_ns
    }

    /// Bytes by class and name.
    pub fn memory(&self) -> MemoryReport {
        self.machine.memory()
    }

    /// Evaluations and fetches of the last frame, of all instances together; waits for it.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn iterations(&mut self) -> Result<Iterations> {
        match self.settings.method {
            Method::Implicit => {}
            Method::Tracking => return self.tracking_iterations(),
            Method::Lbs | Method::Dqs => return Ok(Iterations::default()),
        }
        let mut status = Vec::new();
        for instance in 0..self.instances() as usize {
            status.extend(self.machine.read_part::<u32>(Resource::Status, instance)?);
        }
        let rows = plan::dispatch_rows(&self.settings) as usize;
        let heads = &self.machine.heads(Resource::Dispatches, rows)?[0];
        let evaluations = status.iter().map(|s| u64::from(state::evaluations(*s)));
        Ok(Iterations {
            newton_mean: evaluations.clone().sum::<u64>() as f64 / heads.count(1).max(1) as f64,
            newton_max: evaluations.clone().max().unwrap_or(0) as u32,
            rounds: (1..=self.settings.rounds as usize)
                .filter(|row| heads.count(*row) > 0)
                .count() as u32,
            jacobi: 0,
            substeps: 1,
            halved: 0,
            capped: false,
            evaluations: evaluations.sum(),
            fetches: status.iter().map(|s| u64::from(state::fetches(*s))).sum(),
        })
    }

    /// The rig.
    pub fn rig(&self) -> &Arc<Rig> {
        &self.rig
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Iso-values by the same shader code as the frame's, so that the rest pose is a fixed point.
    fn measure_rest(&mut self) -> Result<()> {
        if !self.settings.method.has_fields() {
            return Ok(());
        }
        let rest: Vec<[f32; 4]> = self
            .rig
            .mesh
            .positions
            .iter()
            .map(|p| p.extend(0.0).to_array())
            .collect();
        let pose = Pose::rest(&self.rig.skeleton);
        let layout = self.machine.layout();
        let poses = std::slice::from_ref(&pose);
        self.upload.set(&self.rig, &self.statics, &layout, poses);
        self.machine.once(
            &plan::measure_iso(&self.statics.sizes),
            &self.upload,
            Resource::Positions,
            &rest,
        )?;
        let iso = self.machine.read::<f32>(Resource::IsoValues)?;
        let seeds = Statics::seeds(&self.rig, &iso);
        let mut heads = self.statics.heads(&self.settings, seeds.len());
        let ranks = Statics::seed_ranks(iso.len(), &seeds);
        self.machine.write(Resource::SeedList, &seeds)?;
        self.machine.write(Resource::SeedRanks, &ranks)?;
        if self.settings.method == Method::Tracking {
            let bodies = Statics::bodies(&self.rig, &iso, &ranks);
            self.machine.write(Resource::Bodies, &bodies)?;
            let directions = self.machine.read::<[f32; 4]>(Resource::Directions)?;
            let faults = rest_faults(&self.rig, &seeds, &directions);
            heads.set_counts(plan::rows::REDO as usize, faults);
        }
        self.machine.write(Resource::SeedDispatches, heads.words())
    }
}

#[cfg(test)]
mod tests;
