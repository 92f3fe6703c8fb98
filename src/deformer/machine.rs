//! The two machines that walk a plan: Vulkan and the twins.

use bytemuck::Pod;

use super::{
    Device, Resource, Settings, Step,
    cpu::Store,
    heads::{self, Heads},
    plan::{self, Plan},
    pose::PoseUpload,
    resources::GpuResources,
    statics::Statics,
    volumes::Volumes,
};
use crate::{
    Result,
    field::AtlasLayout,
    frame::{Frame, Span},
    gpu::Gpu,
    report::{FrameTimings, MemoryReport},
    twin::Image,
};

/// A device with a rig's buffers on it and the frame to run.
pub(super) enum Machine {
    /// The twins.
    Cpu(Box<CpuMachine>),
    /// Vulkan.
    Gpu(Box<GpuMachine>),
}

/// Buffers in host memory.
pub(super) struct CpuMachine {
    pub(super) store: Store,
    plan: Plan,
    layout: AtlasLayout,
}

/// Buffers in device memory.
pub(super) struct GpuMachine {
    pub(super) gpu: Gpu,
    pub(super) resources: GpuResources,
    pub(super) frame: Frame,
    plan: Plan,
    /// The order of the frame's steps, kept for its memory.
    pub(super) spans: Vec<Span>,
    layout: AtlasLayout,
}

impl Machine {
    pub(super) fn new(
        device: &Device,
        statics: &Statics,
        volumes: Volumes,
        settings: &Settings,
    ) -> Result<Self> {
        let plan = plan::frame(&statics.sizes, settings);
        match (device, volumes) {
            (
                Device::Gpu(gpu),
                Volumes::Gpu {
                    layout,
                    atlas,
                    operators,
                },
            ) => {
                let slices = u64::from(settings.max_slices());
                let mut all = plan.steps.clone();
                if settings.method.has_fields() {
                    all.extend(plan::measure_iso(&statics.sizes));
                }
                let images = [atlas, operators];
                let resources = GpuResources::new(gpu, statics, &all, images, slices)?;
                let (name, instances) = (settings.method.name(), settings.instances);
                let mut builder = resources.builder(gpu, name, &plan.steps, instances);
                for section in plan.sections() {
                    builder.fix(section);
                }
                Ok(Self::Gpu(Box::new(GpuMachine {
                    gpu: gpu.clone(),
                    resources,
                    frame: builder.build()?,
                    plan,
                    spans: Vec::with_capacity(settings.max_runs()),
                    layout,
                })))
            }
            (_, volumes) => {
                let (layout, atlas, operators) = volumes.into_images()?;
                let instances = settings.instances as usize;
                let store = Store::new(statics, instances, atlas, operators);
                Ok(Self::Cpu(Box::new(CpuMachine {
                    store,
                    plan,
                    layout,
                })))
            }
        }
    }

    pub(super) fn layout(&self) -> AtlasLayout {
        match self {
            Self::Cpu(m) => m.layout,
            Self::Gpu(m) => m.layout,
        }
    }

    /// Uploads the sub-steps' poses and runs (or submits) the frame.
    pub(super) fn advance(&mut self, upload: &PoseUpload) -> Result<()> {
        match self {
            Self::Cpu(m) => {
                m.store.pose(upload);
                let (plan, store) = (&m.plan, &mut m.store);
                for instance in 0..store.instances() {
                    store.instance = instance;
                    plan.for_each_run(upload.substeps(), |run| {
                        store.run(&plan.steps[run.steps], run.slice as usize);
                    });
                }
                Ok(())
            }
            Self::Gpu(m) => {
                let slot = m.frame.begin()?;
                m.resources.pose(slot, upload)?;
                m.order(upload);
                m.frame.submit_spans(&m.spans)
            }
        }
    }

    /// Runs `steps` once for a pose of the first instance, with `content` at the beginning of `resource`.
    pub(super) fn once<T: Pod>(
        &mut self,
        steps: &[Step],
        upload: &PoseUpload,
        resource: Resource,
        content: &[T],
    ) -> Result<()> {
        self.write(resource, content)?;
        match self {
            Self::Cpu(m) => {
                m.store.pose(upload);
                m.store.instance = 0;
                m.store.run(steps, 0);
                Ok(())
            }
            Self::Gpu(m) => {
                let mut frame = m.resources.builder(&m.gpu, "rest", steps, 1).build()?;
                m.resources.pose(frame.begin()?, upload)?;
                frame.submit()?;
                frame.wait()
            }
        }
    }

    pub(super) fn wait(&mut self) -> Result<()> {
        match self {
            Self::Cpu(_) => Ok(()),
            Self::Gpu(m) => m.frame.wait(),
        }
    }

    /// Content of a buffer that the instances share, or of the first instance's; waits for the last frame.
    pub(super) fn read<T: Pod>(&mut self, resource: Resource) -> Result<Vec<T>> {
        self.read_part(resource, 0)
    }

    /// Content of an instance's buffer; waits for the last frame.
    pub(super) fn read_part<T: Pod>(
        &mut self,
        resource: Resource,
        instance: usize,
    ) -> Result<Vec<T>> {
        self.wait()?;
        match self {
            Self::Cpu(m) => {
                m.store.instance = instance;
                Ok(m.store.read(resource).to_vec())
            }
            Self::Gpu(m) => m.resources.read_part(&m.gpu, resource, instance),
        }
    }

    /// All copies of the heads of the work lists that a buffer has, one after the other; waits for the last frame.
    pub(super) fn heads(&mut self, resource: Resource, rows: usize) -> Result<Vec<Heads>> {
        self.wait()?;
        match self {
            Self::Cpu(m) => {
                let mut parts: Vec<Vec<Heads>> = Vec::new();
                for instance in 0..m.store.instances() {
                    m.store.instance = instance;
                    parts.push(copies(m.store.read(resource), rows, 1));
                }
                let copy = |i: usize| {
                    let of_all: Vec<Heads> = parts.iter().map(|p| p[i].clone()).collect();
                    Heads::join(&of_all)
                };
                Ok((0..parts[0].len()).map(copy).collect())
            }
            Self::Gpu(m) => {
                let words: Vec<u32> = m.resources.read(&m.gpu, resource)?;
                Ok(copies(&words, rows, m.resources.instances as usize))
            }
        }
    }

    /// Replaces the beginning of a buffer that the instances share, or of the first instance's.
    pub(super) fn write<T: Pod>(&mut self, resource: Resource, content: &[T]) -> Result<()> {
        self.write_part(resource, 0, content)
    }

    /// Replaces the beginning of an instance's buffer.
    pub(super) fn write_part<T: Pod>(
        &mut self,
        resource: Resource,
        instance: usize,
        content: &[T],
    ) -> Result<()> {
        match self {
            Self::Cpu(m) => {
                m.store.instance = instance;
                m.store.write(resource, content);
                Ok(())
            }
            Self::Gpu(m) => m.resources.write_part(&m.gpu, resource, instance, content),
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
            Self::Cpu(m) => m.store.memory(),
            Self::Gpu(m) => m.gpu.memory(),
        }
    }
}

impl GpuMachine {
    /// Fills the spans with the order of the steps.
    pub(super) fn order(&mut self, upload: &PoseUpload) {
        let spans = &mut self.spans;
        spans.clear();
        self.plan.for_each_run(upload.substeps(), |run| {
            spans.push(Span {
                steps: run.steps,
                index: run.slice,
            });
        });
    }
}

/// Heads that lie one copy after the other.
fn copies(words: &[u32], rows: usize, instances: usize) -> Vec<Heads> {
    let copies = words.chunks_exact(heads::words(rows, instances));
    copies
        .map(|c| Heads::of_words(c.to_vec(), instances))
        .collect()
}

/// An image with nothing in it, for bindings that a plan does not use.
pub(super) fn no_image() -> Image {
    Image {
        extent: [1; 3],
        texels: vec![[half::f16::ZERO; 4]],
    }
}
