//! Vulkan runtime: device, memory, buffers, images, pipelines, timestamps. Knows nothing of skin.
//!
//! [`Gpu`] owns one logical device with one queue. Whatever it makes is a cheap handle that keeps the device alive;
//! dropping the last clone of a handle gives its memory back as soon as the device is done with it.

mod adopt;
mod buffer;
mod commands;
mod declare;
mod descriptors;
#[cfg(test)]
mod double;
mod fault;
mod features;
mod image;
mod instance;
mod memory;
mod physical;
mod pipeline;
mod queue;
pub(crate) mod raster;
mod record;
mod shared;
mod spirv;
#[cfg(test)]
pub(crate) mod testing;
mod timestamps;
mod transfer;

use std::{sync::Arc, time::Instant};

use ash::vk;

pub use adopt::{Host, HostCommands, Requirements};
pub use buffer::{Buffer, FRAMES_IN_FLIGHT, Ring, Slot};
pub use declare::{Access, Binding, Declaration};
pub use features::Features;
pub use image::{Format, Image3d};
pub use memory::Class;
pub use physical::DeviceSelector;
pub use record::Handover;
pub use timestamps::Profile;

pub(crate) use commands::{Commands, Secondaries};
pub(crate) use descriptors::{Descriptors, Target};
#[allow(
    unused_imports,
    reason = "modules that talk to Vulkan themselves name their failures with it"
)]
pub(crate) use fault::Subject;
pub(crate) use image::Image;
pub(crate) use pipeline::{Bound, Pipeline};
pub(crate) use record::{Recorder, Scope};
pub(crate) use shared::{Grave, PUSH_CONSTANTS, Shared};
pub(crate) use timestamps::Timestamps;

use crate::{
    Result,
    report::{DeviceReport, MemoryReport, NamedMemory},
};

/// How to open a device.
#[derive(Clone, Debug, Default)]
pub struct GpuOptions {
    /// Which device.
    pub device: DeviceSelector,
    /// Watch every call with core and synchronization validation; needs the Khronos validation layer.
    pub validation: bool,
    /// Most bytes that may be in use at once, all classes together; `None` for what the device has.
    pub budget: Option<u64>,
    /// How frames are timed; [`Gpu::set_profile`] changes it.
    pub profile: Profile,
}

/// A Vulkan device ready for work; clones share it.
#[derive(Clone)]
pub struct Gpu {
    pub(crate) shared: Arc<Shared>,
}

impl Gpu {
    /// Opens a device.
    ///
    /// # Errors
    /// [`Error::NoDevice`](crate::Error::NoDevice) where there is no loader, driver or device that fits, with what to
    /// install; [`Error::Vulkan`](crate::Error::Vulkan) where the driver fails.
    pub fn new(options: &GpuOptions) -> Result<Self> {
        Self::with_features(options, Features::ALL)
    }

    /// Opens a device that uses no optional feature outside `features`, even where it has it: forces the fallbacks.
    ///
    /// # Errors
    /// As [`Gpu::new`].
    pub fn with_features(options: &GpuOptions, features: Features) -> Result<Self> {
        let shared = Arc::new(Shared::new(options, features)?);
        Ok(Self { shared })
    }

    /// All devices that dermis can use.
    ///
    /// # Errors
    /// [`Error::NoDevice`](crate::Error::NoDevice) without a loader.
    pub fn enumerate() -> Result<Vec<DeviceReport>> {
        let instance = instance::Instance::new(false)?;
        let devices = physical::enumerate(&instance)?;
        Ok(devices.into_iter().map(|d| d.report).collect())
    }

    /// The device.
    pub fn report(&self) -> DeviceReport {
        self.shared.physical.report.clone()
    }

    /// Changes how frames of this device are timed, each from its next submission on, unless
    /// [`Frame::set_profile`](crate::frame::Frame::set_profile) settled it for the frame.
    pub fn set_profile(&self, profile: Profile) {
        self.shared.profile.set(profile);
    }

    /// Fails where the device was lost: with the error of the call that found it, the same from then on. Nothing made with it
    /// works any more, but all can be dropped, and the device opened anew.
    ///
    /// # Errors
    /// [`Error::Vulkan`](crate::Error::Vulkan) with code `ERROR_DEVICE_LOST`.
    pub fn check(&self) -> Result<()> {
        self.shared.queue.check()
    }

    /// The optional features in use.
    pub fn features(&self) -> Features {
        self.shared.features
    }

    /// Bytes in use by class and name.
    pub fn memory(&self) -> MemoryReport {
        self.shared.collect();
        self.shared.memory.report()
    }

    /// Every buffer and image in use, a row each, in the order in which they were made.
    pub fn allocations(&self) -> Vec<NamedMemory> {
        self.shared.collect();
        self.shared.memory.rows()
    }

    /// Warnings and errors of the validation layers so far, the first few hundred; empty without validation.
    pub fn validation_messages(&self) -> Vec<String> {
        self.shared.instance.canary.messages()
    }

    /// The device's clock in nanoseconds, as frames report it, and the CPU's at the same moment; `None` where the device
    /// cannot tell.
    pub fn clock(&self) -> Option<(u64, Instant)> {
        self.shared.clock()
    }

    /// A buffer for storage, uniform, indirect, vertex, index and transfer use. [`Class::PoseRing`] and
    /// [`Class::Readback`] are mapped, the others lie on the device. Its content is undefined.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::Error::Memory) where `bytes` is 0, more than the device binds at once, or would pass the
    /// budget; [`Error::Vulkan`](crate::Error::Vulkan) where the driver fails.
    pub fn buffer(&self, name: &str, class: Class, bytes: u64) -> Result<Buffer> {
        let location = class.location();
        Buffer::new(
            &self.shared,
            memory::Request {
                name,
                class,
                location,
            },
            bytes,
        )
    }

    /// A buffer with `bytes` in it.
    ///
    /// # Errors
    /// As [`Gpu::buffer`] and [`Gpu::upload`].
    pub fn buffer_with(&self, name: &str, class: Class, bytes: &[u8]) -> Result<Buffer> {
        let buffer = self.buffer(name, class, bytes.len() as u64)?;
        self.upload(&buffer, bytes)?;
        Ok(buffer)
    }

    /// A 3D image to sample, store to and copy. Its content is undefined.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::Error::Memory) where the device lacks the extent or format or the budget would be passed;
    /// [`Error::Vulkan`](crate::Error::Vulkan) where the driver fails.
    pub fn image3d(
        &self,
        name: &str,
        class: Class,
        extent: [u32; 3],
        format: Format,
    ) -> Result<Image3d> {
        Image3d::new(&self.shared, name, class, extent, format)
    }

    /// One mapped buffer of `bytes` a frame in flight.
    ///
    /// # Errors
    /// As [`Gpu::buffer`].
    pub fn ring(&self, name: &str, class: Class, bytes: u64) -> Result<Ring> {
        Ring::new(&self.shared, name, class, bytes)
    }

    /// Writes a buffer from its beginning, after all work submitted so far; blocks.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::Error::Memory) where `bytes` is longer than the buffer or staging would pass the budget;
    /// [`Error::Vulkan`](crate::Error::Vulkan) where the driver fails.
    pub fn upload(&self, buffer: &Buffer, bytes: &[u8]) -> Result<()> {
        self.upload_at(buffer, 0, bytes)
    }

    /// Writes a part of a buffer from `offset` in bytes; see [`Gpu::upload`].
    pub(crate) fn upload_at(&self, buffer: &Buffer, offset: u64, bytes: &[u8]) -> Result<()> {
        transfer::upload(&self.shared, (buffer, offset), bytes)
    }

    /// Reads a whole buffer after all work submitted so far; blocks.
    ///
    /// # Errors
    /// As [`Gpu::upload`].
    pub fn download(&self, buffer: &Buffer) -> Result<Vec<u8>> {
        self.download_part(buffer, 0, buffer.bytes())
    }

    /// Reads `bytes` of a buffer from `offset` on; see [`Gpu::download`].
    pub(crate) fn download_part(
        &self,
        buffer: &Buffer,
        offset: u64,
        bytes: u64,
    ) -> Result<Vec<u8>> {
        transfer::download(&self.shared, (buffer, offset), bytes)
    }

    /// Writes all texels of an image, x fastest, after all work submitted so far; blocks.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::Error::Memory) where `bytes` is not exactly the image's size or staging would pass the
    /// budget; [`Error::Vulkan`](crate::Error::Vulkan) where the driver fails.
    pub fn upload_image(&self, image: &Image3d, bytes: &[u8]) -> Result<()> {
        transfer::upload_image(&self.shared, image, bytes)
    }

    /// Reads all texels of an image, x fastest, after all work submitted so far; blocks.
    ///
    /// # Errors
    /// As [`Gpu::upload_image`].
    pub fn download_image(&self, image: &Image3d) -> Result<Vec<u8>> {
        transfer::download_image(&self.shared, image)
    }

    /// Waits for everything submitted so far.
    ///
    /// # Errors
    /// [`Error::Vulkan`](crate::Error::Vulkan) where the device was lost.
    pub fn wait(&self) -> Result<()> {
        self.shared.wait_all("device")
    }
}

/// For modules that talk to Vulkan themselves, such as `render`.
impl Gpu {
    /// The Vulkan device, alive while this handle is.
    pub(crate) fn device(&self) -> &ash::Device {
        &self.shared.device
    }

    /// What the physical device can do.
    /// Greatest edge of a 3D image in texels.
    pub fn max_image_edge(&self) -> u32 {
        self.limits().max_image_dimension3_d
    }

    pub(crate) fn limits(&self) -> &vk::PhysicalDeviceLimits {
        &self.shared.physical.properties.limits
    }

    /// The queue does graphics as well as compute.
    pub(crate) fn has_graphics(&self) -> bool {
        let flags = self.shared.physical.family_properties.queue_flags;
        flags.contains(vk::QueueFlags::GRAPHICS)
    }

    /// Records, submits and waits; comes after all that was submitted before, and the CPU sees the results.
    pub(crate) fn immediate(
        &self,
        subject: &str,
        record: impl FnOnce(&Recorder<'_>) -> Result<()>,
    ) -> Result<()> {
        commands::immediate(&self.shared, subject, record)
    }

    /// A 2D image of one level and layer in device memory, in the undefined layout; counted as transient.
    pub(crate) fn target(
        &self,
        name: &str,
        [width, height]: [u32; 2],
        format: vk::Format,
        usage: vk::ImageUsageFlags,
        aspect: vk::ImageAspectFlags,
        samples: vk::SampleCountFlags,
    ) -> Result<Image> {
        let request = memory::Request {
            name,
            class: Class::Transient,
            location: gpu_allocator::MemoryLocation::GpuOnly,
        };
        let most = self.limits().max_image_dimension2_d;
        if [width, height].iter().any(|&e| e == 0 || e > most) {
            let reason = format!(
                "{width} x {height}: an image has 1 to {most} texels a side on this device"
            );
            return Err(request.refuse(0, reason));
        }
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D {
                width,
                height,
                depth: 1,
            })
            .mip_levels(1)
            .array_layers(1)
            .samples(samples)
            .usage(usage);
        Image::new(&self.shared, request, &info, aspect)
    }

    /// Destroys a handle made with [`Gpu::device`] once all work submitted so far is done.
    pub(crate) fn bury(&self, destroy: impl FnOnce(&ash::Device) + Send + 'static) {
        self.shared.bury(Grave::Other(Box::new(destroy)));
    }

    /// Names a handle for debuggers and validation messages.
    pub(crate) fn name<T: vk::Handle>(&self, handle: T, name: &str) {
        self.shared.name(handle, name);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
