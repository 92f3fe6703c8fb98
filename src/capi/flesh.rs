//! Meshes registered on a spine, and bent with it.

use glam::{DVec3, Vec3};

use super::{
    guard::{Fault, Outcome, dm_result, guard},
    handle::{self, dm_flesh, dm_spine},
    pointer::{self, structs},
    spine,
};
use crate::{
    asset::ROW_LIMIT,
    flesh::{self, BendOptions, Bent, Map, Registration},
};

/// Map of fleshing: flesh gives way from and to the spine.
pub const DM_MAP_RADIAL: u32 = 0;
/// Map of fleshing: flesh gives way in the plane of the bend.
pub const DM_MAP_NORMAL: u32 = 1;
/// Map of fleshing: flesh gives way across the plane of the bend.
pub const DM_MAP_BINORMAL: u32 = 2;

/// Flag of a vertex: it is past the limit of the map at the rest spine.
pub const DM_FLESH_PAST_REST_LIMIT: u32 = flesh::PAST_REST_LIMIT;
/// Flag of a vertex: it is past the limit of the map at the bent spine.
pub const DM_FLESH_PAST_BENT_LIMIT: u32 = flesh::PAST_BENT_LIMIT;
/// Flag of a vertex: another part of the rest spine is as near within a hundredth.
pub const DM_FLESH_AMBIGUOUS: u32 = flesh::AMBIGUOUS;
/// Flag of a vertex: it is beyond an end of the rest spine. Nothing is wrong with it.
pub const DM_FLESH_PAST_END: u32 = flesh::PAST_END;

/// Points to be registered on a spine.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_flesh_desc {
    /// sizeof(dm_flesh_desc).
    pub size: u32,
    /// DM_MAP_RADIAL, DM_MAP_NORMAL or DM_MAP_BINORMAL.
    pub map: u32,
    /// Number of vertices.
    pub vertices: u32,
    /// Zero.
    pub reserved: u32,
    /// 3 numbers a vertex.
    pub positions: *const f32,
    /// 3 numbers a vertex, of any length; NULL where normals are not wanted.
    pub normals: *const f32,
}

/// How registered vertices follow a bent spine.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_flesh_options {
    /// sizeof(dm_flesh_options).
    pub size: u32,
    /// Not 0: the rest spine's length is fitted to the bent one's; 0: arc length is kept.
    pub stretch: u32,
    /// From 0, plain skinning, to 1.
    pub strength: f64,
    /// From 0, starts aligned, to 1, ends aligned.
    pub slide: f64,
}

/// Arrays that bent vertices are written to; those that are NULL are left out.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_bent {
    /// sizeof(dm_bent).
    pub size: u32,
    /// Rows that each array has, as many as were registered.
    pub vertices: u32,
    /// 3 numbers a vertex.
    pub positions: *mut f32,
    /// 3 numbers a vertex, unit; NULL where no normals were registered.
    pub normals: *mut f32,
    /// Distance to the nearest limit of the map, in units of the mesh: negative past it, infinite where both spines are straight.
    pub distances: *mut f32,
    /// DM_FLESH_… a vertex.
    pub flags: *mut u32,
}

structs!(dm_flesh_desc, dm_flesh_options, dm_bent);

/// What the handle of registered vertices stands for, with room for a result that is used again.
pub(super) struct Fleshed {
    registration: Registration,
    room: Bent,
}

/// Registers vertices on a rest spine, once for all ways to bend it.
///
/// desc: copied with its arrays. out: receives the handle, which is the caller's to destroy.
///
/// Threads: any; works on all cores.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT naming the row that is not finite, or
/// the member that is out of range.
///
/// # Safety
/// desc is NULL or valid with its arrays, each as long as it says; out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_flesh_create(
    rest: dm_spine,
    desc: *const dm_flesh_desc,
    out: *mut dm_flesh,
) -> dm_result {
    guard("dm_flesh_create", || {
        // SAFETY: the caller's promise, here and below.
        let desc = unsafe { pointer::read(desc, "desc")? };
        pointer::not_null(out, "out")?;
        let count = desc.vertices as usize;
        if !(1..=ROW_LIMIT).contains(&count) {
            let reason = format!("{count} is not in 1 to {ROW_LIMIT}");
            return Err(Fault::argument("desc.vertices", reason));
        }
        let map = map(desc.map, "desc.map")?;
        // SAFETY: see above.
        let (positions, normals) = unsafe {
            let normals = match desc.normals.is_null() {
                true => Vec::new(),
                false => vectors(desc.normals, count, "desc.normals")?,
            };
            (vectors(desc.positions, count, "desc.positions")?, normals)
        };
        let rest = spine::shared(rest)?;
        let registration = flesh::register(&rest, map, &positions, &normals)?;
        let handle: dm_flesh = handle::insert(Fleshed {
            registration,
            room: Bent::default(),
        })?;
        // SAFETY: see above.
        unsafe { pointer::put(out, handle) };
        Ok(())
    })
}

/// Destroys registered vertices.
///
/// Threads: any. Returns DM_OK, or DM_ERROR_HANDLE where there are no such (any more).
#[unsafe(no_mangle)]
pub extern "C" fn dm_flesh_destroy(flesh: dm_flesh) -> dm_result {
    guard("dm_flesh_destroy", || handle::destroy(flesh))
}

/// Bends registered vertices to another spine.
///
/// options: NULL for full strength, no slide and no stretch. out: its arrays are filled.
///
/// Threads: any; works on all cores. Allocates at the first call only.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_SIZE where out has another number of rows;
/// DM_ERROR_ARGUMENT for options out of range, normals where none were registered, or closed spines that do not fit.
///
/// # Safety
/// options is NULL or valid; out is NULL or valid, and each of its arrays is NULL or has as many rows as it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_flesh_bend(
    flesh: dm_flesh,
    bent: dm_spine,
    options: *const dm_flesh_options,
    out: *const dm_bent,
) -> dm_result {
    guard("dm_flesh_bend", || {
        // SAFETY: the caller's promise, here and below.
        let out = unsafe { pointer::read(out, "out")? };
        let options = match options.is_null() {
            true => BendOptions::default(),
            // SAFETY: see above.
            false => read(&unsafe { pointer::read(options, "options")? }),
        };
        handle::with(flesh, |flesh| {
            let spine = spine::shared(bent)?;
            let (registration, room) = (&flesh.registration, &mut flesh.room);
            let count = registration.anchors.len();
            if out.vertices as usize != count {
                return Err(Fault::size("out.vertices", out.vertices as usize, count));
            }
            if !out.normals.is_null() && registration.tilts.is_empty() {
                return Err(Fault::argument("out.normals", "no normals were registered"));
            }
            flesh::bend_again(registration, &spine, &options, room)?;
            // SAFETY: as many rows as were registered, by the caller's promise.
            unsafe { write(room, &out) };
            Ok(())
        })
    })
}

/// The map of this number.
pub(super) fn map(map: u32, name: &str) -> Outcome<Map> {
    match map {
        DM_MAP_RADIAL => Ok(Map::Radial),
        DM_MAP_NORMAL => Ok(Map::Normal),
        DM_MAP_BINORMAL => Ok(Map::Binormal),
        other => Err(Fault::argument(name, format!("{other} is unknown"))),
    }
}

fn read(options: &dm_flesh_options) -> BendOptions {
    BendOptions {
        strength: options.strength,
        slide: options.slide,
        stretch: options.stretch != 0,
    }
}

/// # Safety
/// `pointer` is NULL or has three numbers a row.
unsafe fn vectors(pointer: *const f32, rows: usize, name: &str) -> Outcome<Vec<DVec3>> {
    // SAFETY: the caller's promise; a `Vec3` is three numbers.
    let rows: Vec<Vec3> = unsafe { pointer::array(pointer.cast(), rows, name)? };
    Ok(rows.iter().map(|v| v.as_dvec3()).collect())
}

/// # Safety
/// Each array of `out` is NULL or has as many rows as `bent`.
unsafe fn write(bent: &Bent, out: &dm_bent) {
    let vectors = |rows: &[DVec3], to: *mut f32| {
        for (row, vector) in rows.iter().enumerate() {
            // SAFETY: the caller's promise.
            unsafe { pointer::put(to.cast::<[f32; 3]>().add(row), vector.as_vec3().to_array()) };
        }
    };
    if !out.positions.is_null() {
        vectors(&bent.positions, out.positions);
    }
    if !out.normals.is_null() {
        vectors(&bent.normals, out.normals);
    }
    for row in 0..bent.flags.len() {
        // SAFETY: the caller's promise.
        unsafe {
            if !out.distances.is_null() {
                pointer::put(out.distances.add(row), bent.distances[row] as f32);
            }
            if !out.flags.is_null() {
                pointer::put(out.flags.add(row), bent.flags[row]);
            }
        }
    }
}
