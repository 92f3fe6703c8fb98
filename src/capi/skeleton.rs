//! What a host needs to know of a rig's joints and clips to make poses of its own.

use std::ffi::c_char;

use glam::Mat4;

use super::{
    guard::{Fault, Outcome, dm_result, guard},
    handle::{self, dm_rig},
    pointer::{self, structs},
};
use crate::rig::Pose;

/// A joint of a rig.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct dm_joint_info {
    /// sizeof(dm_joint_info), set by the caller.
    pub size: u32,
    /// Row of its parent, always smaller than its own; UINT32_MAX for a root.
    pub parent: u32,
    /// Bind matrix: joint space to rest space, column-major.
    pub bind: [f32; 16],
}

structs!(dm_joint_info);

/// Tells parent and bind matrix of a joint. A pose's matrix of the joint is where it is now times the inverse of this.
///
/// joint: row of the joint, less than dm_rig_info.joints. out: size set by the caller, the rest is filled.
///
/// Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for a row that the rig
/// has not.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_rig_joint_info(
    rig: dm_rig,
    joint: u32,
    out: *mut dm_joint_info,
) -> dm_result {
    guard("dm_rig_joint_info", || {
        // SAFETY: the caller's promise.
        unsafe { pointer::check(out, "out")? };
        let rig = handle::with(rig, |c| Ok(c.rig.clone()))?;
        let joints = &rig.skeleton.joints;
        let Some(found) = joints.get(joint as usize) else {
            let reason = format!("{joint} given, the rig has {}", joints.len());
            return Err(Fault::argument("joint", reason));
        };
        let info = dm_joint_info {
            size: size_of::<dm_joint_info>() as u32,
            parent: found.parent.map_or(u32::MAX, |row| row as u32),
            bind: found.bind.to_cols_array(),
        };
        // SAFETY: checked above.
        unsafe { pointer::put(out, info) };
        Ok(())
    })
}

/// Tells the name of a clip, in UTF-8.
///
/// clip: row of the clip, less than dm_rig_info.clips. out, bytes and needed: as in dm_rig_joint_name.
///
/// Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for a clip that the rig has not;
/// DM_ERROR_SIZE where there is not enough room, with needed written.
///
/// # Safety
/// out is NULL or has room for bytes; needed is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_rig_clip_name(
    rig: dm_rig,
    clip: u32,
    out: *mut c_char,
    bytes: usize,
    needed: *mut usize,
) -> dm_result {
    guard("dm_rig_clip_name", || {
        let name = handle::with(rig, |c| Ok(super::guard::c_text(&c.clip(clip)?.name)))?;
        // SAFETY: the caller's promise.
        unsafe { pointer::blob(name.to_bytes_with_nul(), out.cast(), bytes, needed) }
    })
}

/// Goes from one pose to another: every joint turns along the shortest arc in its parent's frame, its place and scale change
/// evenly.
///
/// a, b: poses as dm_deformer_advance takes them, 16 numbers a joint. t: from 0, which gives a, to 1, which gives b.
/// matrices: array of the caller, as long; may be the same array as a or b. count: matrices in each, exactly
/// dm_rig_info.joints.
///
/// Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_SIZE; DM_ERROR_POSE naming the joint whose matrix is
/// not finite, not affine or has no inverse; DM_ERROR_ARGUMENT for a t out of its range.
///
/// # Safety
/// a and b are NULL or have 16 times count numbers; matrices is NULL or has room for as many.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_rig_pose_interpolate(
    rig: dm_rig,
    a: *const f32,
    b: *const f32,
    t: f32,
    matrices: *mut f32,
    count: usize,
) -> dm_result {
    guard("dm_rig_pose_interpolate", || {
        let rig = handle::with(rig, |c| Ok(c.rig.clone()))?;
        let joints = rig.skeleton.joints.len();
        if count != joints {
            return Err(Fault::size("count", count, joints));
        }
        pointer::not_null(matrices, "matrices")?;
        // SAFETY: the caller's promise.
        let (a, b) = unsafe { (pose(a, joints, "a")?, pose(b, joints, "b")?) };
        let between = Pose::interpolate(&rig.skeleton, &a, &b, t)?;
        // SAFETY: the caller's promise; a `Mat4` is 16 numbers.
        unsafe { pointer::copy_out(&between.matrices, matrices.cast(), count, "matrices") }
    })
}

/// # Safety
/// `matrices` is NULL or has 16 times `count` numbers.
unsafe fn pose(matrices: *const f32, count: usize, name: &str) -> Outcome<Pose> {
    // SAFETY: the caller's promise; a `Mat4` is 16 numbers.
    let matrices: Vec<Mat4> = unsafe { pointer::array(matrices.cast(), count, name)? };
    Ok(Pose { matrices })
}
