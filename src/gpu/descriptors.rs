//! Descriptor sets of a frame, allocated and written once.

use std::{collections::HashMap, sync::Arc};

use ash::vk;

use super::{
    declare::Access,
    fault::Subject,
    pipeline::Pipeline,
    shared::{Grave, Shared},
};
use crate::Result;

/// What a binding points to.
#[derive(Clone, Copy)]
pub(crate) enum Target {
    /// A whole buffer, in words or as texels, as its binding wants it.
    Buffer(vk::Buffer),
    /// The first bytes of a buffer, to be written.
    Bytes(vk::Buffer, u64),
    /// A 3D image in the general layout.
    Image(vk::ImageView),
}

/// A pool with room for exactly the sets of one frame; given back once the device is done with it.
pub(crate) struct Descriptors {
    shared: Arc<Shared>,
    pool: vk::DescriptorPool,
    /// Views of the buffers that are read as texels or words, each once.
    views: HashMap<(vk::Buffer, vk::Format), vk::BufferView>,
}

impl Descriptors {
    /// A pool for `copies` sets of each pipeline; `None` where no pipeline has a binding.
    pub(crate) fn new(
        shared: &Arc<Shared>,
        subject: &str,
        pipelines: &[Arc<Pipeline>],
        copies: u32,
    ) -> Result<Option<Self>> {
        let accesses = || {
            pipelines
                .iter()
                .flat_map(|p| p.declaration.bindings)
                .map(|b| b.access)
        };
        let size = |access: Access| {
            let ty = access.descriptor();
            let count = accesses().filter(|a| a.descriptor() == ty).count() as u32 * copies;
            vk::DescriptorPoolSize {
                ty,
                descriptor_count: count,
            }
        };
        let kinds = [
            Access::Read,
            Access::Uniform,
            Access::Texels,
            Access::Sampled,
            Access::ImageWrite,
        ];
        let sizes: Vec<_> = kinds
            .map(size)
            .into_iter()
            .filter(|s| s.descriptor_count > 0)
            .collect();
        if sizes.is_empty() {
            return Ok(None);
        }
        let info = vk::DescriptorPoolCreateInfo::default()
            .max_sets(pipelines.len() as u32 * copies)
            .pool_sizes(&sizes);
        // SAFETY: the device is alive.
        let pool = unsafe { shared.device.create_descriptor_pool(&info, None) };
        let pool = pool.subject("vkCreateDescriptorPool", subject)?;
        let shared = shared.clone();
        Ok(Some(Self {
            shared,
            pool,
            views: HashMap::new(),
        }))
    }

    /// A set with one target a binding of the pipeline. The caller keeps the targets alive while it uses the set.
    pub(crate) fn set(
        &mut self,
        pipeline: &Pipeline,
        targets: &[Target],
    ) -> Result<vk::DescriptorSet> {
        let device = &self.shared.device;
        let layouts = [pipeline.set_layout];
        let info = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(self.pool)
            .set_layouts(&layouts);
        let name = pipeline.declaration.name;
        // SAFETY: pool and layout are alive; `&self` of a pool is used by one thread at a time since frames are not shared.
        let sets = unsafe { device.allocate_descriptor_sets(&info) }
            .subject("vkAllocateDescriptorSets", name)?;
        for (row, (binding, target)) in pipeline
            .declaration
            .bindings
            .iter()
            .zip(targets)
            .enumerate()
        {
            match (binding.access, *target) {
                (access @ (Access::Texels | Access::Words), Target::Buffer(buffer)) => {
                    let view = self.view(buffer, access, binding.name)?;
                    self.write_texels(sets[0], row as u32, view);
                }
                (access, target) => self.write(sets[0], row as u32, access, target),
            }
        }
        Ok(sets[0])
    }

    /// The view of a whole buffer as texels or words.
    fn view(&mut self, buffer: vk::Buffer, access: Access, name: &str) -> Result<vk::BufferView> {
        let format = match access {
            Access::Words => vk::Format::R32_UINT,
            _ => vk::Format::R32G32B32A32_SFLOAT,
        };
        if let Some(view) = self.views.get(&(buffer, format)) {
            return Ok(*view);
        }
        let info = vk::BufferViewCreateInfo::default()
            .buffer(buffer)
            .format(format)
            .range(vk::WHOLE_SIZE);
        // SAFETY: the caller keeps the buffer alive; every buffer may be read as texels, and every device has both formats.
        let view = unsafe { self.shared.device.create_buffer_view(&info, None) }
            .subject("vkCreateBufferView", name)?;
        self.views.insert((buffer, format), view);
        Ok(view)
    }

    fn write_texels(&self, set: vk::DescriptorSet, row: u32, view: vk::BufferView) {
        let views = [view];
        let write = vk::WriteDescriptorSet::default()
            .dst_set(set)
            .dst_binding(row)
            .descriptor_type(Access::Texels.descriptor())
            .texel_buffer_view(&views);
        // SAFETY: set and view are alive, the type is that of the layout, the set is not in use yet.
        unsafe { self.shared.device.update_descriptor_sets(&[write], &[]) };
    }

    fn write_buffer(&self, write: vk::WriteDescriptorSet<'_>, buffer: vk::Buffer, range: u64) {
        let info = [vk::DescriptorBufferInfo {
            buffer,
            offset: 0,
            range,
        }];
        // SAFETY: set and target are alive, the type is that of the layout, the set is not in use yet.
        unsafe {
            self.shared
                .device
                .update_descriptor_sets(&[write.buffer_info(&info)], &[])
        };
    }

    fn write(&self, set: vk::DescriptorSet, row: u32, access: Access, target: Target) {
        let write = vk::WriteDescriptorSet::default()
            .dst_set(set)
            .dst_binding(row)
            .descriptor_type(access.descriptor());
        match target {
            Target::Buffer(buffer) => self.write_buffer(write, buffer, vk::WHOLE_SIZE),
            Target::Bytes(buffer, bytes) => self.write_buffer(write, buffer, bytes),
            Target::Image(image_view) => {
                let info = [vk::DescriptorImageInfo {
                    sampler: self.shared.sampler,
                    image_view,
                    image_layout: vk::ImageLayout::GENERAL,
                }];
                // SAFETY: set and target are alive, the type is that of the layout, the set is not in use yet.
                unsafe {
                    self.shared
                        .device
                        .update_descriptor_sets(&[write.image_info(&info)], &[])
                };
            }
        }
    }
}

impl Drop for Descriptors {
    fn drop(&mut self) {
        let (pool, views) = (self.pool, std::mem::take(&mut self.views));
        // SAFETY: the graveyard calls this when all submissions are done; the pool's sets go with it, and only they use the
        // views.
        let destroy = move |d: &ash::Device| unsafe {
            d.destroy_descriptor_pool(pool, None);
            for view in views.into_values() {
                d.destroy_buffer_view(view, None);
            }
        };
        self.shared.bury(Grave::Other(Box::new(destroy)));
    }
}
