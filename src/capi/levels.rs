//! Levels of sphere-meshes: their spheres at any time.

use std::sync::Arc;

use super::{
    guard::{Fault, Outcome, dm_result, guard},
    handle::{self, dm_level, dm_sphere_mesh},
    pointer::{self, structs},
    spheres::hierarchy,
};
use crate::sphere_mesh::{Hierarchy, Level, Shape};

/// Flag of a level: as the hierarchy has it, without its connectivity optimised.
pub const DM_LEVEL_PLAIN: u32 = 1;

/// Numbers of a level.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct dm_level_info {
    /// sizeof(dm_level_info), set by the caller.
    pub size: u32,
    /// Frames.
    pub frames: u32,
    /// Spheres.
    pub spheres: u32,
    /// Edges that no triangle has: capsules.
    pub edges: u32,
    /// Triangles: thick triangles.
    pub triangles: u32,
    /// Zero.
    pub reserved: u32,
    /// Root of the mean square distance between the planes of the mesh and the spheres, % of the diagonal.
    pub error: f64,
}

/// Arrays that a level at one time is written to; those that are NULL are left out.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_spheres {
    /// sizeof(dm_spheres).
    pub size: u32,
    /// Rows that centres and radii have, dm_level_info.spheres.
    pub spheres: u32,
    /// Rows that edge_ends has, dm_level_info.edges.
    pub edges: u32,
    /// Rows that corners has, dm_level_info.triangles.
    pub triangles: u32,
    /// Time in frames: between two of them centres go straight, before the first and behind the last they stay.
    pub time: f64,
    /// 3 numbers a sphere, in the sequence's units.
    pub centres: *mut f32,
    /// 1 number a sphere, in the sequence's units; the same at all times.
    pub radii: *mut f32,
    /// 2 spheres an edge, along which they are interpolated.
    pub edge_ends: *mut u32,
    /// 3 spheres a triangle.
    pub corners: *mut u32,
}

structs!(dm_level_info, dm_spheres);

/// What a level's handle stands for; shared with all that collides with it.
pub(super) struct Opened {
    pub(super) hierarchy: Arc<Hierarchy>,
    pub(super) level: Level,
}

impl Opened {
    /// Its spheres at a time.
    pub(super) fn at(&self, time: f64) -> Outcome<Shape> {
        check_time(time)?;
        Ok(Shape::at(&self.hierarchy, &self.level, time))
    }
}

/// Refuses what is no time.
pub(super) fn check_time(time: f64) -> Outcome {
    if time.is_finite() {
        return Ok(());
    }
    Err(Fault::argument("time", "is not finite"))
}

/// The level of a handle.
pub(super) fn opened(level: dm_level) -> Outcome<Arc<Opened>> {
    handle::with(level, |level| Ok(Arc::clone(level)))
}

/// Opens the level of a sphere-mesh with this many spheres.
///
/// spheres: from dm_sphere_mesh_info.least_spheres to dm_sphere_mesh_info.vertices. flags: DM_LEVEL_PLAIN, or 0, by which every
/// vertex goes to the nearest of its sphere and that sphere's neighbours, which are joined anew. out: receives the handle, which is
/// the caller's to destroy.
///
/// Threads: any; works on all cores.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for unknown flags, or naming the range where there is no such
/// level.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_level_create(
    mesh: dm_sphere_mesh,
    spheres: u32,
    flags: u32,
    out: *mut dm_level,
) -> dm_result {
    guard("dm_level_create", || {
        pointer::not_null(out, "out")?;
        let hierarchy = hierarchy(mesh)?;
        if flags & !DM_LEVEL_PLAIN != 0 {
            let reason = format!("{flags:#x} has unknown flags");
            return Err(Fault::argument("flags", reason));
        }
        let mut level = hierarchy.level(spheres as usize)?;
        if flags & DM_LEVEL_PLAIN == 0 {
            level = level.optimised(&hierarchy);
        }
        let handle: dm_level = handle::insert(Arc::new(Opened { hierarchy, level }))?;
        // SAFETY: not NULL; the caller's promise.
        unsafe { pointer::put(out, handle) };
        Ok(())
    })
}

/// Destroys a level. Colliders and particles that were made with it stay usable.
///
/// Threads: any. Returns DM_OK, or DM_ERROR_HANDLE where there is no such level (any more).
#[unsafe(no_mangle)]
pub extern "C" fn dm_level_destroy(level: dm_level) -> dm_result {
    guard("dm_level_destroy", || handle::destroy(level))
}

/// Tells the numbers of a level.
///
/// out: size set by the caller, the rest is filled.
///
/// Threads: any. Returns DM_OK, DM_ERROR_NULL, DM_ERROR_STRUCT_SIZE or DM_ERROR_HANDLE.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_level_get_info(level: dm_level, out: *mut dm_level_info) -> dm_result {
    guard("dm_level_get_info", || {
        // SAFETY: the caller's promise.
        unsafe { pointer::check(out, "out")? };
        let opened = opened(level)?;
        let info = dm_level_info {
            size: size_of::<dm_level_info>() as u32,
            frames: opened.hierarchy.frames as u32,
            spheres: opened.level.nodes.len() as u32,
            edges: opened.level.edges.len() as u32,
            triangles: opened.level.triangles.len() as u32,
            reserved: 0,
            error: opened.hierarchy.error(opened.level.nodes.len()),
        };
        // SAFETY: checked above.
        unsafe { pointer::put(out, info) };
        Ok(())
    })
}

/// Reads the spheres of a level at a time, with its edges and triangles.
///
/// spheres: its arrays are filled.
///
/// Threads: any.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_SIZE where the arrays have other numbers of rows than
/// dm_level_info says; DM_ERROR_ARGUMENT where the time is not finite.
///
/// # Safety
/// spheres is NULL or valid, and each of its arrays is NULL or has as many rows as it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_level_read(level: dm_level, spheres: *const dm_spheres) -> dm_result {
    guard("dm_level_read", || {
        // SAFETY: the caller's promise, here and below.
        let out = unsafe { pointer::read(spheres, "spheres")? };
        let opened = opened(level)?;
        let shape = opened.at(out.time)?;
        for (name, given, wanted) in [
            ("spheres.spheres", out.spheres, shape.balls.len()),
            ("spheres.edges", out.edges, shape.edges.len()),
            ("spheres.triangles", out.triangles, shape.triangles.len()),
        ] {
            if given as usize != wanted {
                return Err(Fault::size(name, given as usize, wanted));
            }
        }
        let centres: Vec<[f32; 3]> = shape
            .balls
            .iter()
            .map(|b| b.centre.as_vec3().to_array())
            .collect();
        let radii: Vec<f32> = shape.balls.iter().map(|b| b.radius as f32).collect();
        // SAFETY: see above.
        unsafe {
            pointer::copy_wanted(&centres, out.centres.cast());
            pointer::copy_wanted(&radii, out.radii);
            pointer::copy_wanted(&shape.edges, out.edge_ends.cast());
            pointer::copy_wanted(&shape.triangles, out.corners.cast());
        }
        Ok(())
    })
}
