//! Contexts: a device with all memory that is in use on it.

use std::ffi::{c_char, c_void};

use super::{
    guard::{Fault, Outcome, c_text, dm_result, guard},
    handle::{self, dm_context},
    log::{DM_LOG_INFO, Logger, Target, dm_log},
    pointer::{self, structs},
};
use crate::{
    deformer::Device,
    gpu::{DeviceSelector, Gpu, GpuOptions, Profile},
};

/// Flag of a context: compute on the CPU, without Vulkan. The same results up to rounding, slowly.
pub const DM_CONTEXT_CPU: u32 = 1;
/// Flag of a context: watch every call by Vulkan's validation layers, which have to be installed.
pub const DM_CONTEXT_VALIDATION: u32 = 2;
/// Flag of a context: measure times on the device, for dm_deformer_timings.
pub const DM_CONTEXT_TIMESTAMPS: u32 = 4;

/// How a context is made. Zeros besides size and api_version choose the best device.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_context_desc {
    /// sizeof(dm_context_desc).
    pub size: u32,
    /// DM_API_VERSION.
    pub api_version: u32,
    /// DM_CONTEXT_CPU, DM_CONTEXT_VALIDATION and DM_CONTEXT_TIMESTAMPS, or-ed; the latter two do nothing on the CPU.
    pub flags: u32,
    /// Part of a device's name, in any case, or its number in Vulkan's order, in UTF-8; NULL for the best: discrete before
    /// integrated before software. Not read with DM_CONTEXT_CPU.
    pub device: *const c_char,
    /// Most bytes of device memory in use at once; 0 for no bound but the device's.
    pub budget: u64,
    /// Receives messages; may be NULL.
    pub log: dm_log,
    /// First argument of log, kept as long as the context or a deformer in it exists.
    pub log_user: *mut c_void,
}

/// Device memory in use, in bytes by what it is for. All zero for a context on the CPU.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct dm_memory {
    /// sizeof(dm_memory), set by the caller.
    pub size: u32,
    /// Implicit fields of the bones.
    pub fields: u64,
    /// Topology, weights and rest state of meshes.
    pub mesh: u64,
    /// Operator volumes.
    pub operators: u64,
    /// Poses on their way to the device.
    pub pose_ring: u64,
    /// State and scratch of frames, staging.
    pub transient: u64,
    /// Results on their way back.
    pub readback: u64,
    /// Sum of all above.
    pub total: u64,
    /// Number of buffers and images.
    pub buffers: u64,
}

structs!(dm_context_desc, dm_memory);

/// Receives one buffer or image of dm_context_allocations: the user pointer, the member of dm_memory that it is counted in
/// and its name, both valid during the call only, and its bytes, alignment included.
pub type dm_allocation_report = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        class_name: *const c_char,
        name: *const c_char,
        bytes: u64,
    ),
>;

/// What a context's handle stands for.
pub(super) struct Context {
    pub(super) device: Device,
    pub(super) logger: std::sync::Arc<Logger>,
}

/// Runs `work` on a context whose device is not lost.
pub(super) fn with<T>(
    context: dm_context,
    work: impl FnOnce(&mut Context) -> Outcome<T>,
) -> Outcome<T> {
    let object = handle::get(context)?;
    let (logger, outcome) = {
        let mut context = handle::lock(&object)?;
        let logger = context.logger.clone();
        let outcome = logger.check().and_then(|()| work(&mut context));
        (logger, outcome)
    };
    logger.finish(outcome)
}

/// The device of a context that is not on the CPU.
pub(super) fn gpu_of(context: dm_context) -> Outcome<Gpu> {
    let reason = "a context on the CPU records no commands";
    with(context, |context| {
        let gpu = context.gpu().cloned();
        gpu.ok_or_else(|| Fault::argument("context", reason))
    })
}

impl Context {
    fn gpu(&self) -> Option<&Gpu> {
        match &self.device {
            Device::Gpu(gpu) => Some(gpu),
            Device::Cpu => None,
        }
    }
}

/// Opens a device of dermis' own: Vulkan instance, device, queue and memory belong to dermis.
///
/// desc: copied; its text may go after the call. out: receives the handle, which is the caller's to destroy.
///
/// Threads: any. Takes from milliseconds to a second.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_VERSION where api_version is not the library's;
/// DM_ERROR_ARGUMENT for unknown flags or text that is not UTF-8; DM_ERROR_NO_DEVICE without a loader, a device that fits or
/// the validation layers, with what to install; DM_ERROR_VULKAN, DM_ERROR_MEMORY or DM_ERROR_DEVICE_LOST where the driver fails.
///
/// # Safety
/// desc and out are NULL or valid; device is NULL or text that ends with zero; log and log_user stay valid as long as the
/// context and its deformers, and log may be called by any thread that calls dermis.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_context_create(
    desc: *const dm_context_desc,
    out: *mut dm_context,
) -> dm_result {
    guard("dm_context_create", || {
        // SAFETY: the caller's promise.
        let desc = unsafe { pointer::read(desc, "desc")? };
        pointer::not_null(out, "out")?;
        // SAFETY: the caller's promise.
        let device = unsafe { open(&desc)? };
        let target = Target {
            log: desc.log,
            user: desc.log_user,
        };
        let context = context(device, target, desc.flags & DM_CONTEXT_VALIDATION != 0);
        // SAFETY: not NULL; the caller's promise.
        unsafe { hand_out(context, out) }
    })
}

/// Gives a new context to the caller, then tells what there is to tell of it.
///
/// # Safety
/// `out` has been checked and may be written.
pub(super) unsafe fn hand_out(context: Context, out: *mut dm_context) -> Outcome {
    let logger = context.logger.clone();
    let handle = handle::insert(context)?;
    // SAFETY: the caller's promise.
    unsafe { pointer::put(out, handle) };
    logger.flush();
    Ok(())
}

/// # Safety
/// The text of `desc` is NULL or valid.
unsafe fn open(desc: &dm_context_desc) -> Outcome<Device> {
    Fault::check_version(desc.api_version)?;
    let known = DM_CONTEXT_CPU | DM_CONTEXT_VALIDATION | DM_CONTEXT_TIMESTAMPS;
    if desc.flags & !known != 0 {
        let reason = format!("{:#x} has unknown flags", desc.flags);
        return Err(Fault::argument("desc.flags", reason));
    }
    if desc.flags & DM_CONTEXT_CPU != 0 {
        return Ok(Device::Cpu);
    }
    let profile = match desc.flags & DM_CONTEXT_TIMESTAMPS {
        0 => Profile::Off,
        _ => Profile::Sampled,
    };
    let options = GpuOptions {
        // SAFETY: the caller's promise.
        device: unsafe { selector(desc.device)? },
        validation: desc.flags & DM_CONTEXT_VALIDATION != 0,
        budget: (desc.budget > 0).then_some(desc.budget),
        profile,
    };
    Ok(Device::Gpu(Gpu::new(&options)?))
}

/// # Safety
/// `name` is NULL or text that ends with zero.
unsafe fn selector(name: *const c_char) -> Outcome<DeviceSelector> {
    if name.is_null() {
        return Ok(DeviceSelector::Auto);
    }
    // SAFETY: not NULL; the caller's promise.
    let name = unsafe { pointer::text(name, "desc.device")? };
    let index = name.trim().parse();
    Ok(index.map_or(DeviceSelector::Name(name), DeviceSelector::Index))
}

pub(super) fn context(device: Device, target: Target, validation: bool) -> Context {
    let (name, gpu) = match &device {
        Device::Cpu => ("the CPU".to_owned(), None),
        Device::Gpu(gpu) => (gpu.report().name, Some(gpu.clone())),
    };
    let logger = Logger::new(target, gpu, validation);
    logger.tell(DM_LOG_INFO, &format!("dermis computes on {name}"));
    Context { device, logger }
}

/// Destroys a context. Deformers in it stay usable and keep its device until they are destroyed, too.
///
/// Threads: any; a call that uses the context on another thread completes first or keeps it until its end.
/// May wait for the device.
///
/// Returns DM_OK, or DM_ERROR_HANDLE where there is no such context (any more).
#[unsafe(no_mangle)]
pub extern "C" fn dm_context_destroy(context: dm_context) -> dm_result {
    guard("dm_context_destroy", || handle::destroy(context))
}

/// Sums the device memory that a context has in use.
///
/// out: size set by the caller, the rest is filled.
///
/// Threads: any. Does not wait for the device.
///
/// Returns DM_OK, DM_ERROR_NULL, DM_ERROR_STRUCT_SIZE, DM_ERROR_HANDLE, DM_ERROR_DEVICE_LOST or DM_ERROR_PANIC.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_context_memory(context: dm_context, out: *mut dm_memory) -> dm_result {
    guard("dm_context_memory", || {
        // SAFETY: the caller's promise.
        unsafe { pointer::check(out, "out")? };
        let rows = allocations(context)?;
        let class = |name: &str| {
            let of_class = rows.iter().filter(|row| row.0 == name);
            of_class.map(|row| row.2).sum()
        };
        let memory = dm_memory {
            size: size_of::<dm_memory>() as u32,
            fields: class("fields"),
            mesh: class("mesh"),
            operators: class("operators"),
            pose_ring: class("pose_ring"),
            transient: class("transient"),
            readback: class("readback"),
            total: rows.iter().map(|row| row.2).sum(),
            buffers: rows.len() as u64,
        };
        // SAFETY: checked above.
        unsafe { pointer::put(out, memory) };
        Ok(())
    })
}

/// Class, name and bytes of all that is in use; nothing on the CPU.
fn allocations(context: dm_context) -> Outcome<Vec<(String, String, u64)>> {
    with(context, |context| {
        let rows = context.gpu().map(Gpu::allocations).unwrap_or_default();
        Ok(rows
            .into_iter()
            .map(|row| (row.class, row.name, row.bytes))
            .collect())
    })
}

/// Reports every buffer and image that a context has in use, in the order in which they were made; none on the CPU.
///
/// report: called once each with user, during this call and on this thread; no object is locked meanwhile, so that it may
/// call dermis. It must return: neither throw nor jump.
///
/// Threads: any. Does not wait for the device.
///
/// Returns DM_OK, DM_ERROR_NULL where report is, DM_ERROR_HANDLE, DM_ERROR_DEVICE_LOST or DM_ERROR_PANIC.
///
/// # Safety
/// report is NULL or a function that may be called with user.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_context_allocations(
    context: dm_context,
    report: dm_allocation_report,
    user: *mut c_void,
) -> dm_result {
    guard("dm_context_allocations", || {
        let Some(report) = report else {
            return Err(Fault::new(dm_result::DM_ERROR_NULL, "report is NULL"));
        };
        for (class, name, bytes) in allocations(context)? {
            let (class, name) = (c_text(&class), c_text(&name));
            // SAFETY: the caller's promise; both texts live until it returns.
            unsafe { report(user, class.as_ptr(), name.as_ptr(), bytes) };
        }
        Ok(())
    })
}
