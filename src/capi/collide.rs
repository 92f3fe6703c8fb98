//! Moving spheres against a level of a sphere-mesh.

use std::sync::Arc;

use super::{
    guard::{Fault, dm_result, guard},
    handle::{self, dm_collider, dm_level},
    levels,
    pointer::{self, structs},
};
use crate::{
    asset::ROW_LIMIT,
    sphere_mesh::{Collider, Hit, Sweep},
};

/// What became of a moving sphere: it touches nothing.
pub const DM_HIT_NONE: u32 = 0;
/// What became of a moving sphere: it touches.
pub const DM_HIT_TOUCHED: u32 = 1;
/// What became of a moving sphere: it began inside, and is pushed out.
pub const DM_HIT_PUSHED: u32 = 2;

/// Spheres that move along segments, in the units of the sphere-mesh, and where they first touch.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_sweeps {
    /// sizeof(dm_sweeps).
    pub size: u32,
    /// Number of spheres.
    pub count: u32,
    /// 7 numbers a sphere: where its centre begins, where it ends, and its radius, 0 or more.
    pub segments: *const f64,
    /// 7 numbers a sphere: the time of the first touch, 0 at the beginning of the segment to 1 at its end; where its centre is then;
    /// the outward unit normal of the sphere-mesh where they touch. Without a touch: infinity, the end of the segment, zeros.
    pub hits: *mut f64,
    /// DM_HIT_NONE, DM_HIT_TOUCHED or DM_HIT_PUSHED of each; may be NULL.
    pub states: *mut u32,
}

structs!(dm_sweeps);

/// Prepares a level at a time for collisions with its spheres, capsules and thick triangles.
///
/// time: in frames, as dm_spheres.time. out: receives the handle, which is the caller's to destroy.
///
/// Threads: any.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where the time is not finite.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_collider_create(
    level: dm_level,
    time: f64,
    out: *mut dm_collider,
) -> dm_result {
    guard("dm_collider_create", || {
        pointer::not_null(out, "out")?;
        let shape = levels::opened(level)?.at(time)?;
        let handle: dm_collider = handle::insert(Arc::new(Collider::new(&shape)?))?;
        // SAFETY: not NULL; the caller's promise.
        unsafe { pointer::put(out, handle) };
        Ok(())
    })
}

/// Destroys a collider.
///
/// Threads: any. Returns DM_OK, or DM_ERROR_HANDLE where there is no such collider (any more).
#[unsafe(no_mangle)]
pub extern "C" fn dm_collider_destroy(collider: dm_collider) -> dm_result {
    guard("dm_collider_destroy", || handle::destroy(collider))
}

/// Tells where moving spheres first touch, in closed form and double precision: nothing tunnels through, however fast.
///
/// One that begins inside is pushed out along the normal of a primitive that holds it, at time 0. One that begins on the surface
/// touches at time 0 if it moves inwards, and is free if it moves outwards: what has bounced goes on.
///
/// sweeps: its arrays hits and states are filled.
///
/// Threads: any; works on all cores.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT naming the row that is not finite, is beyond
/// 1e60 or has a negative radius, or for too many of them.
///
/// # Safety
/// sweeps is NULL or valid, and each of its arrays is NULL or has as many rows as it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_collider_sweep(
    collider: dm_collider,
    sweeps: *const dm_sweeps,
) -> dm_result {
    guard("dm_collider_sweep", || {
        // SAFETY: the caller's promise, here and below.
        let given = unsafe { pointer::read(sweeps, "sweeps")? };
        let count = given.count as usize;
        if count > ROW_LIMIT {
            let reason = format!("{count}, more than {ROW_LIMIT}");
            return Err(Fault::argument("sweeps.count", reason));
        }
        pointer::not_null(given.hits, "sweeps.hits")?;
        // SAFETY: see above.
        let rows: Vec<[f64; 7]> =
            unsafe { pointer::array(given.segments.cast(), count, "sweeps.segments")? };
        let sweeps: Vec<Sweep> = rows.iter().map(Sweep::of_row).collect();
        // Shared, so that batches on several threads do not wait for each other.
        let collider = handle::with(collider, |collider| Ok(Arc::clone(collider)))?;
        let found = collider.first_of_each(&sweeps)?;
        let pairs = sweeps.iter().zip(&found);
        let hits: Vec<[f64; 7]> = pairs
            .map(|(sweep, hit)| sweep.row_of(hit.as_ref()))
            .collect();
        // SAFETY: see above.
        unsafe { pointer::copy_out(&hits, given.hits.cast(), count, "sweeps.hits")? };
        let state = |hit: &Option<Hit>| match hit {
            None => DM_HIT_NONE,
            Some(hit) if hit.pushed => DM_HIT_PUSHED,
            Some(_) => DM_HIT_TOUCHED,
        };
        let states: Vec<u32> = found.iter().map(state).collect();
        // SAFETY: see above.
        unsafe { pointer::copy_wanted(&states, given.states) };
        Ok(())
    })
}
