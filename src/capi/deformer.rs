//! Deformers: poses in, skin out.

use std::{ffi::c_void, sync::Arc};

use glam::{Mat4, Vec3};

use super::{
    guard::{Fault, Outcome, dm_result, guard},
    handle::{self, dm_context, dm_deformer, dm_rig},
    log::{DM_LOG_WARNING, Logger},
    pointer::{self, structs},
    settings::dm_settings,
};
use crate::{
    deformer::{Deformer, Method, Skin, TrackedState},
    rig::Pose,
};

/// Where dm_deformer_read puts a skin, a row a vertex of the output, in model space. Each array may be NULL.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_skin {
    /// sizeof(dm_skin).
    pub size: u32,
    /// Vertices that each array has room for, at least dm_rig_info.vertices.
    pub vertices: u32,
    /// Positions, 3 numbers a vertex.
    pub positions: *mut f32,
    /// Unit normals, 3 numbers a vertex.
    pub normals: *mut f32,
    /// Composed field at the vertex; 0 for geometric methods and vertices.
    pub fields: *mut f32,
    /// Iso-value of the vertex; 0 for geometric methods and vertices.
    pub isos: *mut f32,
    /// 0 untouched, 1 on its iso-value, 2 stopped in contact, 3 outside every field, 4 iteration limit or, in tracking, on its way,
    /// 5 past the limit of its spine's map.
    pub states: *mut u8,
    /// Joint of the vertex's part.
    pub bones: *mut u16,
    /// Instance to read, below dm_settings.instances.
    pub instance: u32,
    /// 0.
    pub reserved: u32,
}

structs!(dm_skin since instance);

/// What a deformer's handle stands for.
pub(super) struct Instance {
    pub(super) deformer: Deformer,
    logger: Arc<Logger>,
    /// Where it was made.
    pub(super) context: dm_context,
    /// One an instance; kept, so that a frame allocates no pose.
    pub(super) poses: Vec<Pose>,
}

/// Runs `work` on a deformer whose device is not lost, then tells what happened while nothing is locked.
pub(super) fn with<T>(
    deformer: dm_deformer,
    work: impl FnOnce(&mut Instance) -> Outcome<T>,
) -> Outcome<T> {
    let object = handle::get(deformer)?;
    let (logger, outcome) = {
        let mut instance = handle::lock(&object)?;
        let logger = instance.logger.clone();
        let outcome = logger.check().and_then(|()| work(&mut instance));
        (logger, outcome)
    };
    logger.finish(outcome)
}

/// Makes one instance of a rig in a context, or several (dm_settings.instances), at rest: uploads it and samples its fields on the device.
///
/// settings: NULL for the defaults; copied. out: receives the handle, which is the caller's to destroy. The deformer keeps
/// what it needs of context and rig, which may be destroyed before it. What was mended in the character is told to the
/// context's log.
///
/// Threads: any; other calls on the context wait meanwhile. Takes from milliseconds to a second, and waits for the device.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT naming the setting that is out of
/// range, or where the rig has what the method cannot do; DM_ERROR_MEMORY where the budget or the device is too small;
/// DM_ERROR_VULKAN; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.
///
/// # Safety
/// settings and out are NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_deformer_create(
    context: dm_context,
    rig: dm_rig,
    settings: *const dm_settings,
    out: *mut dm_deformer,
) -> dm_result {
    guard("dm_deformer_create", || {
        pointer::not_null(out, "out")?;
        // SAFETY: the caller's promise.
        let settings = unsafe { dm_settings::read(settings)? };
        let rig = handle::with(rig, |character| Ok(character.rig.clone()))?;
        let (deformer, logger) = super::context::with(context, |context| {
            let deformer = Deformer::new(&context.device, rig.clone(), &settings)?;
            Ok((deformer, context.logger.clone()))
        })?;
        for warning in &rig.warnings {
            logger.tell(DM_LOG_WARNING, warning);
        }
        let handle = handle::insert(Instance {
            deformer,
            logger,
            context,
            poses: vec![Pose::rest(&rig.skeleton); settings.instances as usize],
        })?;
        // SAFETY: not NULL; the caller's promise.
        unsafe { pointer::put(out, handle) };
        Ok(())
    })
}

/// Destroys a deformer.
///
/// Threads: any; a call that uses it on another thread completes first. Does not wait for the device: memory goes when the
/// device is done with it.
///
/// Returns DM_OK, or DM_ERROR_HANDLE where there is no such deformer (any more).
#[unsafe(no_mangle)]
pub extern "C" fn dm_deformer_destroy(deformer: dm_deformer) -> dm_result {
    guard("dm_deformer_destroy", || handle::destroy(deformer))
}

/// Deforms all instances, each for its pose. Submits to the context's queue and does not wait, unless two frames are on their way already; on the
/// CPU it computes.
///
/// matrices: 16 numbers a joint, column-major: each carries rest space to model space, identities for rest; copied. The joints
/// of the first instance, then those of the second.
/// count: matrices, exactly dm_rig_info.joints times dm_settings.instances.
///
/// Threads: any.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_SIZE; DM_ERROR_POSE naming the joint whose matrix is not finite,
/// not affine or has no inverse; DM_ERROR_VULKAN; DM_ERROR_MEMORY; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC. Where it is not DM_OK
/// all skins are as they were.
///
/// # Safety
/// matrices is NULL or has 16 times count numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_deformer_advance(
    deformer: dm_deformer,
    matrices: *const f32,
    count: usize,
) -> dm_result {
    guard("dm_deformer_advance", || {
        with(deformer, |instance| {
            // SAFETY: the caller's promise.
            unsafe { instance.set_poses(matrices, count)? };
            Ok(instance.deformer.advance(&instance.poses)?)
        })
    })
}

/// Waits until the last pose is deformed.
///
/// Threads: any.
///
/// Returns DM_OK, DM_ERROR_HANDLE, DM_ERROR_VULKAN, DM_ERROR_DEVICE_LOST or DM_ERROR_PANIC.
#[unsafe(no_mangle)]
pub extern "C" fn dm_deformer_wait(deformer: dm_deformer) -> dm_result {
    guard("dm_deformer_wait", || {
        with(deformer, |instance| Ok(instance.deformer.wait()?))
    })
}

/// Reads the last skin of an instance; waits for it. Before the first pose its content is undefined.
///
/// skin: where to put it; the arrays are the caller's.
///
/// Threads: any.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_SIZE; DM_ERROR_ARGUMENT for an instance that
/// does not exist; DM_ERROR_VULKAN; DM_ERROR_MEMORY; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.
///
/// # Safety
/// skin is NULL or valid, and each array in it is NULL or has room for as many vertices as it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_deformer_read(
    deformer: dm_deformer,
    skin: *const dm_skin,
) -> dm_result {
    guard("dm_deformer_read", || {
        // SAFETY: the caller's promise.
        let out = unsafe { pointer::read(skin, "skin")? };
        with(deformer, |instance| {
            let (room, rows) = (out.vertices as usize, instance.rows());
            if room < rows {
                return Err(Fault::size("skin.vertices", room, rows));
            }
            if out.reserved != 0 {
                return Err(Fault::argument("skin.reserved", "it has to be 0"));
            }
            let skin = instance.deformer.instance(out.instance)?.read()?;
            // SAFETY: the caller's promise.
            unsafe { write(&skin, &out) }
        })
    })
}

impl Instance {
    /// Copies the poses of all instances in.
    ///
    /// # Safety
    /// `matrices` is NULL or has 16 times `count` numbers.
    pub(super) unsafe fn set_poses(&mut self, matrices: *const f32, count: usize) -> Outcome {
        let wanted = self.poses.iter().map(|pose| pose.matrices.len()).sum();
        if count != wanted {
            return Err(Fault::size("count", count, wanted));
        }
        pointer::not_null(matrices, "matrices")?;
        let mut at = matrices.cast::<Mat4>();
        for pose in &mut self.poses {
            let rows = &mut pose.matrices;
            // SAFETY: the caller's promise; a `Mat4` is 16 numbers, and all poses together have `count` of them.
            unsafe {
                pointer::copy_in(at, rows, "matrices")?;
                at = at.add(rows.len());
            }
        }
        Ok(())
    }

    pub(super) fn rows(&self) -> usize {
        self.deformer.rig().rows.vertex.len()
    }
}

/// # Safety
/// Each array is NULL or has room for as many vertices as `out` says.
unsafe fn write(skin: &Skin, out: &dm_skin) -> Outcome {
    // SAFETY: the caller's promise; a `Vec3` is three numbers.
    unsafe {
        let (positions, normals) = (out.positions.cast::<Vec3>(), out.normals.cast::<Vec3>());
        column(&skin.positions, positions, out, "skin.positions")?;
        column(&skin.normals, normals, out, "skin.normals")?;
        column(&skin.field, out.fields, out, "skin.fields")?;
        column(&skin.iso, out.isos, out, "skin.isos")?;
        column(&skin.state, out.states, out, "skin.states")?;
        column(&skin.bone, out.bones, out, "skin.bones")
    }
}

/// # Safety
/// As [`write`].
unsafe fn column<T: bytemuck::NoUninit>(
    rows: &[T],
    pointer: *mut T,
    out: &dm_skin,
    name: &str,
) -> Outcome {
    if pointer.is_null() {
        return Ok(());
    }
    // SAFETY: the caller's promise.
    unsafe { pointer::copy_out(rows, pointer, out.vertices as usize, name) }
}

/// Forgets the tracked skins of all instances: the next poses are reached from rest, whatever came before. For cuts. Does nothing
/// for methods other than tracking, which have no such state.
///
/// Threads: any. Waits for the device.
///
/// Returns DM_OK, DM_ERROR_HANDLE, DM_ERROR_VULKAN, DM_ERROR_MEMORY, DM_ERROR_DEVICE_LOST or DM_ERROR_PANIC. Where Vulkan or
/// memory failed there is no state any more: poses are refused by DM_ERROR_ARGUMENT until this or dm_deformer_restore succeeds.
#[unsafe(no_mangle)]
pub extern "C" fn dm_deformer_reset(deformer: dm_deformer) -> dm_result {
    guard("dm_deformer_reset", || {
        with(deformer, |instance| Ok(instance.deformer.reset()?))
    })
}

/// The same for one instance.
///
/// instance: below dm_settings.instances.
///
/// Threads: any. Waits for the device.
///
/// Returns DM_OK, DM_ERROR_HANDLE, DM_ERROR_ARGUMENT for an instance that does not exist, DM_ERROR_VULKAN, DM_ERROR_DEVICE_LOST
/// or DM_ERROR_PANIC.
#[unsafe(no_mangle)]
pub extern "C" fn dm_deformer_reset_instance(deformer: dm_deformer, instance: u32) -> dm_result {
    guard("dm_deformer_reset_instance", || {
        with(deformer, |it| {
            Ok(it.deformer.instance(instance)?.reset()?)
        })
    })
}

/// Saves the state that the next frame of the first instance goes on from, as bytes for dm_deformer_restore of the same rig and
/// settings, by this version of the library on this kind of machine. 0 bytes for methods other than tracking.
///
/// out: buffer of the caller; bytes: room in it. needed: receives the bytes of the state; may be NULL.
/// With out NULL and bytes 0 only needed is written. The number grows once, with the first pose.
///
/// Threads: any. Waits for the device.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_SIZE where there is not enough room, with needed written;
/// DM_ERROR_VULKAN; DM_ERROR_MEMORY; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.
///
/// # Safety
/// out is NULL or has room for bytes; needed is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_deformer_save(
    deformer: dm_deformer,
    out: *mut c_void,
    bytes: usize,
    needed: *mut usize,
) -> dm_result {
    guard("dm_deformer_save", || {
        // SAFETY: the caller's promise.
        unsafe { save(deformer, 0, out, bytes, needed) }
    })
}

/// The same for any instance.
///
/// instance: below dm_settings.instances. out, bytes, needed: as in dm_deformer_save.
///
/// Threads: any. Waits for the device.
///
/// Returns what dm_deformer_save does; DM_ERROR_ARGUMENT for an instance that does not exist.
///
/// # Safety
/// As in dm_deformer_save.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_deformer_save_instance(
    deformer: dm_deformer,
    instance: u32,
    out: *mut c_void,
    bytes: usize,
    needed: *mut usize,
) -> dm_result {
    guard("dm_deformer_save_instance", || {
        // SAFETY: the caller's promise.
        unsafe { save(deformer, instance, out, bytes, needed) }
    })
}

/// # Safety
/// `out` is NULL or has room for `bytes`; `needed` is NULL or valid.
unsafe fn save(
    deformer: dm_deformer,
    instance: u32,
    out: *mut c_void,
    bytes: usize,
    needed: *mut usize,
) -> Outcome {
    with(deformer, |it| {
        let state = it.deformer.instance(instance)?.save()?;
        let state = state.map(|s| s.to_bytes()).unwrap_or_default();
        // SAFETY: the caller's promise.
        unsafe { pointer::blob(&state, out.cast(), bytes, needed) }
    })
}

/// Lets the first instance go on from a saved state.
///
/// state: what dm_deformer_save wrote; copied. bytes: its length; 0, with state NULL or not, for methods that have no state.
///
/// Threads: any. Waits for the device.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where the bytes are no state, or one of another
/// character, or the method has none; DM_ERROR_VULKAN; DM_ERROR_MEMORY; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC. Where Vulkan or
/// memory failed there is no state any more, as after dm_deformer_reset.
///
/// # Safety
/// state is NULL or has bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_deformer_restore(
    deformer: dm_deformer,
    state: *const c_void,
    bytes: usize,
) -> dm_result {
    guard("dm_deformer_restore", || {
        // SAFETY: the caller's promise.
        unsafe { restore(deformer, 0, state, bytes) }
    })
}

/// The same for any instance, from a state of any.
///
/// instance: below dm_settings.instances. state, bytes: as in dm_deformer_restore.
///
/// Threads: any. Waits for the device.
///
/// Returns what dm_deformer_restore does; DM_ERROR_ARGUMENT for an instance that does not exist.
///
/// # Safety
/// As in dm_deformer_restore.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_deformer_restore_instance(
    deformer: dm_deformer,
    instance: u32,
    state: *const c_void,
    bytes: usize,
) -> dm_result {
    guard("dm_deformer_restore_instance", || {
        // SAFETY: the caller's promise.
        unsafe { restore(deformer, instance, state, bytes) }
    })
}

/// # Safety
/// `state` is NULL or has `bytes`.
unsafe fn restore(
    deformer: dm_deformer,
    instance: u32,
    state: *const c_void,
    bytes: usize,
) -> Outcome {
    with(deformer, |it| {
        let has_state = it.deformer.settings().method == Method::Tracking;
        let mut instance = it.deformer.instance(instance)?;
        if bytes == 0 && !has_state {
            return Ok(());
        }
        pointer::not_null(state, "state")?;
        if bytes > isize::MAX as usize {
            return Err(Fault::argument("bytes", format!("{bytes} is too much")));
        }
        // SAFETY: not NULL; the caller's promise.
        let state = unsafe { std::slice::from_raw_parts(state.cast::<u8>(), bytes) };
        let state = TrackedState::from_bytes(state)?;
        Ok(instance.restore(&state)?)
    })
}
