//! Spines of fleshing.

use std::{ffi::c_char, path::Path, sync::Arc};

use glam::DVec3;

use super::{
    guard::{Fault, Outcome, dm_result, guard},
    handle::{self, dm_spine},
    pointer::{self, structs},
};
use crate::flesh::{Curve, Round, Spine, SpineDesc, Twist};

/// Kind of a spine: the polynomial through 2 to 16 points.
pub const DM_SPINE_POLYNOMIAL: u32 = 0;
/// Kind of a spine: the quintic B-spline through its points; a last point that repeats the first closes it.
pub const DM_SPINE_BSPLINE: u32 = 1;
/// Kind of a spine: a smooth curve through densely given points; a last point that repeats the first closes it.
pub const DM_SPINE_POLYLINE: u32 = 2;
/// Kind of a spine: a circular arc; a full circle is closed.
pub const DM_SPINE_ARC: u32 = 3;
/// Kind of a spine: a helix.
pub const DM_SPINE_HELIX: u32 = 4;

/// Most points of a spine and of its profile of twist.
const POINTS: usize = 100_000;

/// What a spine is made of. Zeros are the defaults of all that a kind does not ask for.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_spine_desc {
    /// sizeof(dm_spine_desc).
    pub size: u32,
    /// DM_SPINE_POLYNOMIAL, DM_SPINE_BSPLINE, DM_SPINE_POLYLINE, DM_SPINE_ARC or DM_SPINE_HELIX.
    pub kind: u32,
    /// Number of points, of the first three kinds.
    pub point_count: u32,
    /// Number of pairs in twist_profile.
    pub profile_count: u32,
    /// 3 numbers a point; not read of arcs and helices.
    pub points: *const f64,
    /// First point of an arc or helix.
    pub start: [f64; 3],
    /// Direction there.
    pub tangent: [f64; 3],
    /// From there to the centre or the axis; what it has along the tangent is left out.
    pub normal: [f64; 3],
    /// Distance to the centre or the axis.
    pub radius: f64,
    /// Length along an arc or helix.
    pub length: f64,
    /// Rise of a turn of a helix along its axis; right-handed above 0.
    pub pitch: f64,
    /// Where the first frame vector points at the start, as far as it is across the spine; zeros: as at the rest spine, turned the
    /// shortest way, or without one +z, or +y where the spine starts along z.
    pub up: [f64; 3],
    /// Turn of the frame about the spine, degrees.
    pub twist_degrees: f64,
    /// More of it along the spine: pairs of a rising share of the length, 0 to 1, and degrees; not read without.
    pub twist_profile: *const f64,
    /// How far past either end curvature takes to ease to zero, as a share of the length, up to 1/8, which 0 stands for; below 0
    /// the spine is straight from its ends on.
    pub ease: f64,
}

/// Numbers of a spine.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct dm_spine_info {
    /// sizeof(dm_spine_info), set by the caller.
    pub size: u32,
    /// 1 where the end is the start.
    pub closed: u32,
    /// Arc length.
    pub length: f64,
}

/// A spine at one arc length.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct dm_spine_section {
    /// sizeof(dm_spine_section), set by the caller.
    pub size: u32,
    /// Zero.
    pub reserved: u32,
    /// Point on the curve.
    pub position: [f64; 3],
    /// Unit tangent.
    pub tangent: [f64; 3],
    /// First frame vector, across the tangent.
    pub side: [f64; 3],
    /// Second frame vector, tangent × side.
    pub lift: [f64; 3],
    /// Curvature vector, to the centre of curvature, along side and lift.
    pub curvature: [f64; 2],
}

structs!(dm_spine_desc, dm_spine_info, dm_spine_section);

/// What a spine's handle stands for; shared, so that bends of several meshes do not wait for each other.
pub(super) type SharedSpine = Arc<Spine>;

/// Prepares a spine.
///
/// desc: copied with its arrays. rest: the spine that this one is a bend of, from which it takes its frame where desc has no up;
/// zero for none. out: receives the handle, which is the caller's to destroy.
///
/// Threads: any; takes up to some milliseconds.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT naming what is not finite, has no length
/// or no direction, or is out of range.
///
/// # Safety
/// desc is NULL or valid with its arrays, each as long as its numbers say; out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_spine_create(
    desc: *const dm_spine_desc,
    rest: dm_spine,
    out: *mut dm_spine,
) -> dm_result {
    guard("dm_spine_create", || {
        // SAFETY: the caller's promise, here and below.
        let desc = unsafe { read(desc)? };
        pointer::not_null(out, "out")?;
        let spine = match optional(rest)? {
            Some(rest) => Spine::like(&desc, &rest)?,
            None => Spine::new(&desc)?,
        };
        let handle: dm_spine = handle::insert(Arc::new(spine))?;
        // SAFETY: see above.
        unsafe { pointer::put(out, handle) };
        Ok(())
    })
}

/// Reads a spine from a JSON file, as `dermis flesh` does, and prepares it.
///
/// path: UTF-8. rest: as for dm_spine_create. out: receives the handle, which is the caller's to destroy.
///
/// Threads: any; takes up to some milliseconds.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where path is not UTF-8; DM_ERROR_FILE naming the file and the
/// key that is unknown, missing or wrong.
///
/// # Safety
/// path is NULL or text that ends with zero; out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_spine_load(
    path: *const c_char,
    rest: dm_spine,
    out: *mut dm_spine,
) -> dm_result {
    guard("dm_spine_load", || {
        // SAFETY: the caller's promise, here and below.
        let path = unsafe { pointer::text(path, "path")? };
        pointer::not_null(out, "out")?;
        let rest = optional(rest)?;
        let spine = Spine::read(Path::new(&path), rest.as_deref())?;
        let handle: dm_spine = handle::insert(Arc::new(spine))?;
        // SAFETY: see above.
        unsafe { pointer::put(out, handle) };
        Ok(())
    })
}

/// Destroys a spine. What was registered on it stays usable.
///
/// Threads: any. Returns DM_OK, or DM_ERROR_HANDLE where there is no such spine (any more).
#[unsafe(no_mangle)]
pub extern "C" fn dm_spine_destroy(spine: dm_spine) -> dm_result {
    guard("dm_spine_destroy", || handle::destroy(spine))
}

/// Tells the numbers of a spine.
///
/// out: size set by the caller, the rest is filled.
///
/// Threads: any. Returns DM_OK, DM_ERROR_NULL, DM_ERROR_STRUCT_SIZE or DM_ERROR_HANDLE.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_spine_get_info(spine: dm_spine, out: *mut dm_spine_info) -> dm_result {
    guard("dm_spine_get_info", || {
        // SAFETY: the caller's promise.
        unsafe { pointer::check(out, "out")? };
        let spine = shared(spine)?;
        let info = dm_spine_info {
            size: size_of::<dm_spine_info>() as u32,
            closed: spine.closed().into(),
            length: spine.length(),
        };
        // SAFETY: checked above.
        unsafe { pointer::put(out, info) };
        Ok(())
    })
}

/// Tells point, frame and curvature of a spine at an arc length, which may lie past its ends.
///
/// out: size set by the caller, the rest is filled.
///
/// Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where the arc length is not
/// finite.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_spine_at(
    spine: dm_spine,
    arc_length: f64,
    out: *mut dm_spine_section,
) -> dm_result {
    guard("dm_spine_at", || {
        // SAFETY: the caller's promise.
        unsafe { pointer::check(out, "out")? };
        let spine = shared(spine)?;
        if !arc_length.is_finite() {
            return Err(Fault::argument("arc_length", "is not finite"));
        }
        let section = spine.section(arc_length);
        let section = dm_spine_section {
            size: size_of::<dm_spine_section>() as u32,
            reserved: 0,
            position: section.position.to_array(),
            tangent: section.tangent.to_array(),
            side: section.side.to_array(),
            lift: section.lift.to_array(),
            curvature: section.curvature.to_array(),
        };
        // SAFETY: checked above.
        unsafe { pointer::put(out, section) };
        Ok(())
    })
}

/// The spine of a handle.
pub(super) fn shared(spine: dm_spine) -> Outcome<SharedSpine> {
    handle::with(spine, |spine| Ok(Arc::clone(spine)))
}

fn optional(spine: dm_spine) -> Outcome<Option<SharedSpine>> {
    match spine.id {
        0 => Ok(None),
        _ => shared(spine).map(Some),
    }
}

/// # Safety
/// `desc` is NULL or valid, and so are its arrays, each as long as its numbers say.
unsafe fn read(desc: *const dm_spine_desc) -> Outcome<SpineDesc> {
    // SAFETY: the caller's promise, here and below.
    let desc = unsafe { pointer::read(desc, "desc")? };
    let points = || -> Outcome<Vec<DVec3>> {
        // SAFETY: see above.
        let rows = unsafe { rows::<3>(desc.points, desc.point_count, "desc.points")? };
        Ok(rows.into_iter().map(DVec3::from_array).collect())
    };
    let round = Round {
        start: DVec3::from_array(desc.start),
        tangent: DVec3::from_array(desc.tangent),
        normal: DVec3::from_array(desc.normal),
        radius: desc.radius,
        length: desc.length,
    };
    let curve = match desc.kind {
        DM_SPINE_POLYNOMIAL => Curve::Polynomial(points()?),
        DM_SPINE_BSPLINE => Curve::BSpline(points()?),
        DM_SPINE_POLYLINE => Curve::Polyline(points()?),
        DM_SPINE_ARC => Curve::Arc(round),
        DM_SPINE_HELIX => Curve::Helix {
            round,
            pitch: desc.pitch,
        },
        other => {
            let reason = format!("{other} is unknown");
            return Err(Fault::argument("desc.kind", reason));
        }
    };
    let mut out = SpineDesc::new(curve);
    if desc.up != [0.0; 3] {
        out.up = Some(DVec3::from_array(desc.up));
    }
    if desc.ease != 0.0 {
        // What is no number is refused with what is too large.
        out.ease = if desc.ease < 0.0 { 0.0 } else { desc.ease };
    }
    out.twist = Twist {
        degrees: desc.twist_degrees,
        profile: match desc.profile_count {
            0 => Vec::new(),
            // SAFETY: see above.
            count => unsafe { rows::<2>(desc.twist_profile, count, "desc.twist_profile")? },
        },
    };
    Ok(out)
}

/// # Safety
/// `pointer` is NULL or has `N` numbers a row.
unsafe fn rows<const N: usize>(
    pointer: *const f64,
    count: u32,
    name: &str,
) -> Outcome<Vec<[f64; N]>>
where
    [f64; N]: bytemuck::Pod,
{
    if count as usize > POINTS {
        let reason = format!("{count} rows; up to {POINTS} can be used");
        return Err(Fault::argument(name, reason));
    }
    // SAFETY: the caller's promise.
    unsafe { pointer::array(pointer.cast(), count as usize, name) }
}
