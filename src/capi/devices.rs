//! The devices that a context can be made on.

use std::ffi::{c_char, c_void};

use super::{
    guard::{Fault, c_text, dm_result, guard},
    pointer::structs,
};
use crate::gpu::Gpu;

/// A device, as dm_devices reports it. Text is valid during the call only.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_device_info {
    /// sizeof(dm_device_info), set by dermis.
    pub size: u32,
    /// Row in Vulkan's order, which dm_context_desc.device takes as text.
    pub index: u32,
    /// Name that the driver gives.
    pub name: *const c_char,
    /// Driver and its version.
    pub driver: *const c_char,
    /// Vulkan version, as major.minor.patch.
    pub api: *const c_char,
    /// "discrete", "integrated", "virtual", "cpu" or "other".
    pub kind: *const c_char,
}

structs!(dm_device_info);

/// Receives one device of dm_devices: the user pointer and what there is to know, valid during the call only.
pub type dm_device_report =
    Option<unsafe extern "C" fn(user: *mut c_void, device: *const dm_device_info)>;

/// Reports every device that a context can be made on, in Vulkan's order.
///
/// report: called once each with user, during this call and on this thread; it may call dermis. It must return: neither throw
/// nor jump.
///
/// Threads: any. Takes milliseconds.
///
/// Returns DM_OK; DM_ERROR_NULL where report is; DM_ERROR_NO_DEVICE without a loader or a device that fits; DM_ERROR_VULKAN or
/// DM_ERROR_MEMORY where the driver fails.
///
/// # Safety
/// report is NULL or a function that may be called with user.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_devices(report: dm_device_report, user: *mut c_void) -> dm_result {
    guard("dm_devices", || {
        let Some(report) = report else {
            return Err(Fault::new(dm_result::DM_ERROR_NULL, "report is NULL"));
        };
        for device in Gpu::enumerate()? {
            let text = [device.name, device.driver, device.api, device.kind].map(|t| c_text(&t));
            let [name, driver, api, kind] = text.each_ref().map(|t| t.as_ptr());
            let info = dm_device_info {
                size: size_of::<dm_device_info>() as u32,
                index: device.index as u32,
                name,
                driver,
                api,
                kind,
            };
            // SAFETY: the caller's promise; struct and text live until it returns.
            unsafe { report(user, &info) };
        }
        Ok(())
    })
}
