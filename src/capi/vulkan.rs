//! Contexts on a device of the host's.

use std::ffi::{CStr, c_char, c_void};

use ash::vk::{self, Handle as _};

use super::{
    context::{context, hand_out},
    guard::{Fault, dm_result, guard},
    handle::dm_context,
    log::{Target, dm_log},
    pointer::{self, structs},
};
use crate::{
    deformer::Device,
    gpu::{Features, Gpu, GpuOptions, Host},
};

/// Feature of a device: VK_KHR_synchronization2, the extension with its feature. Without it older barriers are recorded.
pub const DM_FEATURE_SYNCHRONIZATION2: u32 = 1;
/// Feature of an instance, where the host has turned it on: VK_EXT_debug_utils. With it objects have names and passes have labels.
pub const DM_FEATURE_DEBUG_UTILS: u32 = 2;

/// Most extensions that dermis can use.
pub const DM_MAX_EXTENSIONS: usize = 8;

/// Any function; to be cast to its own type.
pub type dm_function = Option<unsafe extern "system" fn()>;

/// vkGetInstanceProcAddr, as PFN_vkGetInstanceProcAddr cast to this type.
pub type dm_get_instance_proc_addr =
    Option<unsafe extern "system" fn(instance: *mut c_void, name: *const c_char) -> dm_function>;

/// A device of the host's. dermis creates on it what deformers need and destroys that again, and nothing else.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_vulkan_desc {
    /// sizeof(dm_vulkan_desc).
    pub size: u32,
    /// DM_API_VERSION.
    pub api_version: u32,
    /// From here all functions are loaded.
    pub get_instance_proc_addr: dm_get_instance_proc_addr,
    /// VkInstance, made for Vulkan 1.2 or newer.
    pub instance: *mut c_void,
    /// VkPhysicalDevice, of Vulkan 1.2 or newer.
    pub physical_device: *mut c_void,
    /// VkDevice, with timelineSemaphore turned on.
    pub device: *mut c_void,
    /// VkQueue of the device. All functions of deformers may submit to it but dm_deformer_destroy and dm_frame_record; nobody
    /// else may use it meanwhile.
    pub queue: *mut c_void,
    /// Family of the queue, which has to do compute.
    pub queue_family: u32,
    /// DM_FEATURE_SYNCHRONIZATION2 and DM_FEATURE_DEBUG_UTILS, or-ed: what the host has turned on.
    pub features: u32,
    /// Most bytes of device memory that dermis may have in use at once; 0 for no bound but the device's.
    pub budget: u64,
    /// Receives messages; may be NULL.
    pub log: dm_log,
    /// First argument of log, kept as long as the context or a deformer in it exists.
    pub log_user: *mut c_void,
}

/// What a host that is about to create its device may turn on for dermis. Besides, timelineSemaphore has to be on.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_vulkan_requirements {
    /// sizeof(dm_vulkan_requirements), set by the caller.
    pub size: u32,
    /// DM_FEATURE_SYNCHRONIZATION2 where the device offers it.
    pub features: u32,
    /// A queue family that does compute, graphics as well where there is one.
    pub queue_family: u32,
    /// Entries of extensions in use.
    pub extension_count: u32,
    /// Names of device extensions behind the features; the text is dermis' own and stays.
    pub extensions: [*const c_char; DM_MAX_EXTENSIONS],
}

structs!(dm_vulkan_desc, dm_vulkan_requirements);

/// Asks what dermis can make use of on a device, before the host creates it. Creates nothing.
///
/// get_instance_proc_addr, instance (VkInstance), physical_device (VkPhysicalDevice): the host's.
/// out: size set by the caller, the rest is filled.
///
/// Threads: any.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_NO_DEVICE where the device is older than Vulkan 1.2 or has
/// no queue that does compute; DM_ERROR_VULKAN; DM_ERROR_MEMORY.
///
/// # Safety
/// The handles are NULL or valid; out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_vulkan_get_requirements(
    get_instance_proc_addr: dm_get_instance_proc_addr,
    instance: *mut c_void,
    physical_device: *mut c_void,
    out: *mut dm_vulkan_requirements,
) -> dm_result {
    guard("dm_vulkan_get_requirements", || {
        // SAFETY: the caller's promise.
        unsafe { pointer::check(out, "out")? };
        let get = loader(get_instance_proc_addr)?;
        pointer::not_null(instance, "instance")?;
        pointer::not_null(physical_device, "physical_device")?;
        let instance = vk::Instance::from_raw(instance as u64);
        let physical = vk::PhysicalDevice::from_raw(physical_device as u64);
        // SAFETY: the caller's promise.
        let wanted = unsafe { Gpu::requirements(get, instance, physical)? };
        let mut extensions = [std::ptr::null(); DM_MAX_EXTENSIONS];
        // The interface has no times of clocks.
        let used = |name: &&&CStr| **name != ash::ext::calibrated_timestamps::NAME;
        let names = wanted.extensions.iter().filter(used);
        let mut count = 0;
        for (to, name) in extensions.iter_mut().zip(names) {
            *to = name.as_ptr();
            count += 1;
        }
        let bit = |on: bool, bit: u32| if on { bit } else { 0 };
        let requirements = dm_vulkan_requirements {
            size: size_of::<dm_vulkan_requirements>() as u32,
            features: bit(
                wanted.features.synchronization2,
                DM_FEATURE_SYNCHRONIZATION2,
            ),
            queue_family: wanted.queue_families.first().copied().unwrap_or(0),
            extension_count: count,
            extensions,
        };
        // SAFETY: checked above.
        unsafe { pointer::put(out, requirements) };
        Ok(())
    })
}

/// Makes a context on a device of the host's, which keeps all of it.
///
/// desc: copied. out: receives the handle, which is the caller's to destroy, with all deformers and outputs in it before the
/// device.
///
/// Threads: any.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_VERSION where api_version is not the library's;
/// DM_ERROR_ARGUMENT for features that are unknown or not on, or a queue family that does no compute; DM_ERROR_NO_DEVICE below Vulkan 1.2;
/// DM_ERROR_VULKAN or DM_ERROR_MEMORY where the driver fails.
///
/// # Safety
/// desc and out are NULL or valid; the Vulkan handles are NULL or valid, and stay so until the context and all that was made
/// in it are destroyed; log and log_user stay valid as long, and log may be called by any thread that calls dermis.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_context_adopt(
    desc: *const dm_vulkan_desc,
    out: *mut dm_context,
) -> dm_result {
    guard("dm_context_adopt", || {
        // SAFETY: the caller's promise.
        let desc = unsafe { pointer::read(desc, "desc")? };
        pointer::not_null(out, "out")?;
        let host = host(&desc)?;
        let options = GpuOptions {
            budget: (desc.budget > 0).then_some(desc.budget),
            ..GpuOptions::default()
        };
        // SAFETY: the caller's promise.
        let gpu = unsafe { Gpu::adopt(&host, &options)? };
        let target = Target {
            log: desc.log,
            user: desc.log_user,
        };
        let context = context(Device::Gpu(gpu), target, false);
        // SAFETY: not NULL; the caller's promise.
        unsafe { hand_out(context, out) }
    })
}

fn host(desc: &dm_vulkan_desc) -> Result<Host, Fault> {
    Fault::check_version(desc.api_version)?;
    let known = DM_FEATURE_SYNCHRONIZATION2 | DM_FEATURE_DEBUG_UTILS;
    if desc.features & !known != 0 {
        let reason = format!("{:#x} has unknown features", desc.features);
        return Err(Fault::argument("desc.features", reason));
    }
    let get_instance_proc_addr = loader(desc.get_instance_proc_addr)?;
    for (handle, name) in [
        (desc.instance, "desc.instance"),
        (desc.physical_device, "desc.physical_device"),
        (desc.device, "desc.device"),
        (desc.queue, "desc.queue"),
    ] {
        pointer::not_null(handle, name)?;
    }
    Ok(Host {
        get_instance_proc_addr,
        instance: vk::Instance::from_raw(desc.instance as u64),
        physical_device: vk::PhysicalDevice::from_raw(desc.physical_device as u64),
        device: vk::Device::from_raw(desc.device as u64),
        queue: vk::Queue::from_raw(desc.queue as u64),
        queue_family: desc.queue_family,
        features: Features {
            synchronization2: desc.features & DM_FEATURE_SYNCHRONIZATION2 != 0,
            labels: desc.features & DM_FEATURE_DEBUG_UTILS != 0,
            exact_filter: true,
            ..Features::NONE
        },
    })
}

fn loader(get: dm_get_instance_proc_addr) -> Result<vk::PFN_vkGetInstanceProcAddr, Fault> {
    let get =
        get.ok_or_else(|| Fault::new(dm_result::DM_ERROR_NULL, "get_instance_proc_addr is NULL"))?;
    // SAFETY: the same function with Vulkan's names for its types; a dispatchable handle is a pointer.
    Ok(unsafe {
        std::mem::transmute::<
            unsafe extern "system" fn(*mut c_void, *const c_char) -> dm_function,
            vk::PFN_vkGetInstanceProcAddr,
        >(get)
    })
}
