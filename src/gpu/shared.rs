//! The device that all handles share, and its end.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex},
};

use ash::{ext, khr, vk};

use super::{
    GpuOptions,
    fault::{Subject, lock},
    features::{self, Features},
    instance::Instance,
    memory::{Block, Memory},
    physical::{self, Physical},
    pipeline::Pipeline,
    queue::Queue,
    timestamps::SharedProfile,
};
use crate::Result;

/// Bytes of push constants that every Vulkan device has.
pub(crate) const PUSH_CONSTANTS: u32 = 128;

/// One logical device; lives until the last handle made with it is dropped.
pub(crate) struct Shared {
    pub(crate) device: ash::Device,
    pub(crate) physical: Physical,
    pub(crate) features: Features,
    pub(crate) profile: SharedProfile,
    pub(crate) sync2: Option<khr::synchronization2::Device>,
    pub(crate) debug: Option<ext::debug_utils::Device>,
    pub(crate) calibrated: Option<ext::calibrated_timestamps::Device>,
    pub(crate) memory: Memory,
    pub(crate) queue: Queue,
    pub(crate) sampler: vk::Sampler,
    pub(crate) pipelines: Mutex<HashMap<(&'static str, u32), Arc<Pipeline>>>,
    graveyard: Mutex<Vec<(u64, Grave)>>,
    owner: Owner,
    /// Last, so that it outlives the device.
    pub(crate) instance: Instance,
}

/// Whose a device is.
#[derive(Clone, Copy)]
pub(crate) enum Owner {
    /// Its first queue is used, and it is destroyed at the end.
    Dermis,
    /// The host's, with the queue to use.
    Host(vk::Queue),
}

/// A handle that nobody holds any more but the device may still use.
pub(crate) enum Grave {
    Buffer(vk::Buffer, Block),
    Image(vk::Image, vk::ImageView, Block),
    /// Any other handle, with how to destroy it.
    Other(Box<dyn FnOnce(&ash::Device) + Send>),
}

impl Shared {
    pub(crate) fn new(options: &GpuOptions, wanted: Features) -> Result<Self> {
        let instance = Instance::new(options.validation)?;
        let mut devices = physical::enumerate(&instance)?;
        let reports: Vec<_> = devices.iter().map(|d| &d.report).collect();
        let row = physical::select(&reports, &options.device)?;
        let physical = devices.swap_remove(row);
        let (device, features) = features::create_device(&instance, &physical, wanted)?;
        Self::with_device(options, instance, physical, device, features, Owner::Dermis)
    }

    /// Completes what [`Shared::new`] began; destroys an own `device` where a part of it fails.
    pub(crate) fn with_device(
        options: &GpuOptions,
        instance: Instance,
        physical: Physical,
        device: ash::Device,
        features: Features,
        owner: Owner,
    ) -> Result<Self> {
        let queue = match owner {
            // SAFETY: the device is alive and was created with one queue of this family.
            Owner::Dermis => unsafe { device.get_device_queue(physical.family, 0) },
            Owner::Host(queue) => queue,
        };
        let parts = Parts::new(&instance, &physical, &device, queue, options.budget);
        let Parts {
            memory,
            queue,
            sampler,
        } = parts.inspect_err(|_| {
            if matches!(owner, Owner::Dermis) {
                // SAFETY: `Parts::new` destroyed what it made, so that nothing of the device is left.
                unsafe { device.destroy_device(None) }
            }
        })?;
        let (i, d) = (&instance.raw, &device);
        Ok(Self {
            sync2: features
                .synchronization2
                .then(|| khr::synchronization2::Device::new(i, d)),
            debug: features.labels.then(|| ext::debug_utils::Device::new(i, d)),
            calibrated: features
                .calibrated_timestamps
                .then(|| ext::calibrated_timestamps::Device::new(i, d)),
            profile: SharedProfile::new(options.profile),
            pipelines: Mutex::default(),
            graveyard: Mutex::default(),
            device,
            physical,
            features,
            memory,
            queue,
            sampler,
            owner,
            instance,
        })
    }

    /// Names an object for debuggers and validation messages.
    pub(crate) fn name<T: vk::Handle>(&self, handle: T, name: &str) {
        let Some(debug) = &self.debug else { return };
        let Ok(name) = std::ffi::CString::new(name) else {
            return;
        };
        let info = vk::DebugUtilsObjectNameInfoEXT::default()
            .object_handle(handle)
            .object_name(&name);
        // SAFETY: the handle is of this device and alive, the name lives until the call returns. A failure costs a name.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }

    /// Takes a handle that nobody holds any more; destroys it once all work submitted so far is done.
    pub(crate) fn bury(&self, grave: Grave) {
        let submitted = self.queue.submitted();
        lock(&self.graveyard).push((submitted, grave));
        self.collect();
    }

    /// Destroys the handles in the graveyard whose submissions are done.
    pub(crate) fn collect(&self) {
        let done = self.queue.completed(&self.device);
        let mut graveyard = lock(&self.graveyard);
        let mut row = 0;
        while row < graveyard.len() {
            if graveyard[row].0 <= done {
                let (_, grave) = graveyard.swap_remove(row);
                self.destroy(grave);
            } else {
                row += 1;
            }
        }
    }

    /// Destroys what nobody holds and no unfinished submission uses; callers have seen to that.
    fn destroy(&self, grave: Grave) {
        let device = &self.device;
        match grave {
            Grave::Buffer(buffer, block) => {
                // SAFETY: of this device and unused, see above.
                unsafe { device.destroy_buffer(buffer, None) };
                self.memory.free(block);
            }
            Grave::Image(image, view, block) => {
                // SAFETY: of this device and unused, see above.
                unsafe {
                    device.destroy_image_view(view, None);
                    device.destroy_image(image, None);
                }
                self.memory.free(block);
            }
            Grave::Other(destroy) => destroy(device),
        }
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        self.queue.drain(&self.device);
        // SAFETY: all handles made with the device hold this struct, so none is left; all submissions are done, or the
        // device is lost and destroying is still allowed. Memory goes before the device, the device before the instance.
        unsafe {
            for (_, grave) in std::mem::take(&mut *lock(&self.graveyard)) {
                self.destroy(grave);
            }
            for pipeline in lock(&self.pipelines).values() {
                pipeline.destroy(&self.device);
            }
            self.device.destroy_sampler(self.sampler, None);
            self.queue.destroy(&self.device);
            self.memory.close();
            if matches!(self.owner, Owner::Dermis) {
                self.device.destroy_device(None);
            }
        }
    }
}

/// What a device needs besides its functions.
struct Parts {
    memory: Memory,
    queue: Queue,
    sampler: vk::Sampler,
}

impl Parts {
    fn new(
        instance: &Instance,
        physical: &Physical,
        device: &ash::Device,
        queue: vk::Queue,
        budget: Option<u64>,
    ) -> Result<Self> {
        let memory = Memory::new(instance, device, physical, budget)?;
        let queue = Queue::new(device, queue)?;
        let sampler = sampler(device).inspect_err(|_| queue.destroy(device))?;
        Ok(Self {
            memory,
            queue,
            sampler,
        })
    }
}

/// The one sampler: linear, clamps to the edge.
fn sampler(device: &ash::Device) -> Result<vk::Sampler> {
    let clamp = vk::SamplerAddressMode::CLAMP_TO_EDGE;
    let info = vk::SamplerCreateInfo::default()
        .mag_filter(vk::Filter::LINEAR)
        .min_filter(vk::Filter::LINEAR)
        .address_mode_u(clamp)
        .address_mode_v(clamp)
        .address_mode_w(clamp);
    // SAFETY: the device is alive.
    unsafe { device.create_sampler(&info, None) }.subject("vkCreateSampler", "linear sampler")
}
