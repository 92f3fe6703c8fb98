//! Recording of command buffers: the Vulkan commands of dermis as safe functions.

use std::ffi::CStr;

use ash::vk;

use super::{
    buffer::Buffer, fault::Subject, image, pipeline::Bound, shared::Shared, timestamps::Timestamps,
};
use crate::Result;

/// One side of a barrier.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Scope {
    pub(crate) stages: vk::PipelineStageFlags,
    pub(crate) access: vk::AccessFlags,
}

impl Scope {
    /// Every command.
    pub(crate) const ALL: Self = Self {
        stages: vk::PipelineStageFlags::ALL_COMMANDS,
        access: vk::AccessFlags::from_raw(
            vk::AccessFlags::MEMORY_READ.as_raw() | vk::AccessFlags::MEMORY_WRITE.as_raw(),
        ),
    };
    /// Reads of mapped memory by the CPU.
    pub(crate) const HOST: Self = Self {
        stages: vk::PipelineStageFlags::HOST,
        access: vk::AccessFlags::HOST_READ,
    };

    fn stages2(self) -> vk::PipelineStageFlags2 {
        // The flags of synchronization2 begin with those of Vulkan 1.0, bit by bit.
        vk::PipelineStageFlags2::from_raw(u64::from(self.stages.as_raw()))
    }

    fn access2(self) -> vk::AccessFlags2 {
        vk::AccessFlags2::from_raw(u64::from(self.access.as_raw()))
    }
}

/// What comes next with a buffer of the host's that dermis has written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Handover {
    /// Stages that read it.
    pub stages: vk::PipelineStageFlags,
    /// Accesses of these.
    pub access: vk::AccessFlags,
    /// Queue family that it is released to; none where the same family goes on. The host acquires it there, and has released it
    /// from there and acquired it for dermis' family before the next frame: what the frame does not write is lost otherwise.
    pub family: Option<u32>,
}

/// A command buffer that is being recorded.
pub(crate) struct Recorder<'a> {
    pub(crate) shared: &'a Shared,
    /// For commands that this type does not offer.
    pub(crate) raw: vk::CommandBuffer,
}

impl Recorder<'_> {
    /// A memory barrier over all resources.
    pub(crate) fn barrier(&self, from: Scope, to: Scope) {
        match &self.shared.sync2 {
            Some(sync2) => {
                let barrier = [vk::MemoryBarrier2::default()
                    .src_stage_mask(from.stages2())
                    .src_access_mask(from.access2())
                    .dst_stage_mask(to.stages2())
                    .dst_access_mask(to.access2())];
                let info = vk::DependencyInfo::default().memory_barriers(&barrier);
                // SAFETY: the command buffer is being recorded; the extension is on.
                unsafe { sync2.cmd_pipeline_barrier2(self.raw, &info) }
            }
            None => {
                let barrier = [vk::MemoryBarrier::default()
                    .src_access_mask(from.access)
                    .dst_access_mask(to.access)];
                // SAFETY: the command buffer is being recorded; the stages are not empty.
                unsafe { self.pipeline_barrier(from, to, &barrier, &[]) }
            }
        }
    }

    /// Makes what compute shaders wrote into a buffer visible to what comes next, or releases it to another family.
    pub(crate) fn hand_over(&self, buffer: &Buffer, to: &Handover) {
        let from = Scope {
            stages: vk::PipelineStageFlags::COMPUTE_SHADER,
            access: vk::AccessFlags::SHADER_WRITE,
        };
        let own = self.shared.physical.family;
        let Some(family) = to.family.filter(|f| *f != own) else {
            let (stages, access) = (to.stages, to.access);
            return self.barrier(from, Scope { stages, access });
        };
        let barrier = [vk::BufferMemoryBarrier::default()
            .buffer(buffer.raw())
            .size(buffer.bytes())
            .src_access_mask(from.access)
            .src_queue_family_index(own)
            .dst_queue_family_index(family)];
        // SAFETY: recording; the buffer's owner keeps it alive until the commands are done.
        unsafe {
            self.shared.device.cmd_pipeline_barrier(
                self.raw,
                from.stages,
                vk::PipelineStageFlags::BOTTOM_OF_PIPE,
                vk::DependencyFlags::empty(),
                &[],
                &barrier,
                &[],
            );
        }
    }

    /// Changes the layout of all of a colour image, between all commands before and all after.
    pub(crate) fn transition(&self, image: vk::Image, old: vk::ImageLayout, new: vk::ImageLayout) {
        let all = Scope::ALL;
        let barrier = [vk::ImageMemoryBarrier::default()
            .image(image)
            .old_layout(old)
            .new_layout(new)
            .src_access_mask(all.access)
            .dst_access_mask(all.access)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .subresource_range(image::all(vk::ImageAspectFlags::COLOR))];
        // SAFETY: the command buffer is being recorded; the caller's image is alive until it is done.
        unsafe { self.pipeline_barrier(all, all, &[], &barrier) }
    }

    /// The barrier of Vulkan 1.0.
    ///
    /// # Safety
    /// The command buffer is being recorded and the images in `images` are alive until it is done.
    unsafe fn pipeline_barrier(
        &self,
        from: Scope,
        to: Scope,
        memory: &[vk::MemoryBarrier<'_>],
        images: &[vk::ImageMemoryBarrier<'_>],
    ) {
        let flags = vk::DependencyFlags::empty();
        // SAFETY: promised by the caller.
        unsafe {
            let device = &self.shared.device;
            device.cmd_pipeline_barrier(
                self.raw,
                from.stages,
                to.stages,
                flags,
                memory,
                &[],
                images,
            );
        }
    }

    /// Sets every 32-bit word of a range, in whole words, that the caller has checked.
    pub(crate) fn fill(&self, (buffer, offset): (vk::Buffer, u64), bytes: u64, value: u32) {
        if bytes > 0 {
            // SAFETY: recording; the owner of the command buffer keeps the buffer alive; the range lies within it, in
            // multiples of 4.
            unsafe {
                self.shared
                    .device
                    .cmd_fill_buffer(self.raw, buffer, offset, bytes, value)
            };
        }
    }

    /// Copies a range that the caller has checked against both buffers.
    pub(crate) fn copy(&self, from: (vk::Buffer, u64), to: (vk::Buffer, u64), bytes: u64) {
        let region = vk::BufferCopy {
            src_offset: from.1,
            dst_offset: to.1,
            size: bytes,
        };
        // SAFETY: recording; the owner of the command buffer keeps the buffers alive, the range lies within both.
        unsafe {
            self.shared
                .device
                .cmd_copy_buffer(self.raw, from.0, to.0, &[region])
        };
    }

    /// Copies from a buffer's beginning into a box of a colour image in the layout for transfers to it.
    pub(crate) fn copy_to_image(&self, from: &Buffer, to: vk::Image, region: vk::BufferImageCopy) {
        let (device, layout) = (&self.shared.device, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        // SAFETY: recording; the owner of the command buffer keeps both alive, the callers compute the region from their sizes.
        unsafe { device.cmd_copy_buffer_to_image(self.raw, from.raw(), to, layout, &[region]) };
    }

    /// Copies a box of a colour image in the layout `layout` to a buffer's beginning.
    pub(crate) fn copy_from_image(
        &self,
        from: vk::Image,
        layout: vk::ImageLayout,
        to: &Buffer,
        region: vk::BufferImageCopy,
    ) {
        let device = &self.shared.device;
        // SAFETY: as in `copy_to_image`.
        unsafe { device.cmd_copy_image_to_buffer(self.raw, from, layout, to.raw(), &[region]) };
    }

    /// Binds a pipeline, its descriptor set and its push constants, whose length the frame has checked.
    pub(crate) fn bind(&self, bound: Bound, set: Option<vk::DescriptorSet>, constants: &[u8]) {
        let (device, point) = (&self.shared.device, vk::PipelineBindPoint::COMPUTE);
        // SAFETY: recording; pipelines live as long as the device, the set was made for the pipeline's layout and lives
        // as long as the frame, and the constants are as long as the layout's range.
        unsafe {
            device.cmd_bind_pipeline(self.raw, point, bound.pipeline);
            if let Some(set) = set {
                device.cmd_bind_descriptor_sets(self.raw, point, bound.layout, 0, &[set], &[]);
            }
            if !constants.is_empty() {
                let stages = vk::ShaderStageFlags::COMPUTE;
                device.cmd_push_constants(self.raw, bound.layout, stages, 0, constants);
            }
        }
    }

    /// Dispatches the bound pipeline.
    pub(crate) fn dispatch(&self, [x, y, z]: [u32; 3]) {
        // SAFETY: recording, a pipeline with its set is bound; the frame has checked the counts against the limits.
        unsafe { self.shared.device.cmd_dispatch(self.raw, x, y, z) };
    }

    /// Dispatches the bound pipeline with the three counts at `offset`.
    pub(crate) fn dispatch_indirect(&self, buffer: vk::Buffer, offset: u64) {
        // SAFETY: as in `dispatch`; the frame has checked that the offset is a multiple of 4 with 12 bytes after it.
        unsafe {
            self.shared
                .device
                .cmd_dispatch_indirect(self.raw, buffer, offset)
        };
    }

    /// Executes a secondary command buffer. Nothing is bound any more afterwards.
    pub(crate) fn execute(&self, secondary: vk::CommandBuffer) {
        // SAFETY: recording outside of a render pass; the owner of the command buffer keeps the secondary alive, which may be
        // executed again while it is pending, and is of the same queue family.
        unsafe {
            self.shared
                .device
                .cmd_execute_commands(self.raw, &[secondary])
        };
    }

    /// Opens a label for debuggers.
    pub(crate) fn begin_label(&self, label: &CStr) {
        if let Some(debug) = &self.shared.debug {
            let info = vk::DebugUtilsLabelEXT::default().label_name(label);
            // SAFETY: recording; the label lives until the call returns.
            unsafe { debug.cmd_begin_debug_utils_label(self.raw, &info) };
        }
    }

    /// Closes the label opened last.
    pub(crate) fn end_label(&self) {
        if let Some(debug) = &self.shared.debug {
            // SAFETY: recording; every caller has opened a label.
            unsafe { debug.cmd_end_debug_utils_label(self.raw) };
        }
    }

    /// Makes all timestamps ready to be written.
    pub(crate) fn reset(&self, timestamps: &Timestamps) {
        // SAFETY: recording; the pool lives as long as the frame, whose previous use of it is done.
        unsafe {
            let device = &self.shared.device;
            device.cmd_reset_query_pool(self.raw, timestamps.raw, 0, timestamps.capacity);
        }
    }

    /// Writes a timestamp once all commands so far are done.
    pub(crate) fn timestamp(&self, timestamps: &Timestamps, row: u32) {
        debug_assert!(row < timestamps.capacity);
        let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: recording; the row is inside the pool and was reset at the beginning of the command buffer.
        unsafe {
            self.shared
                .device
                .cmd_write_timestamp(self.raw, stage, timestamps.raw, row)
        };
    }

    /// Ends recording.
    pub(crate) fn end(self, subject: &str) -> Result<()> {
        // SAFETY: recording.
        unsafe { self.shared.device.end_command_buffer(self.raw) }
            .subject("vkEndCommandBuffer", subject)
    }
}
