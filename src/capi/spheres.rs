//! Sphere-meshes: built, in files, and their numbers.

use std::{
    ffi::{c_char, c_void},
    path::{Path, PathBuf},
    sync::Arc,
};

use glam::Vec3;

use super::{
    guard::{Fault, Outcome, dm_result, guard},
    handle::{self, dm_sphere_mesh},
    options::{Listener, dm_progress},
    pointer::{self, structs},
};
use crate::{
    Error,
    asset::{ROW_LIMIT, Room, Sequence},
    sphere_mesh::{self, Hierarchy, Options, bytes_a_vertex},
};

/// Flag of a sphere-mesh: collapses may turn triangles over, instead of being put off.
pub const DM_SPHERE_MESH_ALLOW_INVERSION: u32 = 1;
/// The same mesh at several moments, in any unit.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_sequence_desc {
    /// sizeof(dm_sequence_desc).
    pub size: u32,
    /// Number of vertices.
    pub vertices: u32,
    /// Number of triangles.
    pub triangles: u32,
    /// Number of frames.
    pub frames: u32,
    /// 3 numbers a vertex, frame by frame.
    pub positions: *const f32,
    /// Rows of vertices, 3 a triangle, counter-clockwise seen from outside, the same in all frames.
    pub indices: *const u32,
}

/// How a sphere-mesh is built; dm_sphere_mesh_options_default fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_sphere_mesh_options {
    /// sizeof(dm_sphere_mesh_options).
    pub size: u32,
    /// DM_SPHERE_MESH_ALLOW_INVERSION or 0.
    pub flags: u32,
    /// How much curved places count, 0 to 1: the power of 1 + BBD^2 (k1^2 + k2^2) with which areas are weighted; at 0 area
    /// alone counts.
    pub curvature: f64,
    /// Weight of temporal coherence against the planes', 0 to 1e9: from about 1 on spheres stay near the middle of their region.
    pub temporal: f64,
    /// Receives how far the build is; may be NULL.
    pub progress: dm_progress,
    /// First argument of progress.
    pub progress_user: *mut c_void,
}

/// Numbers of a sphere-mesh.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct dm_sphere_mesh_info {
    /// sizeof(dm_sphere_mesh_info), set by the caller.
    pub size: u32,
    /// Frames.
    pub frames: u32,
    /// Vertices after rows that coincide in all frames are welded: the most spheres that a level can have.
    pub vertices: u32,
    /// Triangles between them.
    pub triangles: u32,
    /// The least spheres that a level can have: one a connected component.
    pub least_spheres: u32,
    /// Zero.
    pub reserved: u32,
    /// Mean over the frames of the bounding box's diagonal.
    pub diagonal: f64,
}

structs!(
    dm_sequence_desc,
    dm_sphere_mesh_options,
    dm_sphere_mesh_info
);

/// The sphere-mesh of a handle.
pub(super) fn hierarchy(mesh: dm_sphere_mesh) -> Outcome<Arc<Hierarchy>> {
    handle::with(mesh, |mesh| Ok(Arc::clone(mesh)))
}

/// Fills options with the defaults, those that NULL in their place has.
///
/// out: size set by the caller, the rest is filled.
///
/// Threads: any. Returns DM_OK, DM_ERROR_NULL or DM_ERROR_STRUCT_SIZE.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_sphere_mesh_options_default(
    out: *mut dm_sphere_mesh_options,
) -> dm_result {
    guard("dm_sphere_mesh_options_default", || {
        let Options {
            curvature,
            temporal,
            inversion,
            ..
        } = Options::default();
        let options = dm_sphere_mesh_options {
            size: size_of::<dm_sphere_mesh_options>() as u32,
            flags: match inversion {
                true => 0,
                false => DM_SPHERE_MESH_ALLOW_INVERSION,
            },
            curvature,
            temporal,
            progress: None,
            progress_user: std::ptr::null_mut(),
        };
        // SAFETY: the caller's promise.
        unsafe {
            pointer::check(out, "out")?;
            pointer::put(out, options);
        }
        Ok(())
    })
}

/// Builds the sphere-mesh of a sequence: all levels, from one sphere a vertex to one a connected component.
///
/// desc: copied with its arrays. options: NULL for the defaults. out: receives the handle, which is the caller's to destroy.
///
/// Threads: any; works on all cores, about a microsecond a vertex and frame.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_ARGUMENT naming the frame, vertex or triangle that cannot be used,
/// or the option that is out of range; DM_ERROR_MEMORY where the build needs more than there is, before it begins.
///
/// # Safety
/// desc is NULL or valid with its arrays, each as long as its numbers say; options is NULL or valid, and its progress may be
/// called by any thread, one at a time, until the call returns; out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_sphere_mesh_build(
    desc: *const dm_sequence_desc,
    options: *const dm_sphere_mesh_options,
    out: *mut dm_sphere_mesh,
) -> dm_result {
    guard("dm_sphere_mesh_build", || {
        // SAFETY: the caller's promise, here and below.
        let (desc, options) = unsafe {
            let options = match options.is_null() {
                true => None,
                false => Some(pointer::read(options, "options")?),
            };
            (pointer::read(desc, "desc")?, options)
        };
        pointer::not_null(out, "out")?;
        // SAFETY: see above.
        let sequence = unsafe { sequence(&desc)? };
        let (options, listener) = match options {
            None => (Options::default(), Listener::default()),
            Some(given) => read(&given)?,
        };
        let tell = |progress| listener.tell(progress);
        let built = sphere_mesh::build(&sequence, &options, &tell).map_err(of_arrays)?;
        let handle: dm_sphere_mesh = handle::insert(Arc::new(built))?;
        // SAFETY: see above.
        unsafe { pointer::put(out, handle) };
        Ok(())
    })
}

/// Reads a sphere-mesh from a file (.dsm) that dm_sphere_mesh_save or `dermis sphere-mesh build` wrote.
///
/// path: UTF-8. out: receives the handle, which is the caller's to destroy.
///
/// Threads: any.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_ARGUMENT where path is not UTF-8; DM_ERROR_FILE where the file cannot be read, is none of
/// these or is damaged.
///
/// # Safety
/// path is NULL or text that ends with zero; out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_sphere_mesh_load(
    path: *const c_char,
    out: *mut dm_sphere_mesh,
) -> dm_result {
    guard("dm_sphere_mesh_load", || {
        // SAFETY: the caller's promise, here and below.
        let path = unsafe { pointer::text(path, "path")? };
        pointer::not_null(out, "out")?;
        let loaded = Hierarchy::load(Path::new(&path))?;
        let handle: dm_sphere_mesh = handle::insert(Arc::new(loaded))?;
        // SAFETY: see above.
        unsafe { pointer::put(out, handle) };
        Ok(())
    })
}

/// Writes a sphere-mesh with all its levels to a file (.dsm). A file that is there is replaced once the new one is whole.
///
/// path: UTF-8.
///
/// Threads: any.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where path is not UTF-8; DM_ERROR_FILE where it cannot be
/// written.
///
/// # Safety
/// path is NULL or text that ends with zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_sphere_mesh_save(
    mesh: dm_sphere_mesh,
    path: *const c_char,
) -> dm_result {
    guard("dm_sphere_mesh_save", || {
        // SAFETY: the caller's promise.
        let path = unsafe { pointer::text(path, "path")? };
        Ok(hierarchy(mesh)?.save(Path::new(&path))?)
    })
}

/// Destroys a sphere-mesh. Its levels stay usable.
///
/// Threads: any. Returns DM_OK, or DM_ERROR_HANDLE where there is no such sphere-mesh (any more).
#[unsafe(no_mangle)]
pub extern "C" fn dm_sphere_mesh_destroy(mesh: dm_sphere_mesh) -> dm_result {
    guard("dm_sphere_mesh_destroy", || handle::destroy(mesh))
}

/// Tells the numbers of a sphere-mesh.
///
/// out: size set by the caller, the rest is filled.
///
/// Threads: any. Returns DM_OK, DM_ERROR_NULL, DM_ERROR_STRUCT_SIZE or DM_ERROR_HANDLE.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_sphere_mesh_get_info(
    mesh: dm_sphere_mesh,
    out: *mut dm_sphere_mesh_info,
) -> dm_result {
    guard("dm_sphere_mesh_get_info", || {
        // SAFETY: the caller's promise.
        unsafe { pointer::check(out, "out")? };
        let hierarchy = hierarchy(mesh)?;
        let info = dm_sphere_mesh_info {
            size: size_of::<dm_sphere_mesh_info>() as u32,
            frames: hierarchy.frames as u32,
            vertices: hierarchy.vertices as u32,
            triangles: hierarchy.triangles.len() as u32,
            least_spheres: hierarchy.range().start as u32,
            reserved: 0,
            diagonal: hierarchy.diagonal,
        };
        // SAFETY: checked above.
        unsafe { pointer::put(out, info) };
        Ok(())
    })
}

/// Tells the least number of spheres whose error is at most this.
///
/// error: as dm_level_info.error, % of the diagonal. out: receives the number.
///
/// Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where the error is negative or no number.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_sphere_mesh_spheres_for(
    mesh: dm_sphere_mesh,
    error: f64,
    out: *mut u32,
) -> dm_result {
    guard("dm_sphere_mesh_spheres_for", || {
        pointer::not_null(out, "out")?;
        let hierarchy = hierarchy(mesh)?;
        if error.is_nan() || error < 0.0 {
            return Err(Fault::argument(
                "error",
                format!("{error} is not 0 or more"),
            ));
        }
        // SAFETY: not NULL; the caller's promise.
        unsafe { pointer::put(out, hierarchy.spheres_for(error) as u32) };
        Ok(())
    })
}

/// # Safety
/// The arrays of `desc` are NULL or as long as its numbers say.
unsafe fn sequence(desc: &dm_sequence_desc) -> Outcome<Sequence> {
    for (name, count) in [
        ("desc.vertices", desc.vertices),
        ("desc.triangles", desc.triangles),
        ("desc.frames", desc.frames),
    ] {
        if !(1..=ROW_LIMIT).contains(&(count as usize)) {
            let reason = format!("{count} is not in 1 to {ROW_LIMIT}");
            return Err(Fault::argument(name, reason));
        }
    }
    let (vertices, frames) = (desc.vertices as usize, desc.frames as usize);
    let path = PathBuf::from("desc");
    Room::available(bytes_a_vertex).check(&path, vertices, frames)?;
    pointer::not_null(desc.positions, "desc.positions")?;
    let frame = |row: usize| -> Outcome<Vec<Vec3>> {
        // SAFETY: the caller's promise; a `Vec3` is three numbers.
        unsafe {
            let first = desc.positions.cast::<Vec3>().add(row * vertices);
            pointer::array(first, vertices, "desc.positions")
        }
    };
    Ok(Sequence {
        frames: (0..frames).map(frame).collect::<Outcome<_>>()?,
        // SAFETY: the caller's promise.
        triangles: unsafe {
            let count = desc.triangles as usize;
            pointer::array(desc.indices.cast(), count, "desc.indices")?
        },
        path,
    })
}

fn read(given: &dm_sphere_mesh_options) -> Outcome<(Options, Listener)> {
    if given.flags & !DM_SPHERE_MESH_ALLOW_INVERSION != 0 {
        let reason = format!("{:#x} has unknown flags", given.flags);
        return Err(Fault::argument("options.flags", reason));
    }
    let options = Options {
        curvature: given.curvature,
        temporal: given.temporal,
        inversion: given.flags & DM_SPHERE_MESH_ALLOW_INVERSION == 0,
        spheres: true,
    };
    Ok((options, Listener::new(given.progress, given.progress_user)))
}

/// What is wrong with arrays is no file's fault.
fn of_arrays(error: Error) -> Fault {
    match error {
        Error::Asset {
            element, reason, ..
        } => Fault::argument(&format!("desc: {element}"), reason),
        other => other.into(),
    }
}
