//! Measurements of the last frame of a deformer.

use std::ffi::{c_char, c_void};

use super::{
    deformer::with,
    guard::{Fault, c_text, dm_result, guard},
    handle::dm_deformer,
    pointer::{self, structs},
};

/// How much work the last frame did.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct dm_iterations {
    /// sizeof(dm_iterations), set by the caller.
    pub size: u32,
    /// Most field evaluations of a vertex.
    pub newton_max: u32,
    /// Mean field evaluations a vertex in reach of a field.
    pub newton_mean: f64,
    /// Rounds of projection and relaxation.
    pub rounds: u32,
    /// Jacobi iterations of all sub-steps (tracking).
    pub jacobi: u32,
    /// Sub-steps of the frame.
    pub substeps: u32,
    /// Sub-steps that were done again in two halves (tracking).
    pub halved: u32,
    /// 1 where the frame would have needed more sub-steps than it may have (tracking), else 0.
    pub capped: u32,
    /// Always 0.
    pub reserved: u32,
    /// Field evaluations of all vertices.
    pub evaluations: u64,
    /// Texture fetches of all vertices; 0 where they are not counted.
    pub fetches: u64,
}

/// How long the last frame took, in nanoseconds.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct dm_timings {
    /// sizeof(dm_timings), set by the caller.
    pub size: u32,
    /// 1 where the times on the device are measured, else 0: without DM_CONTEXT_TIMESTAMPS, on the CPU, or before a frame
    /// is complete.
    pub measured: u32,
    /// On the device, of the last frame that is complete, from its begin to its end; 0 where it is not measured.
    pub gpu_ns: u64,
    /// What one timestamp costs, taken off gpu_ns; 0 where it is not measured.
    pub stamp_ns: u64,
    /// On the CPU: what the last dm_deformer_advance took to record and submit, or on the CPU to compute.
    pub record_ns: u64,
    /// Frames in a row of which each times some of the passes and all together every one; 0 where it is not measured.
    pub turns: u32,
    /// Always 0.
    pub reserved: u32,
}

/// When one pass of a frame ran, as dm_deformer_passes reports it. Text is valid during the call only.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_pass_timing {
    /// sizeof(dm_pass_timing), set by dermis.
    pub size: u32,
    /// Steps that ran in this time, one after the other.
    pub steps: u32,
    /// Name of the pass; "fill" and "copy" for transfers.
    pub name: *const c_char,
    /// Finer label of the first step; the name where it has none.
    pub label: *const c_char,
    /// Begin, nanoseconds on the device's clock.
    pub begin_ns: u64,
    /// End, nanoseconds on the device's clock, without the timestamp that tells it.
    pub end_ns: u64,
}

structs!(dm_iterations, dm_timings, dm_pass_timing);

/// Receives one pass of dm_deformer_passes: the user pointer and when it ran, valid during the call only.
pub type dm_pass_report =
    Option<unsafe extern "C" fn(user: *mut c_void, pass: *const dm_pass_timing)>;

/// Tells how much work the last frame did, for all instances together; all zero for geometric methods.
///
/// out: size set by the caller, the rest is filled.
///
/// Threads: any. Waits for the frame.
///
/// Returns DM_OK, DM_ERROR_NULL, DM_ERROR_STRUCT_SIZE, DM_ERROR_HANDLE, DM_ERROR_VULKAN, DM_ERROR_MEMORY,
/// DM_ERROR_DEVICE_LOST or DM_ERROR_PANIC.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_deformer_iterations(
    deformer: dm_deformer,
    out: *mut dm_iterations,
) -> dm_result {
    guard("dm_deformer_iterations", || {
        // SAFETY: the caller's promise.
        unsafe { pointer::check(out, "out")? };
        let i = with(deformer, |instance| Ok(instance.deformer.iterations()?))?;
        let iterations = dm_iterations {
            size: size_of::<dm_iterations>() as u32,
            newton_max: i.newton_max,
            newton_mean: i.newton_mean,
            rounds: i.rounds,
            jacobi: i.jacobi,
            substeps: i.substeps,
            halved: i.halved,
            capped: u32::from(i.capped),
            reserved: 0,
            evaluations: i.evaluations,
            fetches: i.fetches,
        };
        // SAFETY: checked above.
        unsafe { pointer::put(out, iterations) };
        Ok(())
    })
}

/// Tells how long the last frame took.
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
pub unsafe extern "C" fn dm_deformer_timings(
    deformer: dm_deformer,
    out: *mut dm_timings,
) -> dm_result {
    guard("dm_deformer_timings", || {
        // SAFETY: the caller's promise.
        unsafe { pointer::check(out, "out")? };
        let (record_ns, frame) = with(deformer, |instance| {
            let deformer = &instance.deformer;
            Ok((deformer.record_ns(), deformer.timings()))
        })?;
        let timings = dm_timings {
            size: size_of::<dm_timings>() as u32,
            measured: u32::from(frame.is_some()),
            gpu_ns: frame.as_ref().map_or(0, |f| f.gpu_ns),
            stamp_ns: frame.as_ref().map_or(0, |f| f.stamp_ns),
            record_ns,
            turns: frame.as_ref().map_or(0, |f| f.turns),
            reserved: 0,
        };
        // SAFETY: checked above.
        unsafe { pointer::put(out, timings) };
        Ok(())
    })
}

/// Reports when the passes of the last frame that is complete ran on the device, in their order; none where times are not
/// measured. Each frame times some of the passes, so that timing costs little: dm_timings.turns frames in a row have them all.
///
/// report: called once each with user, during this call and on this thread; no object is locked meanwhile, so that it may
/// call dermis. It must return: neither throw nor jump.
///
/// Threads: any. Does not wait for the device.
///
/// Returns DM_OK, DM_ERROR_NULL where report is, DM_ERROR_HANDLE or DM_ERROR_PANIC.
///
/// # Safety
/// report is NULL or a function that may be called with user.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_deformer_passes(
    deformer: dm_deformer,
    report: dm_pass_report,
    user: *mut c_void,
) -> dm_result {
    guard("dm_deformer_passes", || {
        let Some(report) = report else {
            return Err(Fault::new(dm_result::DM_ERROR_NULL, "report is NULL"));
        };
        let frame = with(deformer, |instance| Ok(instance.deformer.timings()))?;
        for pass in frame.map(|f| f.passes).unwrap_or_default() {
            let (name, label) = (c_text(&pass.name), c_text(&pass.label));
            let timing = dm_pass_timing {
                size: size_of::<dm_pass_timing>() as u32,
                steps: pass.steps,
                name: name.as_ptr(),
                label: label.as_ptr(),
                begin_ns: pass.begin_ns,
                end_ns: pass.end_ns,
            };
            // SAFETY: the caller's promise; struct and text live until it returns.
            unsafe { report(user, &timing) };
        }
        Ok(())
    })
}
