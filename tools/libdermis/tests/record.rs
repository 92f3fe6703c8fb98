//! dm_frame_record allocates nothing, from the first frame on, whatever the method and the number of sub-steps; nor does
//! dm_particles_record.
// Pointers are NULL or to what lives until the call returns; Vulkan's handles live as long as the host.
#![allow(clippy::unwrap_used, clippy::undocumented_unsafe_blocks)]

#[path = "../../../tests/common/allocations.rs"]
mod allocations;
#[allow(dead_code, reason = "the other tests use the rest")]
#[path = "abi/host_device.rs"]
mod host_device;
#[path = "shared/stage.rs"]
mod stage;

use std::ptr::null;

use ash::vk::Handle as _;
use dermis::capi::*;

use host_device::HostDevice;
use stage::{Stage, adopt, fine, sized};

/// Turns of all joints but the root, in degrees: small ones, then further and further at once.
const TURNS: [f32; 8] = [5.0, 10.0, 8.0, 40.0, -20.0, 70.0, -90.0, 60.0];

#[test]
fn recording_a_frame_allocates_nothing() {
    if std::env::var("DERMIS_NO_GPU").is_ok_and(|v| v == "1") {
        eprintln!("skipped: DERMIS_NO_GPU=1");
        return;
    }
    let host = HostDevice::with_layers(&[]);
    for method in [DM_LBS, DM_DQS, DM_IMPLICIT, DM_TRACKING] {
        let stage = Stage::new(&host, "arm", method);
        let mut substeps = Vec::new();
        for (frame, turn) in TURNS.into_iter().enumerate() {
            let pose = stage.turned(turn);
            host.run(|| {
                let before = allocations::so_far();
                stage.record(frame as u32 % 2, &pose);
                let allocated = allocations::so_far() - before;
                assert_eq!(allocated, 0, "method {method}, frame {frame}");
            });
            substeps.push(stage.iterations().substeps);
        }
        if method == DM_TRACKING {
            assert!(substeps[TURNS.len() - 2] > 4, "{substeps:?}");
        }
        stage.end();
    }
    particles(&host);
    allocations::are_counted();
    host.end();
}

/// Particles over a box that grows, with an output.
fn particles(host: &HostDevice) {
    let corner = |i: u32| [0, 1, 2].map(|axis| (i >> axis & 1) as f32);
    let frames = [1.0f32, 1.5].map(|scale| (0..8).map(move |i| corner(i).map(|x| x * scale)));
    let positions: Vec<[f32; 3]> = frames.into_iter().flatten().collect();
    let indices: [[u32; 3]; 4] = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6]];
    let mut sequence = sized::<dm_sequence_desc>();
    (sequence.vertices, sequence.triangles, sequence.frames) = (8, 4, 2);
    sequence.positions = positions.as_ptr().cast();
    sequence.indices = indices.as_ptr().cast();
    let places = [[0.5f32, 2.0, 0.5, 0.1]; 70];
    let mut desc = sized::<dm_particles_desc>();
    (desc.count, desc.positions) = (70, places.as_ptr().cast());
    let context = adopt(host);
    let (mut mesh, mut level) = (dm_sphere_mesh::default(), dm_level::default());
    let (mut flying, mut output) = (dm_particles::default(), dm_output::default());
    unsafe {
        fine(dm_sphere_mesh_build(&sequence, null(), &mut mesh));
        fine(dm_level_create(mesh, 8, 0, &mut level));
        fine(dm_particles_create(
            context,
            level,
            0.0,
            &desc,
            null(),
            &mut flying,
        ));
        fine(dm_particles_output(
            context,
            flying,
            &host.output(),
            &mut output,
        ));
    }
    let commands = host.commands.as_raw() as *mut _;
    for frame in 0..6 {
        host.run(|| {
            let before = allocations::so_far();
            let (slot, time) = (frame % 2, 0.2 * f64::from(frame));
            fine(unsafe { dm_particles_record(flying, commands, slot, time, 0.1, output) });
            assert_eq!(allocations::so_far() - before, 0, "frame {frame}");
        });
    }
    fine(dm_output_destroy(output));
    fine(dm_particles_destroy(flying));
    fine(dm_level_destroy(level));
    fine(dm_sphere_mesh_destroy(mesh));
    fine(dm_context_destroy(context));
}
