//! The two machines that walk a plan: Vulkan and the twins.

use bytemuck::{Pod, cast_slice};

use super::{
    Device, Kind, Resource, Settings, Step,
    cpu::Store,
    plan::{self, Extent, Plan},
    pose::PoseUpload,
    statics::Statics,
    volumes::Volumes,
};
use crate::{
    Result,
    field::AtlasLayout,
    frame::{Frame, FrameBuilder, Slot, Span},
    gpu::{Buffer, Gpu, Image3d, Ring},
    layout::Dispatch,
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

/// What a plan's steps bind on a GPU.
pub(super) struct GpuResources {
    /// A row a [`Resource`]; none where the method needs no such buffer.
    buffers: Vec<Option<Buffer>>,
    palette: Ring,
    fields: Ring,
    /// Bytes of a slice of these.
    slices: [u64; 2],
    atlas: Image3d,
    operators: Image3d,
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
                let frame = resources.frame(gpu, settings.method.name(), &plan.steps)?;
                Ok(Self::Gpu(Box::new(GpuMachine {
                    gpu: gpu.clone(),
                    resources,
                    frame,
                    plan,
                    spans: Vec::with_capacity(settings.max_runs()),
                    layout,
                })))
            }
            (_, volumes) => {
                let (layout, atlas, operators) = volumes.into_images()?;
                let store = Store::new(statics, atlas, operators);
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
                plan.for_each_run(upload.substeps(), |run| {
                    store.run(&plan.steps[run.steps], run.slice as usize);
                });
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

    /// Runs `steps` once for a pose, with `content` at the beginning of `resource`.
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
                m.store.run(steps, 0);
                Ok(())
            }
            Self::Gpu(m) => {
                let mut frame = m.resources.frame(&m.gpu, "rest", steps)?;
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

    /// Content of a buffer; waits for the last frame.
    pub(super) fn read<T: Pod>(&mut self, resource: Resource) -> Result<Vec<T>> {
        self.wait()?;
        match self {
            Self::Cpu(m) => Ok(m.store.read(resource).to_vec()),
            Self::Gpu(m) => m.resources.read(&m.gpu, resource),
        }
    }

    /// Replaces the beginning of a buffer.
    pub(super) fn write<T: Pod>(&mut self, resource: Resource, content: &[T]) -> Result<()> {
        match self {
            Self::Cpu(m) => {
                m.store.write(resource, content);
                Ok(())
            }
            Self::Gpu(m) => m.resources.write(&m.gpu, resource, content),
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

impl GpuResources {
    fn new(
        gpu: &Gpu,
        statics: &Statics,
        steps: &[Step],
        [atlas, operators]: [Image3d; 2],
        slices: u64,
    ) -> Result<Self> {
        let mut buffers = Vec::new();
        for &resource in Resource::ALL {
            let buffered = matches!(resource.kind(), Kind::Static | Kind::Transient);
            let buffer = (buffered && is_used(resource, steps))
                .then(|| create(gpu, statics, resource))
                .transpose()?;
            buffers.push(buffer);
        }
        let joints = statics.joints.max(1) * size_of::<crate::layout::JointPose>();
        let bytes = [joints as u64, statics.fields_bytes() as u64];
        let ring = |r: Resource, bytes: u64| gpu.ring(r.label(), r.class(), slices * bytes);
        Ok(Self {
            buffers,
            palette: ring(Resource::PaletteRing, bytes[0])?,
            fields: ring(Resource::FieldsRing, bytes[1])?,
            slices: bytes,
            atlas,
            operators,
        })
    }

    /// A frame that walks `steps` over these resources.
    pub(super) fn frame(&self, gpu: &Gpu, name: &'static str, steps: &[Step]) -> Result<Frame> {
        let mut builder = FrameBuilder::new(gpu, name);
        for step in steps {
            self.add(&mut builder, step);
        }
        builder.build()
    }

    fn add(&self, builder: &mut FrameBuilder, step: &Step) {
        match step {
            Step::Clear(resource) => builder.fill(self.buffer(*resource), 0),
            Step::Copy(from, to) => {
                let (from, to) = (self.buffer(*from), self.buffer(*to));
                builder.copy(from, to, from.bytes().min(to.bytes()));
            }
            Step::Take(ring, to) => {
                let (ring, bytes) = match ring {
                    Resource::PaletteRing => (&self.palette, self.slices[0]),
                    _ => (&self.fields, self.slices[1]),
                };
                builder.copy_slice(ring, self.buffer(*to), bytes, [bytes, 0]);
            }
            Step::Keep(from, to) => {
                let (from, to) = (self.buffer(*from), self.buffer(*to));
                builder.copy_slice(from, to, from.bytes(), [0, from.bytes()]);
            }
            Step::Dispatch {
                pass,
                bind,
                variant,
                constants,
                extent,
            } => {
                let mut call = builder.pass(pass.declaration);
                for (binding, &resource) in pass.declaration.bindings.iter().zip(bind) {
                    call = match resource {
                        Resource::Atlas => call.bind_image(binding.name, &self.atlas),
                        Resource::Operators => call.bind_image(binding.name, &self.operators),
                        _ => call.bind(binding.name, self.buffer(resource)),
                    };
                }
                let call = call.constant_bytes(constants).variant(*variant);
                _ = match *extent {
                    Extent::Items(count) => call.items(count),
                    Extent::Groups(groups) => call.groups(groups),
                    Extent::Indirect(row) => {
                        let offset = u64::from(row) * size_of::<Dispatch>() as u64;
                        call.indirect(self.buffer(Resource::Dispatches), offset)
                    }
                };
            }
        }
    }

    pub(super) fn pose(&self, slot: Slot, upload: &PoseUpload) -> Result<()> {
        self.palette.write(slot, upload.palette())?;
        self.fields.write(slot, upload.fields())
    }

    /// The buffer of a resource that the plan uses; plans and buffers come from the same steps.
    pub(super) fn buffer(&self, resource: Resource) -> &Buffer {
        match &self.buffers[resource as usize] {
            Some(buffer) => buffer,
            None => unreachable!("{} is used by no step", resource.label()),
        }
    }

    pub(super) fn read<T: Pod>(&self, gpu: &Gpu, resource: Resource) -> Result<Vec<T>> {
        let bytes = gpu.download(self.buffer(resource))?;
        let whole = bytes.len() / size_of::<T>() * size_of::<T>();
        Ok(bytemuck::pod_collect_to_vec(&bytes[..whole]))
    }

    pub(super) fn write<T: Pod>(&self, gpu: &Gpu, resource: Resource, content: &[T]) -> Result<()> {
        if content.is_empty() {
            Ok(())
        } else {
            gpu.upload(self.buffer(resource), cast_slice(content))
        }
    }

    /// The plan binds this buffer.
    #[cfg(test)]
    pub(super) fn has(&self, resource: Resource) -> bool {
        self.buffers[resource as usize].is_some()
    }

    /// Extent and texels of the fields' atlas.
    pub(super) fn atlas(&self, gpu: &Gpu) -> Result<([u32; 3], Vec<u8>)> {
        Ok((self.atlas.extent(), gpu.download_image(&self.atlas)?))
    }

    /// Atlas and operators for a comparison with the twins.
    #[cfg(test)]
    pub(super) fn images(&self, gpu: &Gpu) -> Result<(Image, Image)> {
        let image = |i: &Image3d| -> Result<Image> {
            let texels = bytemuck::pod_collect_to_vec(&gpu.download_image(i)?);
            Ok(Image {
                extent: i.extent(),
                texels,
            })
        };
        Ok((image(&self.atlas)?, image(&self.operators)?))
    }
}

/// Buffers that a step binds, and those that the façade reads and writes beside.
fn is_used(resource: Resource, steps: &[Step]) -> bool {
    steps.iter().any(|step| match step {
        Step::Clear(r) => *r == resource,
        Step::Copy(a, b) | Step::Take(a, b) | Step::Keep(a, b) => *a == resource || *b == resource,
        Step::Dispatch { bind, .. } => bind.contains(&resource),
    })
}

fn create(gpu: &Gpu, statics: &Statics, resource: Resource) -> Result<Buffer> {
    let words = statics.words[&(resource as u32)];
    let buffer = gpu.buffer(resource.label(), resource.class(), words as u64 * 4)?;
    let mut content = statics
        .content
        .get(&(resource as u32))
        .cloned()
        .unwrap_or_default();
    content.resize(words, 0);
    gpu.upload(&buffer, cast_slice(&content))?;
    Ok(buffer)
}

/// An image with nothing in it, for bindings that a plan does not use.
pub(super) fn no_image() -> Image {
    Image {
        extent: [1; 3],
        texels: vec![[half::f16::ZERO; 4]],
    }
}
