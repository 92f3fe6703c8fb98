//! Sphere-meshes, collisions and particles: every function, as in `calls`.
// Pointers are NULL or to what lives until the call returns.
#![allow(clippy::undocumented_unsafe_blocks)]

use std::{ffi::CString, ptr::null};

use dermis::capi::*;

use crate::{
    calls::{
        Arguments, Call,
        Takes::{Collider, Context, Level, Nothing, Particles, SphereMesh},
        call, made,
    },
    fine, raw,
};

pub(crate) fn sized<T>() -> T {
    unsafe {
        let mut out: T = std::mem::zeroed();
        (&raw mut out).cast::<u32>().write(size_of::<T>() as u32);
        out
    }
}

/// Frames of the tube.
pub(crate) const FRAMES: usize = 3;

/// A tube that is bent, frame by frame.
pub(crate) struct Tube {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) indices: Vec<[u32; 3]>,
}

impl Tube {
    pub(crate) fn new() -> Self {
        let mesh = raw::Mesh::tube();
        let bent = |frame: usize| {
            let bend = 0.1 * frame as f32;
            let rows = mesh.positions.iter();
            rows.map(move |[x, y, z]| [*x, y + bend * x * x, *z])
        };
        Self {
            positions: (0..FRAMES).flat_map(bent).collect(),
            indices: mesh.indices.clone(),
        }
    }

    pub(crate) fn desc(&self) -> dm_sequence_desc {
        dm_sequence_desc {
            vertices: (self.positions.len() / FRAMES) as u32,
            triangles: self.indices.len() as u32,
            frames: FRAMES as u32,
            positions: self.positions.as_ptr().cast(),
            indices: self.indices.as_ptr().cast(),
            ..sized()
        }
    }

    pub(crate) fn build(&self) -> dm_sphere_mesh {
        let mut out = dm_sphere_mesh::default();
        fine(unsafe { dm_sphere_mesh_build(&self.desc(), null(), &mut out) });
        out
    }
}

/// A level of a sphere-mesh, with its numbers.
pub(crate) fn level(mesh: dm_sphere_mesh, spheres: u32) -> (dm_level, dm_level_info) {
    let (mut out, mut info) = (dm_level::default(), sized());
    fine(unsafe { dm_level_create(mesh, spheres, 0, &mut out) });
    fine(unsafe { dm_level_get_info(out, &mut info) });
    (out, info)
}

/// Two particles, one of which falls.
const PLACES: [f32; 8] = [2.0, 3.0, 0.0, 0.1, 1.0, 2.0, 0.0, 0.1];
const SPEEDS: [f32; 6] = [0.0, 0.0, 0.0, 0.0, -20.0, 0.0];

fn flying() -> dm_particles_desc {
    dm_particles_desc {
        count: 2,
        positions: PLACES.as_ptr(),
        velocities: SPEEDS.as_ptr(),
        ..sized()
    }
}

impl Arguments {
    /// A sphere-mesh, a level of it, and what collides with it in the context.
    pub(crate) fn fill_spheres(&mut self) {
        self.mesh = Tube::new().build();
        self.level = level(self.mesh, 4).0;
        unsafe {
            fine(dm_collider_create(self.level, 0.0, &mut self.collider));
            let (level, out) = (self.level, &mut self.particles);
            let made = dm_particles_create(self.context, level, 0.0, &flying(), null(), out);
            fine(made);
        }
    }

    pub(crate) fn clear_spheres(&mut self) {
        fine(dm_particles_destroy(self.particles));
        fine(dm_collider_destroy(self.collider));
        fine(dm_level_destroy(self.level));
        fine(dm_sphere_mesh_destroy(self.mesh));
    }
}

unsafe extern "C" fn on_progress(
    _: *mut std::ffi::c_void,
    _: *const std::ffi::c_char,
    _: u64,
    _: u64,
) {
}

/// A path in a folder of its own.
pub(crate) fn path() -> (tempfile::TempDir, CString) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tube.dsm");
    let path = CString::new(path.to_str().unwrap()).unwrap();
    (folder, path)
}

#[rustfmt::skip]
pub(crate) const SPHERE_CALLS: &[Call] = &[
    call("dm_sphere_mesh_options_default", Nothing, true, true, |a| unsafe {
        let mut out: dm_sphere_mesh_options = sized();
        out.size = a.size::<dm_sphere_mesh_options>();
        dm_sphere_mesh_options_default(a.of(&mut out))
    }),
    call("dm_sphere_mesh_build", Nothing, true, true, |a| unsafe {
        let tube = Tube::new();
        let mut desc = dm_sequence_desc { size: a.size::<dm_sequence_desc>(), ..tube.desc() };
        desc.positions = a.of(desc.positions.cast_mut());
        desc.indices = a.of(desc.indices.cast_mut());
        let mut options = dm_sphere_mesh_options { curvature: 0.5, progress: Some(on_progress), ..sized() };
        options.size = a.size::<dm_sphere_mesh_options>();
        let mut out = dm_sphere_mesh::default();
        let result = dm_sphere_mesh_build(a.of(&mut desc), a.may(&mut options), a.of(&mut out));
        made(result, || dm_sphere_mesh_destroy(out))
    }),
    call("dm_sphere_mesh_save", SphereMesh, true, false, |a| unsafe {
        let (_folder, path) = path();
        dm_sphere_mesh_save(a.mesh, a.text(&path))
    }),
    call("dm_sphere_mesh_load", Nothing, true, false, |a| unsafe {
        let (_folder, path) = path();
        let tube = Tube::new().build();
        fine(dm_sphere_mesh_save(tube, path.as_ptr()));
        fine(dm_sphere_mesh_destroy(tube));
        let mut out = dm_sphere_mesh::default();
        let result = dm_sphere_mesh_load(a.text(&path), a.of(&mut out));
        made(result, || dm_sphere_mesh_destroy(out))
    }),
    call("dm_sphere_mesh_destroy", SphereMesh, false, false, |a| dm_sphere_mesh_destroy(a.mesh)),
    call("dm_sphere_mesh_get_info", SphereMesh, true, true, |a| unsafe {
        let mut out = dm_sphere_mesh_info { size: a.size::<dm_sphere_mesh_info>(), ..sized() };
        dm_sphere_mesh_get_info(a.mesh, a.of(&mut out))
    }),
    call("dm_sphere_mesh_spheres_for", SphereMesh, true, false, |a| unsafe {
        dm_sphere_mesh_spheres_for(a.mesh, 1.0, a.of(&mut 0))
    }),
    call("dm_level_create", SphereMesh, true, false, |a| unsafe {
        let mut out = dm_level::default();
        let result = dm_level_create(a.mesh, 5, DM_LEVEL_PLAIN, a.of(&mut out));
        made(result, || dm_level_destroy(out))
    }),
    call("dm_level_destroy", Level, false, false, |a| dm_level_destroy(a.level)),
    call("dm_level_get_info", Level, true, true, |a| unsafe {
        let mut out = dm_level_info { size: a.size::<dm_level_info>(), ..sized() };
        dm_level_get_info(a.level, a.of(&mut out))
    }),
    call("dm_level_read", Level, true, true, |a| unsafe {
        let mut info: dm_level_info = sized();
        // With the handle of the call; where it is none, the call below says so.
        _ = dm_level_get_info(a.level, &mut info);
        let (mut centres, mut radii) = (vec![0f32; 3 * info.spheres as usize], vec![0f32; info.spheres as usize]);
        let (mut ends, mut corners) = (vec![0u32; 2 * info.edges as usize], vec![0u32; 3 * info.triangles as usize]);
        let mut out = dm_spheres {
            size: a.size::<dm_spheres>(),
            spheres: info.spheres,
            edges: info.edges,
            triangles: info.triangles,
            time: 0.5,
            centres: a.may(centres.as_mut_ptr()),
            radii: a.may(radii.as_mut_ptr()),
            edge_ends: a.may(ends.as_mut_ptr()),
            corners: a.may(corners.as_mut_ptr()),
        };
        dm_level_read(a.level, a.of(&mut out))
    }),
    call("dm_collider_create", Level, true, false, |a| unsafe {
        let mut out = dm_collider::default();
        let result = dm_collider_create(a.level, 1.5, a.of(&mut out));
        made(result, || dm_collider_destroy(out))
    }),
    call("dm_collider_destroy", Collider, false, false, |a| dm_collider_destroy(a.collider)),
    call("dm_collider_sweep", Collider, true, true, |a| unsafe {
        let segments = [1.0, 2.0, 0.0, 1.0, -2.0, 0.0, 0.1];
        let (mut hits, mut states) = ([0f64; 7], [0u32; 1]);
        let mut sweeps = dm_sweeps {
            size: a.size::<dm_sweeps>(),
            count: 1,
            segments: a.from(&segments),
            hits: a.of(hits.as_mut_ptr()),
            states: a.may(states.as_mut_ptr()),
        };
        dm_collider_sweep(a.collider, a.of(&mut sweeps))
    }),
    call("dm_particle_settings_default", Nothing, true, true, |a| unsafe {
        let mut out = dm_particle_settings { size: a.size::<dm_particle_settings>(), ..sized() };
        dm_particle_settings_default(a.of(&mut out))
    }),
    call("dm_particles_create", Context, true, true, |a| unsafe {
        let mut desc = dm_particles_desc { size: a.size::<dm_particles_desc>(), ..flying() };
        desc.positions = a.of(desc.positions.cast_mut());
        desc.velocities = a.may(desc.velocities.cast_mut());
        let mut settings: dm_particle_settings = sized();
        fine(dm_particle_settings_default(&mut settings));
        settings.size = a.size::<dm_particle_settings>();
        let mut out = dm_particles::default();
        let result = dm_particles_create(
            a.context, a.level, 0.0, a.of(&mut desc), a.may(&mut settings), a.of(&mut out),
        );
        made(result, || dm_particles_destroy(out))
    }),
    call("dm_particles_destroy", Particles, false, false, |a| dm_particles_destroy(a.particles)),
    call("dm_particles_advance", Particles, false, false, |a| dm_particles_advance(a.particles, 0.5, 0.1)),
    call("dm_particles_place", Particles, false, false, |a| dm_particles_place(a.particles, 0.0)),
    call("dm_particles_read", Particles, true, true, |a| unsafe {
        let (mut positions, mut velocities, mut contacts) = ([0f32; 8], [0f32; 6], [0u32; 2]);
        let mut out = dm_flights {
            size: a.size::<dm_flights>(),
            count: 2,
            positions: a.may(positions.as_mut_ptr()),
            velocities: a.may(velocities.as_mut_ptr()),
            contacts: a.may(contacts.as_mut_ptr()),
        };
        dm_particles_read(a.particles, a.of(&mut out))
    }),
    call("dm_particles_write", Particles, true, true, |a| unsafe {
        let mut desc = dm_particles_desc { size: a.size::<dm_particles_desc>(), ..flying() };
        desc.positions = a.of(desc.positions.cast_mut());
        desc.velocities = a.may(desc.velocities.cast_mut());
        dm_particles_write(a.particles, a.of(&mut desc))
    }),
];
