//! A device that belongs to someone else: dermis works on it and leaves it as it was.

use std::{ffi::CStr, sync::Arc};

use ash::vk;

use super::{
    Buffer, Features, Gpu, GpuOptions, Handover,
    features::Offer,
    instance::Instance,
    physical::Physical,
    shared::{Owner, Shared},
};
use crate::{Error, Result};

/// A device of the host's with one of its queues.
#[derive(Clone, Copy)]
pub struct Host {
    /// The loader's entry; all functions are loaded from here.
    pub get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
    /// The instance, made for Vulkan 1.2 or newer.
    pub instance: vk::Instance,
    /// The physical device, of Vulkan 1.2 or newer.
    pub physical_device: vk::PhysicalDevice,
    /// The device, with timeline semaphores turned on.
    pub device: vk::Device,
    /// A queue of `device`.
    pub queue: vk::Queue,
    /// Its family, which has to do compute.
    pub queue_family: u32,
    /// What the host has turned on, extensions and features both. Timestamps and filters need nothing to be turned on.
    pub features: Features,
}

/// A primary command buffer of the host's that is being recorded. Dermis executes secondary ones in it: afterwards, what was bound
/// before has to be bound anew.
#[derive(Debug)]
pub struct HostCommands(pub(crate) vk::CommandBuffer);

impl HostCommands {
    /// Lets dermis record into `commands`.
    ///
    /// # Safety
    /// Until this is dropped, the command buffer, a primary one, is being recorded outside of a render pass and of queries, for the
    /// family of the queue that dermis uses. It is submitted to that queue, once, and what dermis recorded with the same frame slot
    /// before is done by then.
    /// What was recorded from, a deformer and its output, outlives its execution.
    pub unsafe fn new(commands: vk::CommandBuffer) -> Self {
        Self(commands)
    }
}

/// What dermis can make use of on a physical device, for a host that is about to create its device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Requirements {
    /// Features beyond the baseline that it offers; each has a fallback.
    pub features: Features,
    /// Device extensions behind them.
    pub extensions: Vec<&'static CStr>,
    /// Families whose queues do compute, those that do graphics as well first.
    pub queue_families: Vec<u32>,
}

impl Gpu {
    /// Works on a device of the host's. Nothing of it is destroyed with this handle, and everything that dermis made on it is.
    ///
    /// # Errors
    /// [`Error::Argument`] for a queue family that the device lacks or that does no compute, or features that are not on; [`Error::NoDevice`] below
    /// Vulkan 1.2; [`Error::Vulkan`] where the driver fails.
    ///
    /// # Safety
    /// The handles are valid and stay so until the last clone of this handle, and of all that was made with it, is dropped.
    /// What `features` names is turned on. While dermis submits (everything but
    /// [`Deformer::record`](crate::deformer::Deformer::record) may), nobody else uses the queue.
    pub unsafe fn adopt(host: &Host, options: &GpuOptions) -> Result<Self> {
        // SAFETY: promised by the caller.
        let instance = unsafe { Instance::of_host(host.get_instance_proc_addr, host.instance) };
        let physical = Physical::of_host(&instance, host.physical_device, host.queue_family)?;
        // SAFETY: promised by the caller.
        let device = unsafe { ash::Device::load(instance.raw.fp_v1_0(), host.device) };
        let timestamps = physical.family_properties.timestamp_valid_bits > 0;
        let features = Features {
            timestamps: host.features.timestamps && timestamps,
            exact_filter: host.features.exact_filter && physical.filters_exactly(),
            ..host.features
        };
        check_functions(&instance, &device, features)?;
        let owner = Owner::Host(host.queue);
        let shared = Shared::with_device(options, instance, physical, device, features, owner)?;
        Ok(Self {
            shared: Arc::new(shared),
        })
    }

    /// The first `bytes` of a buffer of the host's.
    ///
    /// # Errors
    /// [`Error::Memory`] for a null handle, no bytes, or more than the device binds at once.
    ///
    /// # Safety
    /// The buffer is of this device, made for storage use, that long, and alive until the last clone of this handle is dropped.
    pub unsafe fn host_buffer(&self, raw: vk::Buffer, name: &str, bytes: u64) -> Result<Buffer> {
        // SAFETY: promised by the caller.
        unsafe { Buffer::of_host(&self.shared, raw, name, bytes) }
    }

    /// Refuses a queue family that no buffer can be released to, since the device has no such family.
    pub(crate) fn check_handover(&self, to: &Handover) -> Result<()> {
        let physical = self.shared.physical.raw;
        let raw = &self.shared.instance.raw;
        // SAFETY: the physical device is of this instance, which is alive.
        let families = unsafe { raw.get_physical_device_queue_family_properties(physical) };
        let beyond = [vk::QUEUE_FAMILY_EXTERNAL, vk::QUEUE_FAMILY_FOREIGN_EXT];
        match to.family {
            Some(family) if family as usize >= families.len() && !beyond.contains(&family) => {
                let reason = format!("{family} given, the device has {}", families.len());
                Err(Error::argument("queue family", reason))
            }
            _ => Ok(()),
        }
    }

    /// What a host that creates its own device may turn on for dermis. Besides, `timelineSemaphore` has to be on.
    ///
    /// # Errors
    /// [`Error::NoDevice`] where the device is older than Vulkan 1.2 or has no queue that does compute; [`Error::Vulkan`]
    /// where the driver fails.
    ///
    /// # Safety
    /// The instance is valid, and the physical device one of it.
    pub unsafe fn requirements(
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
    ) -> Result<Requirements> {
        // SAFETY: promised by the caller.
        let instance = unsafe { Instance::of_host(get_instance_proc_addr, instance) };
        // SAFETY: of this instance, says the caller.
        let families = unsafe {
            let raw = &instance.raw;
            raw.get_physical_device_queue_family_properties(physical_device)
        };
        let queue_families = compute_families(&families);
        let first = *queue_families.first().ok_or_else(|| Error::NoDevice {
            reason: "the device has no queue that does compute".into(),
        })?;
        let physical = Physical::of_host(&instance, physical_device, first)?;
        let offer = Offer::of(&instance, &physical, Features::ALL)?;
        Ok(Requirements {
            features: offer.used,
            extensions: offer.extensions().collect(),
            queue_families,
        })
    }
}

/// What is said to be turned on has its functions.
fn check_functions(instance: &Instance, device: &ash::Device, features: Features) -> Result<()> {
    let wanted = [
        (features.synchronization2, c"vkCmdPipelineBarrier2KHR"),
        (features.labels, c"vkCmdBeginDebugUtilsLabelEXT"),
        (features.labels, c"vkCmdEndDebugUtilsLabelEXT"),
        (features.labels, c"vkSetDebugUtilsObjectNameEXT"),
        (
            features.calibrated_timestamps,
            c"vkGetCalibratedTimestampsEXT",
        ),
    ];
    for (_, name) in wanted.iter().filter(|w| w.0) {
        // SAFETY: instance and device are alive, the name ends with zero.
        let function = unsafe {
            let get = instance.raw.fp_v1_0().get_device_proc_addr;
            get(device.handle(), name.as_ptr())
        };
        if function.is_none() {
            let reason = format!(
                "{} is missing: its extension is not on",
                name.to_string_lossy()
            );
            return Err(Error::argument("features", reason));
        }
    }
    Ok(())
}

/// Families that do compute, those that do graphics as well first.
fn compute_families(families: &[vk::QueueFamilyProperties]) -> Vec<u32> {
    let does = |i: &u32, flags| families[*i as usize].queue_flags.contains(flags);
    let all = 0..families.len() as u32;
    let mut rows: Vec<u32> = all.filter(|i| does(i, vk::QueueFlags::COMPUTE)).collect();
    rows.sort_by_key(|i| !does(i, vk::QueueFlags::GRAPHICS));
    rows
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn families_that_do_graphics_come_first_and_others_are_left_out() {
        let family = |flags| vk::QueueFamilyProperties {
            queue_flags: flags,
            ..Default::default()
        };
        let (compute, graphics) = (vk::QueueFlags::COMPUTE, vk::QueueFlags::GRAPHICS);
        let all = [
            family(vk::QueueFlags::TRANSFER),
            family(compute),
            family(compute | graphics),
        ];
        assert_eq!(compute_families(&all), [2, 1]);
        assert!(compute_families(&all[..1]).is_empty());
    }
}
