//! Features beyond the baseline: which the device has, and which this session may use.

use std::ffi::CStr;

use ash::{ext, khr, vk};

use super::{fault::Subject, instance::Instance, physical::Physical};
use crate::{Error, Result};

/// Features that have a fallback. As a request: what may be used. On a device: what is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Features {
    /// `vkCmdPipelineBarrier2`; the fallback is `vkCmdPipelineBarrier`.
    pub synchronization2: bool,
    /// Timestamps; without them no frame has timings.
    pub timestamps: bool,
    /// Debug names and labels.
    pub labels: bool,
    /// Reading the device's clock from the CPU.
    pub calibrated_timestamps: bool,
    /// Lines as a polygon mode, for wireframes.
    pub wireframe: bool,
    /// Fragment shaders run a sample each, for smooth outlines of what they intersect; the fallback has steps there.
    pub sample_shading: bool,
    /// Images are filtered with weights of single precision, as software rasterisers do; the fallback weighs texels in
    /// shaders, since graphics processors know but 256 weights between two texels, by which the skin would tremble.
    pub exact_filter: bool,
}

impl Features {
    /// Everything that the device has.
    pub const ALL: Self = Self {
        synchronization2: true,
        timestamps: true,
        labels: true,
        calibrated_timestamps: true,
        wireframe: true,
        sample_shading: true,
        exact_filter: true,
    };
    /// Only the baseline.
    pub const NONE: Self = Self {
        synchronization2: false,
        timestamps: false,
        labels: false,
        calibrated_timestamps: false,
        wireframe: false,
        sample_shading: false,
        exact_filter: false,
    };
}

impl Default for Features {
    fn default() -> Self {
        Self::ALL
    }
}

fn extensions(instance: &Instance, physical: &Physical) -> Result<Vec<vk::ExtensionProperties>> {
    // SAFETY: the physical device was enumerated from this instance, which is alive.
    unsafe {
        instance
            .raw
            .enumerate_device_extension_properties(physical.raw)
    }
    .subject(
        "vkEnumerateDeviceExtensionProperties",
        &physical.report.name,
    )
}

/// What a device has of what is wanted.
pub(crate) struct Offer {
    /// What of it can be turned on.
    pub(crate) used: Features,
    portability: bool,
    sync: vk::PhysicalDeviceSynchronization2Features<'static>,
}

impl Offer {
    pub(crate) fn of(instance: &Instance, physical: &Physical, wanted: Features) -> Result<Self> {
        let offered = extensions(instance, physical)?;
        let has = |name: &CStr| {
            offered
                .iter()
                .any(|e| e.extension_name_as_c_str() == Ok(name))
        };
        let (sync, core) = query(instance, physical, has(khr::synchronization2::NAME))?;
        let used = Features {
            synchronization2: wanted.synchronization2 && sync.synchronization2 == vk::TRUE,
            timestamps: wanted.timestamps && physical.family_properties.timestamp_valid_bits > 0,
            labels: wanted.labels && instance.debug_utils,
            calibrated_timestamps: wanted.calibrated_timestamps
                && has(ext::calibrated_timestamps::NAME),
            wireframe: wanted.wireframe && core.fill_mode_non_solid == vk::TRUE,
            sample_shading: wanted.sample_shading && core.sample_rate_shading == vk::TRUE,
            exact_filter: wanted.exact_filter && physical.filters_exactly(),
        };
        Ok(Self {
            used,
            portability: has(PORTABILITY),
            sync,
        })
    }

    /// Device extensions behind it.
    pub(crate) fn extensions(&self) -> impl Iterator<Item = &'static CStr> {
        let names = [
            (self.used.synchronization2, khr::synchronization2::NAME),
            (
                self.used.calibrated_timestamps,
                ext::calibrated_timestamps::NAME,
            ),
            (self.portability, PORTABILITY),
        ];
        names.into_iter().filter(|n| n.0).map(|n| n.1)
    }
}

const PORTABILITY: &CStr = c"VK_KHR_portability_subset";

/// Creates the logical device with one queue; what is in `wanted` is turned on where the device has it.
pub(crate) fn create_device(
    instance: &Instance,
    physical: &Physical,
    wanted: Features,
) -> Result<(ash::Device, Features)> {
    let mut offer = Offer::of(instance, physical, wanted)?;
    let used = offer.used;
    let names: Vec<_> = offer.extensions().map(CStr::as_ptr).collect();
    let queue = vk::DeviceQueueCreateInfo::default()
        .queue_family_index(physical.family)
        .queue_priorities(&[1.0]);
    let queues = [queue];
    let core = vk::PhysicalDeviceFeatures::default()
        .fill_mode_non_solid(used.wireframe)
        .sample_rate_shading(used.sample_shading);
    let mut timeline =
        vk::PhysicalDeviceTimelineSemaphoreFeatures::default().timeline_semaphore(true);
    let mut info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&names)
        .enabled_features(&core)
        .push_next(&mut timeline);
    if used.synchronization2 {
        info = info.push_next(&mut offer.sync);
    }
    // SAFETY: every pointer in `info` is to a value alive until the call returns; extensions and features were offered.
    let device = unsafe { instance.raw.create_device(physical.raw, &info, None) }
        .subject("vkCreateDevice", &physical.report.name)?;
    Ok((device, used))
}

fn query(
    instance: &Instance,
    physical: &Physical,
    has_sync: bool,
) -> Result<(
    vk::PhysicalDeviceSynchronization2Features<'static>,
    vk::PhysicalDeviceFeatures,
)> {
    let mut sync = vk::PhysicalDeviceSynchronization2Features::default();
    let mut timeline = vk::PhysicalDeviceTimelineSemaphoreFeatures::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut timeline);
    if has_sync {
        features = features.push_next(&mut sync);
    }
    // SAFETY: the chained structs are alive and known to a 1.2 device (synchronization2 only where it is offered).
    unsafe {
        instance
            .raw
            .get_physical_device_features2(physical.raw, &mut features)
    };
    let core = features.features;
    if timeline.timeline_semaphore != vk::TRUE {
        let reason = format!(
            "{} lacks timeline semaphores, which Vulkan 1.2 demands",
            physical.report.name
        );
        return Err(Error::NoDevice { reason });
    }
    let offered = sync.synchronization2;
    let sync =
        vk::PhysicalDeviceSynchronization2Features::default().synchronization2(offered == vk::TRUE);
    Ok((sync, core))
}
