//! Which device: properties, queue family and the choice among several.

use ash::vk;

use super::{
    fault::Subject,
    instance::{API, Instance},
};
use crate::{Error, Result, report::DeviceReport};

/// Which device to use.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum DeviceSelector {
    /// Discrete before integrated before virtual before CPU.
    #[default]
    Auto,
    /// Row in [`Gpu::enumerate`](super::Gpu::enumerate).
    Index(usize),
    /// First device with this in its name, upper and lower case alike.
    Name(String),
}

/// A physical device that dermis can use.
#[derive(Clone)]
pub(crate) struct Physical {
    pub(crate) raw: vk::PhysicalDevice,
    pub(crate) properties: vk::PhysicalDeviceProperties,
    pub(crate) memory: vk::PhysicalDeviceMemoryProperties,
    pub(crate) family: u32,
    pub(crate) family_properties: vk::QueueFamilyProperties,
    pub(crate) report: DeviceReport,
}

impl Physical {
    /// Bytes of the largest device-local heap.
    pub(crate) fn heap(&self) -> u64 {
        let heaps = self.memory.memory_heaps_as_slice().iter();
        let local = heaps.filter(|h| h.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL));
        local.map(|h| h.size).max().unwrap_or(0)
    }

    /// Whether it filters images with weights of single precision. No limit tells: llvmpipe, which does, reports the eight
    /// bits of graphics processors.
    pub(crate) fn filters_exactly(&self) -> bool {
        self.properties.device_type == vk::PhysicalDeviceType::CPU
    }

    /// A device of the host's, with the family of its queue.
    pub(crate) fn of_host(
        instance: &Instance,
        raw: vk::PhysicalDevice,
        family: u32,
    ) -> Result<Self> {
        let mut physical = Self::new(instance, 0, raw).ok_or_else(|| Error::NoDevice {
            reason: "the host's device lacks Vulkan 1.2 or a queue that does compute".into(),
        })?;
        // SAFETY: the physical device is of this instance, as in `new`.
        let families = unsafe {
            let instance = &instance.raw;
            instance.get_physical_device_queue_family_properties(raw)
        };
        let properties = families.get(family as usize).copied().unwrap_or_default();
        if !properties.queue_flags.contains(vk::QueueFlags::COMPUTE) {
            let reason = format!("family {family} of {} does no compute", families.len());
            return Err(Error::argument("queue_family", reason));
        }
        (physical.family, physical.family_properties) = (family, properties);
        Ok(physical)
    }

    fn new(instance: &Instance, index: usize, raw: vk::PhysicalDevice) -> Option<Self> {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        // SAFETY: `raw` was enumerated from this instance; the queried structs are alive and of the right type. The
        // driver struct is core in 1.2 and ignored by older devices.
        let (properties, memory, families) = unsafe {
            let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
            instance
                .raw
                .get_physical_device_properties2(raw, &mut properties);
            let properties = properties.properties;
            let memory = instance.raw.get_physical_device_memory_properties(raw);
            let families = instance
                .raw
                .get_physical_device_queue_family_properties(raw);
            (properties, memory, families)
        };
        let family = family(&families)?;
        (properties.api_version >= API).then(|| Self {
            raw,
            properties,
            memory,
            family: family as u32,
            family_properties: families[family],
            report: report(index, &properties, &driver),
        })
    }
}

/// A family that does graphics and compute, else one that does compute.
fn family(families: &[vk::QueueFamilyProperties]) -> Option<usize> {
    let with = |flags| families.iter().position(|f| f.queue_flags.contains(flags));
    with(vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE)
        .or_else(|| with(vk::QueueFlags::COMPUTE))
}

fn report(
    index: usize,
    properties: &vk::PhysicalDeviceProperties,
    driver: &vk::PhysicalDeviceDriverProperties<'_>,
) -> DeviceReport {
    let text = |s: Result<&std::ffi::CStr, _>| {
        s.map(|s| s.to_string_lossy().into_owned())
            .unwrap_or_default()
    };
    let api = properties.api_version;
    let (name, info) = (
        text(driver.driver_name_as_c_str()),
        text(driver.driver_info_as_c_str()),
    );
    DeviceReport {
        index,
        name: text(properties.device_name_as_c_str()),
        driver: format!("{name} {info}").trim().to_owned(),
        api: format!(
            "{}.{}.{}",
            vk::api_version_major(api),
            vk::api_version_minor(api),
            vk::api_version_patch(api)
        ),
        kind: kind(properties.device_type).to_owned(),
    }
}

fn kind(kind: vk::PhysicalDeviceType) -> &'static str {
    match kind {
        vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
        vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
        vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
        vk::PhysicalDeviceType::CPU => "cpu",
        _ => "other",
    }
}

/// Place in the order of preference, smallest first.
fn rank(kind: &str) -> usize {
    let order = ["discrete", "integrated", "virtual", "cpu"];
    order.iter().position(|k| *k == kind).unwrap_or(order.len())
}

/// Devices that dermis can use; their report's index counts all that the loader knows.
pub(crate) fn enumerate(instance: &Instance) -> Result<Vec<Physical>> {
    // SAFETY: the instance is alive.
    let raw = unsafe { instance.raw.enumerate_physical_devices() }
        .subject("vkEnumeratePhysicalDevices", "instance")?;
    let devices = raw.into_iter().enumerate();
    Ok(devices
        .filter_map(|(i, raw)| Physical::new(instance, i, raw))
        .collect())
}

/// The row among `reports` that `selector` asks for.
pub(crate) fn select(reports: &[&DeviceReport], selector: &DeviceSelector) -> Result<usize> {
    let rows = 0..reports.len();
    let found = match selector {
        DeviceSelector::Auto => rows.min_by_key(|&i| rank(&reports[i].kind)),
        DeviceSelector::Index(index) => rows.clone().find(|&i| reports[i].index == *index),
        DeviceSelector::Name(part) => {
            let part = part.to_lowercase();
            rows.clone()
                .find(|&i| reports[i].name.to_lowercase().contains(&part))
        }
    };
    found.ok_or_else(|| Error::NoDevice {
        reason: refusal(reports, selector),
    })
}

fn refusal(reports: &[&DeviceReport], selector: &DeviceSelector) -> String {
    let list = || {
        let names = reports.iter().map(|r| format!("{} ({})", r.index, r.name));
        names.collect::<Vec<_>>().join(", ")
    };
    match selector {
        _ if reports.is_empty() => "no driver offers Vulkan 1.2 with a compute queue; on Debian \
             `apt install mesa-vulkan-drivers` brings a software device"
            .into(),
        DeviceSelector::Auto => "none fits".into(),
        DeviceSelector::Index(index) => format!("none has index {index}; there are: {}", list()),
        DeviceSelector::Name(part) => format!("no name contains {part:?}; there are: {}", list()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn device(index: usize, name: &str, kind: &str) -> DeviceReport {
        DeviceReport {
            index,
            name: name.into(),
            kind: kind.into(),
            ..Default::default()
        }
    }

    #[test]
    fn auto_prefers_discrete_then_integrated_then_virtual_then_cpu() {
        let mut devices = vec![device(0, "llvmpipe", "cpu")];
        for (index, kind) in ["virtual", "integrated", "discrete"]
            .into_iter()
            .enumerate()
        {
            devices.push(device(index + 1, kind, kind));
            let reports: Vec<_> = devices.iter().collect();
            assert_eq!(select(&reports, &DeviceSelector::Auto).unwrap(), index + 1);
        }
    }

    #[test]
    fn index_counts_devices_that_were_left_out() {
        let devices = [device(1, "a", "cpu"), device(4, "b", "cpu")];
        let reports: Vec<_> = devices.iter().collect();
        assert_eq!(select(&reports, &DeviceSelector::Index(4)).unwrap(), 1);
        let error = select(&reports, &DeviceSelector::Index(0))
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("index 0") && error.contains("4 (b)"),
            "{error}"
        );
    }

    #[test]
    fn name_part_ignores_case_and_a_wrong_one_lists_the_devices() {
        let devices = [
            device(0, "NVIDIA H200", "discrete"),
            device(1, "llvmpipe", "cpu"),
        ];
        let reports: Vec<_> = devices.iter().collect();
        assert_eq!(
            select(&reports, &DeviceSelector::Name("LLVM".into())).unwrap(),
            1
        );
        let wrong = DeviceSelector::Name("radeon".into());
        let error = select(&reports, &wrong).unwrap_err().to_string();
        assert!(
            error.contains("radeon") && error.contains("1 (llvmpipe)"),
            "{error}"
        );
    }

    #[test]
    fn no_device_at_all_says_what_to_install() {
        let error = select(&[], &DeviceSelector::Auto).unwrap_err().to_string();
        assert!(error.contains("mesa-vulkan-drivers"), "{error}");
    }
}
