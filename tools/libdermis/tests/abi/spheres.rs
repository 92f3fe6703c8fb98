//! Sphere-meshes, collisions and particles give in C what Rust gives, and what is wrong with them is named.
// Pointers are NULL or to what lives until the call returns; Vulkan's handles live as long as the host.
#![allow(clippy::undocumented_unsafe_blocks)]

use std::{
    ffi::{c_char, c_void},
    ptr::{null, null_mut},
};

use ash::vk::Handle as _;
use dermis::{
    asset::Sequence,
    capi::{dm_result::*, *},
    deformer::Device,
    particles::{Particle, Particles, Settings},
    sphere_mesh::{self, Collider, Hierarchy, Level, Options, Shape, Sweep},
};
use glam::Vec3;

use crate::{
    calls, fine,
    host_device::HostDevice,
    last_error, no_gpu, skin,
    sphere_calls::{FRAMES, Tube, level, path, sized},
};

#[track_caller]
fn refused(result: dm_result, wanted: dm_result, named: &str) {
    assert_eq!(result, wanted, "{}", last_error());
    assert!(last_error().contains(named), "{named}: {}", last_error());
}

/// What Rust builds of the tube.
fn by_rust(tube: &Tube, spheres: usize) -> (Hierarchy, Level) {
    let rows = tube.positions.len() / FRAMES;
    let frames = tube.positions.chunks(rows);
    let sequence = Sequence {
        path: "tube".into(),
        triangles: tube.indices.clone(),
        frames: frames
            .map(|f| f.iter().map(|p| Vec3::from_array(*p)).collect())
            .collect(),
    };
    let hierarchy = sphere_mesh::build(&sequence, &Options::default(), &|_| {}).unwrap();
    let level = hierarchy.level(spheres).unwrap().optimised(&hierarchy);
    (hierarchy, level)
}

unsafe extern "C" fn count(user: *mut c_void, stage: *const c_char, done: u64, total: u64) {
    assert!(!stage.is_null() && done <= total);
    unsafe { *user.cast::<u32>() += 1 };
}

#[test]
fn levels_and_hits_are_those_of_rust() {
    let tube = Tube::new();
    let (hierarchy, rust) = by_rust(&tube, 6);
    let mut options: dm_sphere_mesh_options = sized();
    fine(unsafe { dm_sphere_mesh_options_default(&mut options) });
    let mut told = 0u32;
    options.progress = Some(count);
    options.progress_user = (&raw mut told).cast();
    let mut mesh = dm_sphere_mesh::default();
    fine(unsafe { dm_sphere_mesh_build(&tube.desc(), &options, &mut mesh) });
    assert!(told > 0);
    let (_folder, path) = path();
    fine(unsafe { dm_sphere_mesh_save(mesh, path.as_ptr()) });
    fine(dm_sphere_mesh_destroy(mesh));
    fine(unsafe { dm_sphere_mesh_load(path.as_ptr(), &mut mesh) });
    let mut info: dm_sphere_mesh_info = sized();
    fine(unsafe { dm_sphere_mesh_get_info(mesh, &mut info) });
    assert_eq!(info.vertices as usize, hierarchy.vertices);
    assert_eq!(info.triangles as usize, hierarchy.triangles.len());
    assert_eq!((info.frames, info.least_spheres), (3, 1));
    assert_eq!(info.diagonal, hierarchy.diagonal);
    let mut spheres = 0;
    fine(unsafe { dm_sphere_mesh_spheres_for(mesh, 2.0, &mut spheres) });
    assert_eq!(spheres as usize, hierarchy.spheres_for(2.0));
    let (level, counts) = level(mesh, 6);
    assert_eq!(counts.error, hierarchy.error(6));
    let shape = Shape::at(&hierarchy, &rust, 1.25);
    let mut centres = vec![[0f32; 3]; counts.spheres as usize];
    let mut radii = vec![0f32; counts.spheres as usize];
    let mut ends = vec![[0u32; 2]; counts.edges as usize];
    let mut corners = vec![[0u32; 3]; counts.triangles as usize];
    let out = dm_spheres {
        spheres: counts.spheres,
        edges: counts.edges,
        triangles: counts.triangles,
        time: 1.25,
        centres: centres.as_mut_ptr().cast(),
        radii: radii.as_mut_ptr(),
        edge_ends: ends.as_mut_ptr().cast(),
        corners: corners.as_mut_ptr().cast(),
        ..sized()
    };
    fine(unsafe { dm_level_read(level, &out) });
    let balls = shape.balls.iter();
    assert!(
        balls
            .clone()
            .map(|b| b.centre.as_vec3().to_array())
            .eq(centres)
    );
    assert!(balls.map(|b| b.radius as f32).eq(radii));
    assert_eq!(
        (ends, corners),
        (shape.edges.clone(), shape.triangles.clone())
    );
    let mut collider = dm_collider::default();
    fine(unsafe { dm_collider_create(level, 1.25, &mut collider) });
    let segments = [
        [2.0, 3.0, 0.0, 2.0, -3.0, 0.0, 0.1],
        [2.0, 0.6, 0.0, 2.0, 5.0, 0.0, 0.3],
        [9.0, 3.0, 0.0, 9.0, -3.0, 0.0, 0.0],
    ];
    let (mut hits, mut states) = ([[0f64; 7]; 3], [9u32; 3]);
    let sweeps = dm_sweeps {
        count: 3,
        segments: segments.as_ptr().cast(),
        hits: hits.as_mut_ptr().cast(),
        states: states.as_mut_ptr(),
        ..sized()
    };
    fine(unsafe { dm_collider_sweep(collider, &sweeps) });
    let wanted: Vec<Sweep> = segments.iter().map(Sweep::of_row).collect();
    let found = Collider::new(&shape)
        .unwrap()
        .first_of_each(&wanted)
        .unwrap();
    for row in 0..3 {
        assert_eq!(hits[row], wanted[row].row_of(found[row].as_ref()));
    }
    assert_eq!(states, [DM_HIT_TOUCHED, DM_HIT_PUSHED, DM_HIT_NONE]);
    fine(dm_collider_destroy(collider));
    fine(dm_level_destroy(level));
    fine(dm_sphere_mesh_destroy(mesh));
}

/// Some particles over the tube.
fn cloud() -> Vec<Particle> {
    let particle = |k: u8| Particle {
        position: Vec3::new(0.1 + 0.2 * f32::from(k), 1.5, 0.02 * f32::from(k % 5)),
        radius: 0.05,
        velocity: Vec3::new(0.0, -8.0, 0.0),
        contacts: 0,
    };
    (0..20).map(particle).collect()
}

/// The particles as C takes them, and the arrays for it.
fn described(cloud: &[Particle]) -> (dm_particles_desc, [Vec<f32>; 2]) {
    let positions = cloud
        .iter()
        .flat_map(|p| p.position.extend(p.radius).to_array());
    let velocities = cloud.iter().flat_map(|p| p.velocity.to_array());
    let arrays = [positions.collect::<Vec<f32>>(), velocities.collect()];
    let desc = dm_particles_desc {
        count: cloud.len() as u32,
        positions: arrays[0].as_ptr(),
        velocities: arrays[1].as_ptr(),
        ..sized()
    };
    (desc, arrays)
}

fn made(context: dm_context, level: dm_level, cloud: &[Particle]) -> dm_particles {
    let (desc, _arrays) = described(cloud);
    let mut out = dm_particles::default();
    fine(unsafe { dm_particles_create(context, level, 0.0, &desc, null(), &mut out) });
    out
}

fn read(particles: dm_particles, count: usize) -> Vec<Particle> {
    let (mut positions, mut velocities) = (vec![[0f32; 4]; count], vec![[0f32; 3]; count]);
    let mut contacts = vec![0u32; count];
    let out = dm_flights {
        count: count as u32,
        positions: positions.as_mut_ptr().cast(),
        velocities: velocities.as_mut_ptr().cast(),
        contacts: contacts.as_mut_ptr(),
        ..sized()
    };
    fine(unsafe { dm_particles_read(particles, &out) });
    let row = |k: usize| Particle {
        position: Vec3::from_slice(&positions[k]),
        radius: positions[k][3],
        velocity: Vec3::from_array(velocities[k]),
        contacts: contacts[k],
    };
    (0..count).map(row).collect()
}

#[test]
fn particles_are_those_of_rust() {
    let (tube, cloud) = (Tube::new(), cloud());
    let (hierarchy, rust) = by_rust(&tube, 6);
    let mut shape = Shape::new(&hierarchy, &rust, 0);
    let mut wanted = Particles::new(&Device::Cpu, &shape, &cloud, &Settings::default()).unwrap();
    let context = skin::context(&calls::cpu());
    let mesh = tube.build();
    let particles = made(context, level(mesh, 6).0, &cloud);
    // What they need of these lives on.
    fine(dm_context_destroy(context));
    fine(dm_sphere_mesh_destroy(mesh));
    for frame in 1..=8 {
        let time = 0.25 * f64::from(frame);
        shape.go_to(&hierarchy, &rust, time);
        wanted.advance(&shape.balls, 0.05).unwrap();
        fine(dm_particles_advance(particles, time, 0.05));
        assert_eq!(read(particles, cloud.len()), wanted.read().unwrap());
    }
    assert!(wanted.read().unwrap().iter().any(|p| p.contacts > 0));
    shape.go_to(&hierarchy, &rust, 0.0);
    wanted.place(&shape.balls).unwrap();
    wanted.write(&cloud).unwrap();
    fine(dm_particles_place(particles, 0.0));
    fine(unsafe { dm_particles_write(particles, &described(&cloud).0) });
    wanted.advance(&shape.balls, 0.1).unwrap();
    fine(dm_particles_advance(particles, 0.0, 0.1));
    assert_eq!(read(particles, cloud.len()), wanted.read().unwrap());
    fine(dm_particles_destroy(particles));
}

#[test]
fn a_host_gets_its_particles_in_its_buffer() {
    if no_gpu() {
        return;
    }
    let (host, cloud) = (HostDevice::new(), cloud());
    let mut context = dm_context::default();
    fine(unsafe { dm_context_adopt(&host.vulkan(), &mut context) });
    let mesh = Tube::new().build();
    let level = level(mesh, 6).0;
    // Submitted by dermis, and recorded by the host.
    let [submitted, recorded] = [0, 1].map(|_| made(context, level, &cloud));
    let mut output = dm_output::default();
    let create = |particles, desc: &dm_output_desc, out: &mut dm_output| unsafe {
        dm_particles_output(context, particles, desc, out)
    };
    let bytes = dm_output_desc {
        normal_format: DM_NORMAL_SNORM8,
        ..host.output()
    };
    refused(
        create(recorded, &bytes, &mut output),
        DM_ERROR_ARGUMENT,
        "velocities",
    );
    fine(create(recorded, &host.output(), &mut output));
    let commands = host.commands.as_raw() as *mut _;
    for frame in 0..6 {
        let time = 0.4 * f64::from(frame);
        fine(dm_particles_advance(submitted, time, 0.03));
        host.run(|| {
            let slot = frame as u32 % 2;
            fine(unsafe { dm_particles_record(recorded, commands, slot, time, 0.03, output) });
        });
    }
    let wanted = read(submitted, cloud.len());
    assert_eq!(read(recorded, cloud.len()), wanted);
    assert!(wanted.iter().any(|p| p.contacts > 0));
    let rows = wanted.iter().flat_map(|p| [p.position, p.velocity]);
    let numbers = rows.flat_map(|v| v.to_array().map(f32::to_bits));
    assert!(host.words(6 * cloud.len()).into_iter().eq(numbers));
    let record = |particles, slot, time, seconds, output| unsafe {
        dm_particles_record(particles, commands, slot, time, seconds, output)
    };
    refused(
        record(submitted, 0, 0.0, 0.1, output),
        DM_ERROR_FOREIGN,
        "something else",
    );
    let none = dm_output::default();
    refused(
        record(recorded, 2, 0.0, 0.1, none),
        DM_ERROR_ARGUMENT,
        "2 of 2",
    );
    refused(
        record(recorded, 0, f64::NAN, 0.1, none),
        DM_ERROR_ARGUMENT,
        "time",
    );
    refused(
        record(recorded, 0, 0.0, -0.1, none),
        DM_ERROR_ARGUMENT,
        "seconds",
    );
    let mut second = dm_context::default();
    fine(unsafe { dm_context_adopt(&host.vulkan(), &mut second) });
    let foreign = unsafe { dm_particles_output(second, recorded, &host.output(), &mut output) };
    refused(foreign, DM_ERROR_FOREIGN, "another context");
    fine(dm_context_destroy(second));
    fine(dm_output_destroy(output));
    for particles in [submitted, recorded] {
        fine(dm_particles_destroy(particles));
    }
    let mut memory: dm_memory = sized();
    fine(unsafe { dm_context_memory(context, &mut memory) });
    assert_eq!((memory.total, memory.buffers), (0, 0));
    fine(dm_context_destroy(context));
    fine(dm_level_destroy(level));
    fine(dm_sphere_mesh_destroy(mesh));
    assert_eq!(host.end(), Vec::<String>::new());
}

#[test]
fn what_is_wrong_with_sphere_meshes_and_particles_is_named() {
    let mut tube = Tube::new();
    let build = |desc: dm_sequence_desc, options: Option<dm_sphere_mesh_options>| unsafe {
        let options = options.as_ref().map_or(null(), std::ptr::from_ref);
        dm_sphere_mesh_build(&desc, options, &mut dm_sphere_mesh::default())
    };
    let wrong = |result, named| refused(result, DM_ERROR_ARGUMENT, named);
    let desc = tube.desc();
    wrong(
        build(dm_sequence_desc { frames: 0, ..desc }, None),
        "desc.frames",
    );
    wrong(
        build(
            dm_sequence_desc {
                vertices: !0,
                ..desc
            },
            None,
        ),
        "desc.vertices",
    );
    let great = dm_sequence_desc {
        frames: 8_000_000,
        ..desc
    };
    refused(build(great, None), DM_ERROR_MEMORY, "available");
    let mut options: dm_sphere_mesh_options = sized();
    fine(unsafe { dm_sphere_mesh_options_default(&mut options) });
    for (options, named) in [
        (
            dm_sphere_mesh_options {
                flags: 8,
                ..options
            },
            "options.flags",
        ),
        (
            dm_sphere_mesh_options {
                curvature: f64::NAN,
                ..options
            },
            "curvature",
        ),
        (
            dm_sphere_mesh_options {
                temporal: -1.0,
                ..options
            },
            "temporal",
        ),
    ] {
        wrong(build(desc, Some(options)), named);
    }
    let rows = tube.positions.len() / FRAMES;
    tube.positions[rows + 7][1] = f32::NAN;
    wrong(build(tube.desc(), None), "frame 1, vertex 7");
    tube.positions[rows + 7][1] = 0.0;
    tube.indices[3][2] = 5000;
    wrong(build(tube.desc(), None), "triangle 3");
    let tube = Tube::new();
    let mesh = tube.build();
    let (_folder, path) = path();
    let load = unsafe { dm_sphere_mesh_load(path.as_ptr(), &mut dm_sphere_mesh::default()) };
    refused(load, DM_ERROR_FILE, "tube.dsm");
    let save = unsafe { dm_sphere_mesh_save(mesh, c"no/such/folder.dsm".as_ptr()) };
    refused(save, DM_ERROR_FILE, "no/such");
    let create =
        |spheres, flags| unsafe { dm_level_create(mesh, spheres, flags, &mut dm_level::default()) };
    wrong(create(0, 0), "one a component");
    wrong(create(4, 2), "flags");
    wrong(
        unsafe { dm_sphere_mesh_spheres_for(mesh, f64::NAN, &mut 0) },
        "error",
    );
    let (level, info) = level(mesh, 6);
    let spheres = |spheres, edges, triangles, time| unsafe {
        let out = dm_spheres {
            spheres,
            edges,
            triangles,
            time,
            ..sized()
        };
        dm_level_read(level, &out)
    };
    let (a, b, c) = (info.spheres, info.edges, info.triangles);
    refused(spheres(a + 1, b, c, 0.0), DM_ERROR_SIZE, "spheres.spheres");
    refused(spheres(a, b + 1, c, 0.0), DM_ERROR_SIZE, "spheres.edges");
    refused(
        spheres(a, b, c + 1, 0.0),
        DM_ERROR_SIZE,
        "spheres.triangles",
    );
    wrong(spheres(a, b, c, f64::NAN), "time");
    let mut collider = dm_collider::default();
    wrong(
        unsafe { dm_collider_create(level, f64::INFINITY, &mut collider) },
        "time",
    );
    fine(unsafe { dm_collider_create(level, 0.0, &mut collider) });
    let (mut segments, mut hits) = ([0f64; 14], [0f64; 14]);
    segments[13] = -1.0;
    let sweeps = |count| dm_sweeps {
        count,
        segments: segments.as_ptr(),
        hits: hits.as_mut_ptr(),
        states: null_mut(),
        ..sized()
    };
    let mut sweeps = sweeps;
    let (two, many, one) = (sweeps(2), sweeps(!0), sweeps(1));
    wrong(unsafe { dm_collider_sweep(collider, &two) }, "row 1");
    wrong(
        unsafe { dm_collider_sweep(collider, &many) },
        "sweeps.count",
    );
    fine(unsafe { dm_collider_sweep(collider, &one) });
    let context = skin::context(&calls::cpu());
    let mut bad = cloud();
    bad[3].radius = -1.0;
    let new = |desc: &dm_particles_desc, settings: *const dm_particle_settings| unsafe {
        let out = &mut dm_particles::default();
        dm_particles_create(context, level, 0.0, desc, settings, out)
    };
    let (desc, _arrays) = described(&bad);
    wrong(new(&desc, null()), "particle 3");
    let (desc, _arrays) = described(&cloud());
    wrong(
        new(&dm_particles_desc { count: 0, ..desc }, null()),
        "desc.count",
    );
    let mut settings: dm_particle_settings = sized();
    fine(unsafe { dm_particle_settings_default(&mut settings) });
    for (settings, named) in [
        (
            dm_particle_settings {
                contacts: 65,
                ..settings
            },
            "contacts",
        ),
        (
            dm_particle_settings {
                restitution: 1.1,
                ..settings
            },
            "restitution",
        ),
        (
            dm_particle_settings {
                reserved: 1,
                ..settings
            },
            "reserved",
        ),
    ] {
        wrong(new(&desc, &settings), named);
    }
    let particles = made(context, level, &cloud());
    wrong(dm_particles_advance(particles, 0.0, 0.0), "seconds");
    wrong(dm_particles_advance(particles, f64::NAN, 0.1), "time");
    wrong(dm_particles_place(particles, f64::NAN), "time");
    let short = dm_flights {
        count: 3,
        ..sized()
    };
    refused(
        unsafe { dm_particles_read(particles, &short) },
        DM_ERROR_SIZE,
        "flights.count",
    );
    let less = dm_particles_desc { count: 3, ..desc };
    wrong(unsafe { dm_particles_write(particles, &less) }, "3 for 20");
    let record = unsafe {
        let commands = std::ptr::without_provenance_mut(8);
        dm_particles_record(particles, commands, 0, 0.0, 0.1, dm_output::default())
    };
    wrong(record, "cpu");
    fine(dm_particles_destroy(particles));
    fine(dm_collider_destroy(collider));
    fine(dm_level_destroy(level));
    fine(dm_sphere_mesh_destroy(mesh));
    fine(dm_context_destroy(context));
}
