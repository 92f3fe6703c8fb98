//! The buffers and images of a deformer on a GPU, with a part for every instance where instances have their own.

use bytemuck::{Pod, cast_slice};

use super::{Kind, Resource, Step, heads, plan::Extent, pose::PoseUpload, statics::Statics};
#[cfg(test)]
use crate::twin::Image;
use crate::{
    Error, Result,
    frame::{FrameBuilder, Slot},
    gpu::{Access, Buffer, Gpu, Image3d, Ring},
    layout::JointPose,
};

/// What a plan's steps bind on a GPU.
pub(super) struct GpuResources {
    /// A row a [`Resource`]; none where the method needs no such buffer.
    buffers: Vec<Option<Buffer>>,
    palette: Ring,
    fields: Ring,
    /// Bytes of a slice of these, with a part an instance.
    slices: [u64; 2],
    /// Bytes of an instance's part, a row a [`Resource`].
    parts: Vec<u64>,
    pub(super) instances: u32,
    atlas: Image3d,
    operators: Image3d,
}

impl GpuResources {
    pub(super) fn new(
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
                .then(|| create(gpu, statics, resource, is_texels(resource, steps)))
                .transpose()?;
            buffers.push(buffer);
        }
        let joints = statics.sizes.joints as usize * size_of::<JointPose>();
        let instances = statics.sizes.instances;
        let bytes = [joints, statics.fields_bytes()].map(|b| b as u64 * u64::from(instances));
        let part = |r: &Resource| statics.part(*r) as u64 * 4;
        let ring = |r: Resource, bytes: u64| gpu.ring(r.label(), r.class(), slices * bytes);
        Ok(Self {
            buffers,
            palette: ring(Resource::PaletteRing, bytes[0])?,
            fields: ring(Resource::FieldsRing, bytes[1])?,
            slices: bytes,
            parts: Resource::ALL.iter().map(part).collect(),
            instances,
            atlas,
            operators,
        })
    }

    /// For a frame that walks `steps` over these resources for the first instances.
    pub(super) fn builder(
        &self,
        gpu: &Gpu,
        name: &'static str,
        steps: &[Step],
        instances: u32,
    ) -> FrameBuilder {
        let mut builder = FrameBuilder::new(gpu, name);
        for step in steps {
            self.add(&mut builder, step, instances);
        }
        builder
    }

    fn add(&self, builder: &mut FrameBuilder, step: &Step, instances: u32) {
        match step {
            Step::Clear(resource) => builder.fill(self.buffer(*resource), 0),
            Step::Empty(row) => {
                let heads = self.buffer(Resource::Dispatches);
                builder.fill_range(heads, self.head(*row), 4, 0);
            }
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
                slice_at,
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
                let mut call = call.constant_bytes(constants).variant(*variant);
                if let Some(byte) = *slice_at {
                    call = call.index_at(byte);
                }
                _ = match *extent {
                    Extent::Items(count) => call.items(count).instances(instances),
                    Extent::Groups(groups) => call.groups(groups).instances(instances),
                    Extent::Indirect(row) => {
                        call.indirect(self.buffer(Resource::Dispatches), self.head(row))
                    }
                };
            }
        }
    }

    /// Where a list's head begins, in bytes.
    fn head(&self, row: u32) -> u64 {
        heads::words(row as usize, self.instances as usize) as u64 * 4
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

    /// Content of a buffer, the parts of all instances.
    pub(super) fn read<T: Pod>(&self, gpu: &Gpu, resource: Resource) -> Result<Vec<T>> {
        Ok(whole(&gpu.download(self.buffer(resource))?))
    }

    pub(super) fn read_part<T: Pod>(
        &self,
        gpu: &Gpu,
        resource: Resource,
        instance: usize,
    ) -> Result<Vec<T>> {
        let bytes = self.parts[resource as usize];
        let first = instance as u64 * bytes;
        Ok(whole(&gpu.download_part(
            self.buffer(resource),
            first,
            bytes,
        )?))
    }

    pub(super) fn write_part<T: Pod>(
        &self,
        gpu: &Gpu,
        resource: Resource,
        instance: usize,
        content: &[T],
    ) -> Result<()> {
        if content.is_empty() {
            return Ok(());
        }
        let first = instance as u64 * self.parts[resource as usize];
        gpu.upload_at(self.buffer(resource), first, cast_slice(content))
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
        Step::Empty(_) => resource == Resource::Dispatches,
        Step::Copy(a, b) | Step::Take(a, b) | Step::Keep(a, b) => *a == resource || *b == resource,
        Step::Dispatch { bind, .. } => bind.contains(&resource),
    })
}

/// Bytes of a texel where a step reads the buffer as texels.
fn is_texels(resource: Resource, steps: &[Step]) -> Option<u64> {
    let access = |step: &Step| {
        let Step::Dispatch { pass, bind, .. } = step else {
            return None;
        };
        let bound = pass.declaration.bindings.iter().zip(bind);
        let texels = bound
            .filter(|(_, r)| **r == resource)
            .map(|(b, _)| match b.access {
                Access::Texels => Some(16),
                Access::Words => Some(4),
                _ => None,
            });
        texels.flatten().min()
    };
    steps.iter().filter_map(access).min()
}

/// Whole elements of bytes.
fn whole<T: Pod>(bytes: &[u8]) -> Vec<T> {
    let length = bytes.len() / size_of::<T>() * size_of::<T>();
    bytemuck::pod_collect_to_vec(&bytes[..length])
}

/// Refuses what a shader could not read as a texel buffer, before there is memory for it.
fn check_texels(gpu: &Gpu, statics: &Statics, resource: Resource, texel: u64) -> Result<()> {
    let bytes = statics.words[&(resource as u32)] as u64 * 4;
    let most = u64::from(gpu.limits().max_texel_buffer_elements) * texel;
    if bytes <= most {
        return Ok(());
    }
    let of = match statics.sizes.instances {
        1 => String::new(),
        n => format!(", {} for each of {n} instances", statics.part(resource) * 4),
    };
    Err(Error::Memory {
        name: resource.label().into(),
        class: resource.class().name(),
        bytes,
        reason: format!("a texel buffer has {most} at most on this device{of}"),
    })
}

fn create(gpu: &Gpu, statics: &Statics, resource: Resource, texel: Option<u64>) -> Result<Buffer> {
    if let Some(texel) = texel {
        check_texels(gpu, statics, resource, texel)?;
    }
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
