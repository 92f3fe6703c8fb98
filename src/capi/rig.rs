//! Rigs: prepared characters and their poses.

use std::{ffi::c_char, path::Path, sync::Arc};

use glam::Mat4;

use super::{
    guard::{Fault, Outcome, dm_result, guard},
    handle::{self, dm_rig},
    mesh::{self, dm_mesh_desc},
    options::{Preparation, dm_rig_options},
    pointer::{self, structs},
};
use crate::{
    asset::{self, Clip, Model},
    rig::{Pose, Rig},
};

/// Numbers of a rig.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct dm_rig_info {
    /// sizeof(dm_rig_info), set by the caller.
    pub size: u32,
    /// Rows of the output: the vertices of the file or the arrays, and those that subdivision adds.
    pub vertices: u32,
    /// Vertices that are deformed, after rows at one position are welded.
    pub welded: u32,
    /// Triangles, as rows of the output.
    pub triangles: u32,
    /// Joints; a pose has a matrix each.
    pub joints: u32,
    /// Implicit fields.
    pub fields: u32,
    /// Animation clips of the file.
    pub clips: u32,
}

structs!(dm_rig_info);

/// What a rig's handle stands for.
pub(super) struct Character {
    model: Model,
    pub(super) rig: Arc<Rig>,
}

impl Character {
    fn joints(&self) -> usize {
        self.rig.skeleton.joints.len()
    }

    pub(super) fn clip(&self, row: u32) -> Outcome<&Clip> {
        let clips = &self.model.clips;
        let reason = || format!("{row} given, the rig has {}", clips.len());
        let clip = clips.get(row as usize);
        clip.ok_or_else(|| Fault::argument("clip", reason()))
    }
}

/// Reads a rigged character from a glTF 2.0 file (.glb, .gltf) and prepares it: fits the implicit fields, once.
///
/// path: UTF-8. options: NULL for the defaults; copied. out: receives the handle, which is the caller's to destroy.
///
/// Threads: any; works on all cores, from a tenth of a second to some seconds.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_FILE where a file cannot be read or used, naming the element;
/// DM_ERROR_ARGUMENT for options that are out of range or name joints which the character has not.
///
/// # Safety
/// path is NULL or text that ends with zero; options is NULL or valid with all it points to; out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_rig_load(
    path: *const c_char,
    options: *const dm_rig_options,
    out: *mut dm_rig,
) -> dm_result {
    guard("dm_rig_load", || {
        // SAFETY: the caller's promise, here and below.
        let path = unsafe { pointer::text(path, "path")? };
        pointer::not_null(out, "out")?;
        // SAFETY: see above.
        let preparation = unsafe { Preparation::read(options)? };
        let rig = prepare(asset::load(Path::new(&path))?, preparation)?;
        // SAFETY: see above.
        unsafe { pointer::put(out, rig) };
        Ok(())
    })
}

/// Prepares a character from arrays in memory, without a file; it has no clips.
///
/// desc: all its arrays are copied. options: NULL for the defaults; copied. out: receives the handle, which is the caller's
/// to destroy.
///
/// Threads: any; works on all cores, from a tenth of a second to some seconds.
///
/// Returns DM_OK; DM_ERROR_NULL where an array is that must not be; DM_ERROR_STRUCT_SIZE; DM_ERROR_ARGUMENT naming the array
/// and the row that is not finite or out of range, the joint without inverse or before its parent, or what is wrong with the
/// options; DM_ERROR_FILE for files that the options name.
///
/// # Safety
/// desc and options are NULL or valid with all they point to, each array as long as desc says; out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_rig_create(
    desc: *const dm_mesh_desc,
    options: *const dm_rig_options,
    out: *mut dm_rig,
) -> dm_result {
    guard("dm_rig_create", || {
        pointer::not_null(desc, "desc")?;
        pointer::not_null(out, "out")?;
        // SAFETY: the caller's promise.
        unsafe {
            let preparation = Preparation::read(options)?;
            let rig = prepare(mesh::model(desc)?, preparation)?;
            pointer::put(out, rig);
        }
        Ok(())
    })
}

fn prepare(model: Model, preparation: Preparation) -> Outcome<dm_rig> {
    let rig = Arc::new(preparation.prepare(&model)?);
    handle::insert(Character { model, rig })
}

/// Destroys a rig. Deformers of it stay usable.
///
/// Threads: any. Returns DM_OK, or DM_ERROR_HANDLE where there is no such rig (any more).
#[unsafe(no_mangle)]
pub extern "C" fn dm_rig_destroy(rig: dm_rig) -> dm_result {
    guard("dm_rig_destroy", || handle::destroy(rig))
}

/// Tells the numbers of a rig.
///
/// out: size set by the caller, the rest is filled.
///
/// Threads: any. Returns DM_OK, DM_ERROR_NULL, DM_ERROR_STRUCT_SIZE or DM_ERROR_HANDLE.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_rig_get_info(rig: dm_rig, out: *mut dm_rig_info) -> dm_result {
    guard("dm_rig_get_info", || {
        // SAFETY: the caller's promise.
        unsafe { pointer::check(out, "out")? };
        let info = handle::with(rig, |c| {
            Ok(dm_rig_info {
                size: size_of::<dm_rig_info>() as u32,
                vertices: c.rig.rows.vertex.len() as u32,
                welded: c.rig.mesh.positions.len() as u32,
                triangles: c.rig.rows.triangles.len() as u32,
                joints: c.joints() as u32,
                fields: c.rig.fields.len() as u32,
                clips: c.model.clips.len() as u32,
            })
        })?;
        // SAFETY: checked above.
        unsafe { pointer::put(out, info) };
        Ok(())
    })
}

/// Finds a joint by its name.
///
/// name: UTF-8. out: receives the joint's row, that of its matrix in a pose.
///
/// Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where the rig has no such joint.
///
/// # Safety
/// name is NULL or text that ends with zero; out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_rig_joint(
    rig: dm_rig,
    name: *const c_char,
    out: *mut u32,
) -> dm_result {
    guard("dm_rig_joint", || {
        // SAFETY: the caller's promise.
        let name = unsafe { pointer::text(name, "name")? };
        pointer::not_null(out, "out")?;
        let row = handle::with(rig, |c| Ok(c.rig.skeleton.find(&name)?))?;
        // SAFETY: not NULL; the caller's promise.
        unsafe { pointer::put(out, row as u32) };
        Ok(())
    })
}

/// Tells the name of a joint, in UTF-8.
///
/// out: receives the text with its zero byte; bytes: room in it. needed: receives the bytes that the text takes; may be NULL.
/// With out NULL and bytes 0 only needed is written.
///
/// Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for a row that the rig has not;
/// DM_ERROR_SIZE where there is not enough room, with needed written.
///
/// # Safety
/// out is NULL or has room for bytes; needed is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_rig_joint_name(
    rig: dm_rig,
    joint: u32,
    out: *mut c_char,
    bytes: usize,
    needed: *mut usize,
) -> dm_result {
    guard("dm_rig_joint_name", || {
        let name = handle::with(rig, |c| match c.rig.skeleton.joints.get(joint as usize) {
            Some(joint) => Ok(super::guard::c_text(&joint.name)),
            None => Err(Fault::argument(
                "joint",
                format!("{joint} given, the rig has {}", c.joints()),
            )),
        })?;
        // SAFETY: the caller's promise.
        unsafe { pointer::blob(name.to_bytes_with_nul(), out.cast(), bytes, needed) }
    })
}

/// Copies the triangles, 3 rows of the output each.
///
/// out: array of the caller; count: numbers that it has room for, at least three times dm_rig_info.triangles.
///
/// Threads: any. Returns DM_OK, DM_ERROR_NULL, DM_ERROR_HANDLE or DM_ERROR_SIZE.
///
/// # Safety
/// out is NULL or has room for count numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_rig_indices(rig: dm_rig, out: *mut u32, count: usize) -> dm_result {
    guard("dm_rig_indices", || {
        let rig = handle::with(rig, |c| Ok(c.rig.clone()))?;
        let rows = rig.rows.triangles.as_flattened();
        // SAFETY: the caller's promise.
        unsafe { pointer::copy_out(rows, out, count, "out") }
    })
}

/// Tells the time of a clip's last key, in seconds.
///
/// clip: row of the clip, less than dm_rig_info.clips.
///
/// Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for a clip that the rig has not.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_rig_clip_seconds(rig: dm_rig, clip: u32, out: *mut f32) -> dm_result {
    guard("dm_rig_clip_seconds", || {
        pointer::not_null(out, "out")?;
        let seconds = handle::with(rig, |c| Ok(c.clip(clip)?.seconds))?;
        // SAFETY: not NULL; the caller's promise.
        unsafe { pointer::put(out, seconds) };
        Ok(())
    })
}

/// Samples a clip of the file; before its first and after its last key it holds.
///
/// seconds: time in the clip. matrices: array of the caller, 16 numbers a joint, column-major: each carries rest space to
/// model space, which is the space of the file's scene. count: matrices that it has room for, at least dm_rig_info.joints.
///
/// Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_SIZE; DM_ERROR_ARGUMENT for a clip that the rig has
/// not or a time that is not finite; DM_ERROR_POSE where the file's keys give no usable pose.
///
/// # Safety
/// matrices is NULL or has room for 16 times count numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_rig_pose_clip(
    rig: dm_rig,
    clip: u32,
    seconds: f32,
    matrices: *mut f32,
    count: usize,
) -> dm_result {
    guard("dm_rig_pose_clip", || {
        let pose = handle::with(rig, |c| {
            let skeleton = &c.rig.skeleton;
            Ok(Pose::from_clip(&c.model, skeleton, clip as usize, seconds)?)
        })?;
        // SAFETY: the caller's promise; a `Mat4` is 16 numbers.
        unsafe { pointer::copy_out(&pose.matrices, matrices.cast::<Mat4>(), count, "matrices") }
    })
}

/// Composes a pose of turns: each joint moves in its own frame, as it is bound, and carries its children.
///
/// local: 16 numbers a joint, column-major, identities for rest. matrices: array of the caller, 16 numbers a joint,
/// column-major: each carries rest space to model space, which here is rest space as well; may be the same array as local.
/// count: matrices in either, exactly dm_rig_info.joints.
///
/// Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_SIZE; DM_ERROR_POSE naming the joint whose matrix is
/// not finite, not affine or has no inverse.
///
/// # Safety
/// local is NULL or has 16 times count numbers; matrices is NULL or has room for as many.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_rig_pose_local(
    rig: dm_rig,
    local: *const f32,
    matrices: *mut f32,
    count: usize,
) -> dm_result {
    guard("dm_rig_pose_local", || {
        let rig = handle::with(rig, |c| Ok(c.rig.clone()))?;
        let joints = rig.skeleton.joints.len();
        if count != joints {
            return Err(Fault::size("count", count, joints));
        }
        pointer::not_null(matrices, "matrices")?;
        // SAFETY: the caller's promise; a `Mat4` is 16 numbers.
        unsafe {
            let local: Vec<Mat4> = pointer::array(local.cast(), joints, "local")?;
            let pose = Pose::from_local(&rig.skeleton, &local)?;
            pointer::copy_out(&pose.matrices, matrices.cast(), count, "matrices")
        }
    })
}
