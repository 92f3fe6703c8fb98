//! Where particles are: Vulkan, or the twin.

use bytemuck::{bytes_of, cast_slice, cast_slice_mut};

use crate::{
    Result,
    deformer::Device,
    frame::{Frame, FrameBuilder, Slot, Span},
    gpu::{Buffer, Class, Gpu, Ring},
    layout::particles::Primitive,
    pass::particles::{Constants, DECLARATION},
    report::{FrameTimings, MemoryReport},
    twin,
};

/// A device with particles on it.
pub(super) enum Machine {
    /// The twin.
    Cpu(Box<CpuMachine>),
    /// Vulkan.
    Gpu(Box<GpuMachine>),
}

/// Particles in host memory.
pub(super) struct CpuMachine {
    positions: Vec<[f32; 4]>,
    velocities: Vec<[f32; 4]>,
    solids: usize,
}

/// Particles in device memory.
pub(super) struct GpuMachine {
    pub(super) gpu: Gpu,
    /// Positions with radii, velocities with contacts.
    pub(super) rows: [Buffer; 2],
    pub(super) frame: Frame,
    /// Solids on their way to the device, of frames that are submitted and of those that a host submits: neither waits for the
    /// other.
    rings: [Ring; 2],
}

/// Who submits a frame.
#[derive(Clone, Copy)]
pub(super) enum By {
    Us,
    Host,
}

/// The pass's step, behind a copy from each of the rings.
const PASS: usize = 2;

impl By {
    /// The steps of such a frame.
    pub(super) fn spans(self) -> [Span; 2] {
        let copy = self as usize;
        [copy..copy + 1, PASS..PASS + 1].map(|steps| Span { steps, index: 0 })
    }
}

impl Machine {
    pub(super) fn new(device: &Device, solids: usize, count: u32) -> Result<Self> {
        match device {
            Device::Cpu => {
                let rows = vec![[0.0; 4]; count as usize];
                Ok(Self::Cpu(Box::new(CpuMachine {
                    positions: rows.clone(),
                    velocities: rows,
                    solids,
                })))
            }
            Device::Gpu(gpu) => Ok(Self::Gpu(Box::new(GpuMachine::new(gpu, solids, count)?))),
        }
    }

    /// Runs the frame, or submits it.
    pub(super) fn advance(&mut self, solids: &[Primitive], constants: &Constants) -> Result<()> {
        match self {
            Self::Cpu(m) => {
                m.advance(solids, constants);
                Ok(())
            }
            Self::Gpu(m) => {
                let slot = m.frame.begin()?;
                m.set(By::Us, slot, solids, constants)?;
                m.frame.submit_spans(&By::Us.spans())
            }
        }
    }

    pub(super) fn wait(&mut self) -> Result<()> {
        match self {
            Self::Cpu(_) => Ok(()),
            Self::Gpu(m) => m.frame.wait(),
        }
    }

    /// Positions with radii, velocities with contacts; waits for the last frame.
    pub(super) fn read(&mut self) -> Result<[Vec<[f32; 4]>; 2]> {
        match self {
            Self::Cpu(m) => Ok([m.positions.clone(), m.velocities.clone()]),
            Self::Gpu(m) => {
                let read = |buffer| -> Result<Vec<[f32; 4]>> {
                    Ok(bytemuck::pod_collect_to_vec(&m.gpu.download(buffer)?))
                };
                Ok([read(&m.rows[0])?, read(&m.rows[1])?])
            }
        }
    }

    /// Replaces all of them.
    pub(super) fn write(&mut self, rows: [&[[f32; 4]]; 2]) -> Result<()> {
        match self {
            Self::Cpu(m) => {
                m.positions.copy_from_slice(rows[0]);
                m.velocities.copy_from_slice(rows[1]);
                Ok(())
            }
            Self::Gpu(m) => {
                let mut pairs = m.rows.iter().zip(rows);
                pairs.try_for_each(|(buffer, rows)| m.gpu.upload(buffer, cast_slice(rows)))
            }
        }
    }

    pub(super) fn timings(&self) -> Option<FrameTimings> {
        match self {
            Self::Cpu(_) => None,
            Self::Gpu(m) => m.frame.timings(),
        }
    }

    pub(super) fn memory(&self) -> MemoryReport {
        match self {
            Self::Cpu(m) => {
                let class = Class::Transient.name();
                let rows = (m.positions.len() * size_of::<[f32; 4]>()) as u64;
                let solids = (m.solids * size_of::<Primitive>()) as u64;
                MemoryReport::sum([
                    (DECLARATION.bindings[0].name, class, solids),
                    (DECLARATION.bindings[1].name, class, rows),
                    (DECLARATION.bindings[2].name, class, rows),
                ])
            }
            Self::Gpu(m) => m.gpu.memory(),
        }
    }
}

impl CpuMachine {
    fn advance(&mut self, solids: &[Primitive], constants: &Constants) {
        let slots = vec![
            twin::Slot::Read(cast_slice(solids)),
            twin::Slot::Write(cast_slice_mut(&mut self.positions)),
            twin::Slot::Write(cast_slice_mut(&mut self.velocities)),
        ];
        twin::particles::run(&mut twin::Args::new(slots, bytes_of(constants)));
    }
}

impl GpuMachine {
    fn new(gpu: &Gpu, solids: usize, count: u32) -> Result<Self> {
        // A buffer has at least something in it.
        let bytes = solids.max(1) as u64 * size_of::<Primitive>() as u64;
        let [solid, position, velocity] = [0, 1, 2].map(|k| DECLARATION.bindings[k].name);
        let ring = || gpu.ring("particle_solids_ring", Class::PoseRing, bytes);
        let rings = [ring()?, ring()?];
        let solids = gpu.buffer(solid, Class::Transient, bytes)?;
        let row = |name| gpu.buffer(name, Class::Transient, u64::from(count) * 16);
        let rows = [row(position)?, row(velocity)?];
        let mut builder = FrameBuilder::new(gpu, DECLARATION.name);
        for ring in &rings {
            builder.copy(ring, &solids, bytes);
        }
        _ = builder
            .pass(&DECLARATION)
            .bind(solid, &solids)
            .bind(position, &rows[0])
            .bind(velocity, &rows[1])
            .constant_bytes(&[0; size_of::<Constants>()])
            .items(count);
        Ok(Self {
            frame: builder.build()?,
            gpu: gpu.clone(),
            rows,
            rings,
        })
    }

    /// Readies a frame.
    pub(super) fn set(
        &mut self,
        by: By,
        slot: Slot,
        solids: &[Primitive],
        constants: &Constants,
    ) -> Result<()> {
        self.rings[by as usize].write(slot, cast_slice(solids))?;
        self.frame.set_constants(PASS, constants)
    }
}
