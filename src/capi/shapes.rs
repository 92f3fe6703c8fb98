//! Profile curves and primitives from memory, in place of files.

use std::ffi::c_char;

use super::{
    flesh,
    guard::{Fault, Outcome},
    pointer::{self, structs},
};
use crate::{
    compose::{Form, Level, Profile},
    rig::{Primitive, SpineChain},
};

/// Form of a profile: straight segments.
pub const DM_PROFILE_POLYLINE: u32 = 0;
/// Form of a profile: a uniform cubic B-spline from the first point to the last; a point given three times is a corner.
pub const DM_PROFILE_SPLINE: u32 = 1;

/// Most points of a profile in memory.
const POINTS: usize = 1 << 20;

/// A profile curve: where the composite of two fields is 0.5, at some depths of their contact. Points are pairs of field values
/// from 0 to 1; every level has as many of them.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_profile {
    /// sizeof(dm_profile).
    pub size: u32,
    /// DM_PROFILE_POLYLINE or DM_PROFILE_SPLINE: how the points of a surface are joined.
    pub form: u32,
    /// Number of levels.
    pub levels: u32,
    /// Control points of the surface at each level.
    pub surface_points: u32,
    /// Points of the contact line at each level; 0 where nothing touches.
    pub contact_points: u32,
    /// Depth of contact of each level, ascending from 0 to 1.
    pub depths: *const f64,
    /// Surfaces, 2 numbers a point, level by level, each from (0, 0.5) to (0.5, 0).
    pub surfaces: *const f64,
    /// Contact lines, 2 numbers a point, level by level, each from the surface inward; not read without points.
    pub contacts: *const f64,
}

/// An ellipsoid that a joint carries and that swells with the bend of another, such as a muscle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_primitive {
    /// sizeof(dm_primitive).
    pub size: u32,
    /// Half its thickness in the middle, in units of the mesh.
    pub radius: f32,
    /// Unique name, in UTF-8.
    pub name: *const c_char,
    /// Name of the joint that carries it.
    pub joint: *const c_char,
    /// Name of the joint whose bend swells it: the angle of its rotation against its parent since rest.
    pub driver: *const c_char,
    /// One end of its axis, from the joint's origin along the joint's axes, in units of the mesh.
    pub start: [f32; 3],
    /// The other end.
    pub end: [f32; 3],
    /// From the first bend to the second, rising from 0 to 180 degrees, it goes from the first scale to the second.
    pub degrees: [f32; 2],
    /// Scales across its axis.
    pub scale: [f32; 2],
    /// Scale along its axis at the second bend, from 1 at the first; 0 for 1.
    pub along: f32,
}

/// A chain of joints that bends by fleshing: the skin of a tail, trunk, neck or tentacle keeps the volume of every piece, and blends
/// into the rest by its weights. It takes the place of one that the file marks at the same joint.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_spine_chain {
    /// sizeof(dm_spine_chain).
    pub size: u32,
    /// DM_MAP_RADIAL, DM_MAP_NORMAL or DM_MAP_BINORMAL.
    pub map: u32,
    /// Name of its first joint, in UTF-8.
    pub root: *const c_char,
    /// Name of its last joint, the first or a descendant.
    pub tip: *const c_char,
}

structs!(dm_profile, dm_primitive, dm_spine_chain);

/// # Safety
/// `profile` is valid with its arrays, each as long as its numbers say.
pub(super) unsafe fn profile(profile: *const dm_profile) -> Outcome<Profile> {
    // SAFETY: the caller's promise, here and below.
    let given = unsafe { pointer::read(profile, "options.profile")? };
    let form = match given.form {
        DM_PROFILE_POLYLINE => Form::Polyline,
        DM_PROFILE_SPLINE => Form::Spline,
        other => {
            let reason = format!("{other} is unknown");
            return Err(Fault::argument("options.profile.form", reason));
        }
    };
    let levels = given.levels as usize;
    // SAFETY: see above.
    let (depths, surfaces, contacts) = unsafe {
        (
            numbers(given.depths, levels, "options.profile.depths")?,
            points(given.surfaces, levels, given.surface_points, "surfaces")?,
            points(given.contacts, levels, given.contact_points, "contacts")?,
        )
    };
    let level = |(row, depth): (usize, f64)| Level {
        depth,
        surface: of_level(&surfaces, levels, row),
        contact: of_level(&contacts, levels, row),
    };
    Ok(Profile::new(
        form,
        depths.into_iter().enumerate().map(level).collect(),
    )?)
}

/// The points of one of `levels` levels.
fn of_level(points: &[[f64; 2]], levels: usize, row: usize) -> Vec<[f64; 2]> {
    let each = points.len() / levels;
    points[row * each..(row + 1) * each].to_vec()
}

/// # Safety
/// `pointer` is NULL or has as many points as the two numbers' product.
unsafe fn points(
    pointer: *const f64,
    levels: usize,
    each: u32,
    name: &str,
) -> Outcome<Vec<[f64; 2]>> {
    let name = format!("options.profile.{name}");
    // SAFETY: the caller's promise.
    unsafe { numbers(pointer.cast(), levels.saturating_mul(each as usize), &name) }
}

/// # Safety
/// `pointer` is NULL or has `count` values.
unsafe fn numbers<T: bytemuck::Pod>(
    pointer: *const T,
    count: usize,
    name: &str,
) -> Outcome<Vec<T>> {
    if count > POINTS {
        let reason = format!("{count} values; up to {POINTS} can be used");
        return Err(Fault::argument(name, reason));
    }
    if count == 0 {
        return Ok(Vec::new());
    }
    // SAFETY: the caller's promise.
    unsafe { pointer::array(pointer, count, name) }
}

/// # Safety
/// `primitive` is valid with the text that it points to.
pub(super) unsafe fn primitive(primitive: *const dm_primitive) -> Outcome<Primitive> {
    // SAFETY: the caller's promise.
    unsafe {
        let given = pointer::read(primitive, "options.primitives")?;
        Ok(Primitive {
            name: pointer::text(given.name, "options.primitives.name")?,
            joint: pointer::text(given.joint, "options.primitives.joint")?,
            start: given.start,
            end: given.end,
            radius: given.radius,
            driver: pointer::text(given.driver, "options.primitives.driver")?,
            degrees: given.degrees,
            scale: given.scale,
            along: (given.along != 0.0).then_some(given.along),
        })
    }
}

/// # Safety
/// `chain` is valid with the text that it points to.
pub(super) unsafe fn spine_chain(chain: *const dm_spine_chain) -> Outcome<SpineChain> {
    // SAFETY: the caller's promise.
    unsafe {
        let given = pointer::read(chain, "options.spines")?;
        Ok(SpineChain {
            root: pointer::text(given.root, "options.spines.root")?,
            tip: pointer::text(given.tip, "options.spines.tip")?,
            map: flesh::map(given.map, "options.spines.map")?,
        })
    }
}
