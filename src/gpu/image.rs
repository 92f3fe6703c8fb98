//! Images: 3D ones for fields and operators, and whatever else a caller describes.

use std::sync::{Arc, Mutex};

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::{
    commands::immediate,
    fault::{Subject, lock},
    memory::{Block, Class, Request},
    shared::{Grave, Shared},
};
use crate::Result;

/// Format of a 3D image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Four half floats.
    Rgba16F,
    /// Four floats.
    Rgba32F,
}

impl Format {
    /// Bytes of a texel.
    pub fn bytes(self) -> u64 {
        match self {
            Self::Rgba16F => 8,
            Self::Rgba32F => 16,
        }
    }

    fn raw(self) -> vk::Format {
        match self {
            Self::Rgba16F => vk::Format::R16G16B16A16_SFLOAT,
            Self::Rgba32F => vk::Format::R32G32B32A32_SFLOAT,
        }
    }
}

/// An image with a view of all of it and its memory; given back once the device is done with it.
pub(crate) struct Image {
    shared: Arc<Shared>,
    pub(crate) raw: vk::Image,
    pub(crate) view: vk::ImageView,
    block: Mutex<Option<Block>>,
}

impl Image {
    /// Makes what `info` describes, with a view of all its levels and layers.
    pub(crate) fn new(
        shared: &Arc<Shared>,
        request: Request<'_>,
        info: &vk::ImageCreateInfo<'_>,
        aspect: vk::ImageAspectFlags,
    ) -> Result<Self> {
        shared.collect();
        let device = &shared.device;
        // SAFETY: the device is alive; the callers' descriptions are within its limits.
        let raw =
            unsafe { device.create_image(info, None) }.subject("vkCreateImage", request.name)?;
        // SAFETY: on each failure, whatever was made before it is destroyed, and nobody else has it.
        let destroy = || unsafe { device.destroy_image(raw, None) };
        let block = back(shared, raw, &request).inspect_err(|_| destroy())?;
        let view = match view(device, request.name, raw, info, aspect) {
            Ok(view) => view,
            Err(error) => {
                destroy();
                shared.memory.free(block);
                return Err(error);
            }
        };
        shared.name(raw, request.name);
        shared.name(view, request.name);
        Ok(Self {
            shared: shared.clone(),
            raw,
            view,
            block: Mutex::new(Some(block)),
        })
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        if let Some(block) = lock(&self.block).take() {
            self.shared.bury(Grave::Image(self.raw, self.view, block));
        }
    }
}

fn back(shared: &Shared, raw: vk::Image, request: &Request<'_>) -> Result<Block> {
    // SAFETY: the image was just made.
    let requirements = unsafe { shared.device.get_image_memory_requirements(raw) };
    let block = shared.memory.allocate(request, requirements, false)?;
    // SAFETY: the image has no memory yet; the block was allocated for its requirements and outlives it.
    let bound = unsafe {
        let (memory, offset) = (block.allocation.memory(), block.allocation.offset());
        shared.device.bind_image_memory(raw, memory, offset)
    };
    match bound.subject("vkBindImageMemory", request.name) {
        Ok(()) => Ok(block),
        Err(error) => {
            shared.memory.free(block);
            Err(error)
        }
    }
}

fn view(
    device: &ash::Device,
    name: &str,
    image: vk::Image,
    info: &vk::ImageCreateInfo<'_>,
    aspect: vk::ImageAspectFlags,
) -> Result<vk::ImageView> {
    let kind = match info.image_type {
        vk::ImageType::TYPE_3D => vk::ImageViewType::TYPE_3D,
        _ => vk::ImageViewType::TYPE_2D,
    };
    let info = vk::ImageViewCreateInfo::default()
        .image(image)
        .view_type(kind)
        .format(info.format)
        .subresource_range(all(aspect));
    // SAFETY: image and device are alive, the image has its memory.
    unsafe { device.create_image_view(&info, None) }.subject("vkCreateImageView", name)
}

/// All levels and layers.
pub(crate) fn all(aspect: vk::ImageAspectFlags) -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange::default()
        .aspect_mask(aspect)
        .level_count(vk::REMAINING_MIP_LEVELS)
        .layer_count(vk::REMAINING_ARRAY_LAYERS)
}

/// A 3D image, always in the general layout; clones share it.
#[derive(Clone)]
pub struct Image3d(Arc<Inner>);

struct Inner {
    image: Image,
    name: String,
    class: Class,
    extent: [u32; 3],
    format: Format,
}

impl Image3d {
    pub(crate) fn new(
        shared: &Arc<Shared>,
        name: &str,
        class: Class,
        extent: [u32; 3],
        format: Format,
    ) -> Result<Self> {
        let location = MemoryLocation::GpuOnly;
        let request = Request {
            name,
            class,
            location,
        };
        admit(shared, &request, extent, format)?;
        let [width, height, depth] = extent;
        use vk::ImageUsageFlags as Usage;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_3D)
            .format(format.raw())
            .extent(vk::Extent3D {
                width,
                height,
                depth,
            })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(Usage::SAMPLED | Usage::STORAGE | Usage::TRANSFER_SRC | Usage::TRANSFER_DST);
        let image = Image::new(shared, request, &info, vk::ImageAspectFlags::COLOR)?;
        immediate(shared, name, |r| {
            let (old, new) = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
            r.transition(image.raw, old, new);
            Ok(())
        })?;
        Ok(Self(Arc::new(Inner {
            image,
            name: name.to_owned(),
            class,
            extent,
            format,
        })))
    }

    /// Name of the allocation.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Texels along x, y and z.
    pub fn extent(&self) -> [u32; 3] {
        self.0.extent
    }

    /// Format of a texel.
    pub fn format(&self) -> Format {
        self.0.format
    }

    /// Bytes of all texels, x fastest, without padding.
    pub fn bytes(&self) -> u64 {
        texel_bytes(self.0.extent, self.0.format).unwrap_or(u64::MAX)
    }

    pub(crate) fn raw(&self) -> vk::Image {
        self.0.image.raw
    }

    pub(crate) fn view(&self) -> vk::ImageView {
        self.0.image.view
    }

    pub(crate) fn is_of(&self, shared: &Arc<Shared>) -> bool {
        Arc::ptr_eq(&self.0.image.shared, shared)
    }

    pub(crate) fn refuse(&self, bytes: u64, reason: impl Into<String>) -> crate::Error {
        let location = MemoryLocation::GpuOnly;
        let (name, class) = (&*self.0.name, self.0.class);
        Request {
            name,
            class,
            location,
        }
        .refuse(bytes, reason)
    }
}

fn texel_bytes(extent: [u32; 3], format: Format) -> Option<u64> {
    extent
        .iter()
        .try_fold(format.bytes(), |b, e| b.checked_mul(u64::from(*e)))
}

/// Refuses an extent or format that the device does not have, and what would pass the budget.
fn admit(shared: &Shared, request: &Request<'_>, extent: [u32; 3], format: Format) -> Result<()> {
    let most = shared.physical.properties.limits.max_image_dimension3_d;
    let bytes = texel_bytes(extent, format).unwrap_or(u64::MAX);
    if extent.iter().any(|&e| e == 0 || e > most) {
        let reason =
            format!("extent {extent:?}: a 3D image has 1 to {most} texels a side on this device");
        return Err(request.refuse(bytes, reason));
    }
    shared.memory.admit(request, bytes)?;
    use vk::FormatFeatureFlags as Feature;
    let wanted = Feature::SAMPLED_IMAGE_FILTER_LINEAR | Feature::STORAGE_IMAGE;
    // SAFETY: the physical device is of this instance, which is alive.
    let found = unsafe {
        let instance = &shared.instance.raw;
        instance.get_physical_device_format_properties(shared.physical.raw, format.raw())
    };
    if !found.optimal_tiling_features.contains(wanted) {
        return Err(request.refuse(
            bytes,
            format!("this device cannot filter and store {format:?}"),
        ));
    }
    Ok(())
}
