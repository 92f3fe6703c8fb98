//! The façade: a rig, a device and a method; poses in, skin out.

mod cpu;
mod embed;
mod machine;
mod places;
mod plan;
mod pose;
mod resource;
mod settings;
mod statics;
mod substeps;
mod tracked;
mod volumes;

use std::{sync::Arc, time::Instant};

use glam::Vec3;

pub use embed::{Normals, Output, VertexLayout};
pub use places::Places;
pub use plan::{Extent, Pass, Sizes, Step};
pub use resource::{Kind, Resource};
pub use settings::{Method, Settings};
pub use tracked::TrackedState;

use crate::{
    Result,
    gpu::Gpu,
    layout::{Dispatch, state},
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
    /// 0 untouched, 1 on its iso-value, 2 stopped in contact, 3 outside every field, 4 iteration limit.
    pub state: Vec<u8>,
    /// Joint row of the vertex's part.
    pub bone: Vec<u16>,
}

/// A character on a device, following poses.
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
        let statics = Statics::new(&rig, settings)?;
        let volumes = volumes::prepare(device, &rig, &statics, settings)?;
        let mut deformer = Self {
            machine: Machine::new(device, &statics, volumes, settings)?,
            upload: PoseUpload::with_room(&statics, settings.max_slices() as usize),
            tracking: Tracking::with_room(&rig.skeleton),
            settings: *settings,
            statics,
            rig,
            record_ns: 0,
        };
        deformer.measure_rest()?;
        deformer.reset()?;
        Ok(deformer)
    }

    /// Deforms for a pose. On a GPU the work is submitted, not waited for.
    ///
    /// # Errors
    /// [`crate::Error::Pose`] where a matrix is not finite or not invertible; Vulkan errors.
    pub fn advance(&mut self, pose: &Pose) -> Result<()> {
        self.set_pose(pose)?;
        let begin = Instant::now();
        self.machine.advance(&self.upload)?;
        self.follow();
        self.record_ns = begin.elapsed().as_nanos() as u64;
        Ok(())
    }

    /// Fills the upload for a pose; what fails leaves the skin as it was.
    fn set_pose(&mut self, pose: &Pose) -> Result<()> {
        pose.validate(&self.rig.skeleton)?;
        if self.settings.method == Method::Tracking {
            self.upload_substeps(pose)?;
        } else {
            let layout = self.machine.layout();
            self.upload.set(&self.rig, &self.statics, &layout, pose);
        }
        Ok(())
    }

    /// Waits until the last pose is deformed.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn wait(&mut self) -> Result<()> {
        self.machine.wait()
    }

    /// The last deformed skin; waits for it.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn read(&mut self) -> Result<Skin> {
        let positions = self.machine.read::<[f32; 4]>(Resource::SkinPositions)?;
        let normals = self.machine.read::<[f32; 4]>(Resource::SkinNormals)?;
        let implicit = self.settings.method.has_fields();
        let (status, iso) = if implicit {
            (
                self.machine.read::<u32>(Resource::Status)?,
                self.machine.read::<f32>(Resource::IsoValues)?,
            )
        } else {
            let none = self.statics.sizes.vertices as usize;
            (vec![0; none], vec![0.0; none])
        };
        let rows = &self.rig.rows.vertex;
        let of = |row: &u32| *row as usize;
        Ok(Skin {
            positions: positions[..rows.len()]
                .iter()
                .map(|p| Vec3::from_slice(p))
                .collect(),
            normals: normals[..rows.len()]
                .iter()
                .map(|n| Vec3::from_slice(n))
                .collect(),
            field: positions[..rows.len()].iter().map(|p| p[3]).collect(),
            iso: rows
                .iter()
                .map(|r| self.followed_iso(of(r), &status, &iso))
                .collect(),
            state: rows
                .iter()
                .map(|r| self.reported_state(implicit, of(r), &status, &iso))
                .collect(),
            bone: rows.iter().map(|r| self.rig.part[of(r)]).collect(),
        })
    }

    /// A vertex that follows no field has no iso-value either.
    fn followed_iso(&self, v: usize, status: &[u32], iso: &[f32]) -> f32 {
        let untouched = state::of(status[v]) == state::UNTOUCHED;
        if untouched { 0.0 } else { iso[v] }
    }

    /// Vertices that no field reaches at rest are outside; the frame never lists them.
    fn reported_state(&self, implicit: bool, v: usize, status: &[u32], iso: &[f32]) -> u8 {
        let state = state::of(status[v]);
        if implicit
            && state == state::UNTOUCHED
            && !self.rig.geometric[v]
            && !statics::reached(iso[v])
        {
            state::OUTSIDE as u8
        } else {
            state as u8
        }
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

    /// Evaluations and fetches of the last frame; waits for it.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn iterations(&mut self) -> Result<Iterations> {
        match self.settings.method {
            Method::Implicit => {}
            Method::Tracking => return self.tracking_iterations(),
            Method::Lbs | Method::Dqs => return Ok(Iterations::default()),
        }
        let status = self.machine.read::<u32>(Resource::Status)?;
        let heads = self.machine.read::<Dispatch>(Resource::Dispatches)?;
        let evaluations = status.iter().map(|s| u64::from(state::evaluations(*s)));
        Ok(Iterations {
            newton_mean: evaluations.clone().sum::<u64>() as f64 / heads[1].count.max(1) as f64,
            newton_max: evaluations.clone().max().unwrap_or(0) as u32,
            rounds: heads[1..=self.settings.rounds as usize]
                .iter()
                .filter(|h| h.count > 0)
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
        self.upload.set(&self.rig, &self.statics, &layout, &pose);
        self.machine.once(
            &plan::measure_iso(&self.statics.sizes),
            &self.upload,
            Resource::Positions,
            &rest,
        )?;
        let iso = self.machine.read::<f32>(Resource::IsoValues)?;
        let seeds = Statics::seeds(&self.rig, &iso);
        let mut heads = Statics::dispatches(&self.settings, seeds.len());
        let ranks = Statics::seed_ranks(iso.len(), &seeds);
        self.machine.write(Resource::SeedList, &seeds)?;
        self.machine.write(Resource::SeedRanks, &ranks)?;
        if self.settings.method == Method::Tracking {
            let bodies = Statics::bodies(&self.rig, &iso, &ranks);
            self.machine.write(Resource::Bodies, &bodies)?;
            let directions = self.machine.read::<[f32; 4]>(Resource::Directions)?;
            heads[plan::rows::REDO as usize].count = rest_faults(&self.rig, &seeds, &directions);
        }
        self.machine.write(Resource::SeedDispatches, &heads)
    }
}

#[cfg(test)]
mod tests;
