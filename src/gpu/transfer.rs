//! Blocking uploads and downloads through staging buffers of limited size.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::{
    buffer::Buffer,
    commands::immediate,
    image::Image3d,
    memory::{Class, Request},
    shared::Shared,
};
use crate::Result;

/// Most bytes that a staging buffer has, unless one slice of an image needs more.
pub(crate) const CHUNK: u64 = 4 << 20;

/// Layout of 3D images outside of transfers.
const GENERAL: vk::ImageLayout = vk::ImageLayout::GENERAL;

fn staging(shared: &Arc<Shared>, location: MemoryLocation, bytes: u64) -> Result<Buffer> {
    let request = Request {
        name: "gpu.staging",
        class: Class::Transient,
        location,
    };
    Buffer::new(shared, request, bytes)
}

pub(crate) fn upload(
    shared: &Arc<Shared>,
    (to, first): (&Buffer, u64),
    bytes: &[u8],
) -> Result<()> {
    to.check(first, bytes.len() as u64)?;
    if bytes.is_empty() {
        return Ok(());
    }
    if to.is_mapped() {
        return to.write(first, bytes);
    }
    let staging = staging(
        shared,
        MemoryLocation::CpuToGpu,
        CHUNK.min(bytes.len() as u64),
    )?;
    for (chunk, part) in bytes.chunks(CHUNK as usize).enumerate() {
        staging.write(0, part)?;
        let offset = first + chunk as u64 * CHUNK;
        immediate(shared, to.name(), |r| {
            r.copy((staging.raw(), 0), (to.raw(), offset), part.len() as u64);
            Ok(())
        })?;
    }
    Ok(())
}

pub(crate) fn download(
    shared: &Arc<Shared>,
    (from, first): (&Buffer, u64),
    length: u64,
) -> Result<Vec<u8>> {
    from.check(first, length)?;
    let mut bytes = vec![0; length as usize];
    if from.is_mapped() {
        shared.wait_all(from.name())?;
        from.read(first, &mut bytes)?;
        return Ok(bytes);
    }
    let staging = staging(shared, MemoryLocation::GpuToCpu, CHUNK.min(length))?;
    for (chunk, part) in bytes.chunks_mut(CHUNK as usize).enumerate() {
        let offset = first + chunk as u64 * CHUNK;
        immediate(shared, from.name(), |r| {
            r.copy((from.raw(), offset), (staging.raw(), 0), part.len() as u64);
            Ok(())
        })?;
        staging.read(0, part)?;
    }
    Ok(bytes)
}

/// Slices of an image that go through staging together, and their bytes.
struct Slices {
    bytes: u64,
    depth: u32,
}

impl Slices {
    fn of(image: &Image3d) -> Self {
        let slice = image.bytes() / u64::from(image.extent()[2]);
        let depth = (CHUNK / slice).clamp(1, u64::from(image.extent()[2]));
        let bytes = slice * depth;
        Self {
            bytes,
            depth: depth as u32,
        }
    }

    fn region(&self, image: &Image3d, chunk: usize) -> vk::BufferImageCopy {
        let [width, height, depth] = image.extent();
        let z = chunk as u32 * self.depth;
        vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                mip_level: 0,
                base_array_layer: 0,
                layer_count: 1,
            })
            .image_offset(vk::Offset3D {
                x: 0,
                y: 0,
                z: z as i32,
            })
            .image_extent(vk::Extent3D {
                width,
                height,
                depth: self.depth.min(depth - z),
            })
    }
}

pub(crate) fn upload_image(shared: &Arc<Shared>, to: &Image3d, bytes: &[u8]) -> Result<()> {
    if bytes.len() as u64 != to.bytes() {
        let reason = format!("the image has {} bytes", to.bytes());
        return Err(to.refuse(bytes.len() as u64, reason));
    }
    let slices = Slices::of(to);
    let staging = staging(shared, MemoryLocation::CpuToGpu, slices.bytes)?;
    for (chunk, part) in bytes.chunks(slices.bytes as usize).enumerate() {
        staging.write(0, part)?;
        immediate(shared, to.name(), |r| {
            let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
            r.transition(to.raw(), GENERAL, layout);
            r.copy_to_image(&staging, to.raw(), slices.region(to, chunk));
            r.transition(to.raw(), layout, GENERAL);
            Ok(())
        })?;
    }
    Ok(())
}

pub(crate) fn download_image(shared: &Arc<Shared>, from: &Image3d) -> Result<Vec<u8>> {
    let slices = Slices::of(from);
    let mut bytes = vec![0; from.bytes() as usize];
    let staging = staging(shared, MemoryLocation::GpuToCpu, slices.bytes)?;
    for (chunk, part) in bytes.chunks_mut(slices.bytes as usize).enumerate() {
        immediate(shared, from.name(), |r| {
            let region = slices.region(from, chunk);
            let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
            r.transition(from.raw(), GENERAL, layout);
            r.copy_from_image(from.raw(), layout, &staging, region);
            r.transition(from.raw(), layout, GENERAL);
            Ok(())
        })?;
        staging.read(0, part)?;
    }
    Ok(bytes)
}

impl Shared {
    /// Waits for everything submitted so far.
    pub(crate) fn wait_all(&self, subject: &str) -> Result<()> {
        let number = self.queue.submitted();
        self.queue.wait(&self.device, number, subject)?;
        self.collect();
        Ok(())
    }
}
