//! Any call of Vulkan that can fail does: dermis answers with an error that names the call, leaves nothing behind, and goes on
//! as if nothing had been.
#![allow(clippy::unwrap_used)]

mod functions;
#[path = "../abi/host_device.rs"]
mod host_device;
#[cfg(target_os = "linux")]
mod owned;
#[allow(dead_code, reason = "the other tests use the rest")]
#[path = "../abi/raw.rs"]
mod raw;
mod scenario;
mod state;
mod sweep;

use std::{ffi::CStr, path::PathBuf, ptr::null};

use dermis::capi::{dm_result::*, *};

use host_device::HostDevice;
use scenario::{Character, Way};
use sweep::Codes;

/// The root of the workspace.
fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn last_error() -> String {
    // SAFETY: never NULL, and valid until the next call.
    let text = unsafe { CStr::from_ptr(dm_last_error()) };
    text.to_str().unwrap().to_owned()
}

#[track_caller]
fn fine(result: dm_result) {
    assert_eq!(result, DM_OK, "{}", last_error());
}

fn no_gpu() -> bool {
    let skip = std::env::var("DERMIS_NO_GPU").is_ok_and(|v| v == "1");
    if skip {
        eprintln!("skipped: DERMIS_NO_GPU=1");
    }
    skip
}

/// A tube of two joints, bent further from pose to pose; coarse, so that its fields take little time.
fn tube(method: u32) -> Character {
    let mesh = raw::Mesh::tube_of(5, 4);
    let mut rig = dm_rig::default();
    // SAFETY: the arrays are as long as the description says.
    fine(unsafe { dm_rig_create(&mesh.desc(), null(), &mut rig) });
    let mut info = dm_rig_info {
        size: size_of::<dm_rig_info>() as u32,
        ..Default::default()
    };
    // SAFETY: lives until the call returns.
    fine(unsafe { dm_rig_get_info(rig, &mut info) });
    assert_eq!(info.fields, 2);
    let pose = |degrees: f32| {
        let turn = glam::Mat4::from_rotation_z(degrees.to_radians());
        let local = [glam::Mat4::IDENTITY, turn].map(|m| m.to_cols_array());
        let mut matrices = vec![0f32; 32];
        // SAFETY: one matrix a joint in both.
        fine(unsafe { dm_rig_pose_local(rig, local.as_ptr().cast(), matrices.as_mut_ptr(), 2) });
        matrices
    };
    Character {
        rig,
        method,
        vertices: mesh.positions.len() as u32,
        poses: [8.0, 16.0, 24.0, 32.0, 40.0].map(pose).to_vec(),
        level: level(&mesh),
    }
}

/// Two spheres of the tube, which grows thick.
fn level(tube: &raw::Mesh) -> dm_level {
    let grown = |thick: f32| {
        let rows = tube.positions.iter();
        rows.map(move |[x, y, z]| [*x, y * thick, z * thick])
    };
    let positions: Vec<[f32; 3]> = [1.0, 1.5, 2.0].into_iter().flat_map(grown).collect();
    let desc = dm_sequence_desc {
        size: size_of::<dm_sequence_desc>() as u32,
        vertices: tube.positions.len() as u32,
        triangles: tube.indices.len() as u32,
        frames: 3,
        positions: positions.as_ptr().cast(),
        indices: tube.indices.as_ptr().cast(),
    };
    let (mut mesh, mut level) = (dm_sphere_mesh::default(), dm_level::default());
    // SAFETY: the arrays are as long as the description says.
    unsafe {
        fine(dm_sphere_mesh_build(&desc, null(), &mut mesh));
        fine(dm_level_create(mesh, 2, 0, &mut level));
    }
    fine(dm_sphere_mesh_destroy(mesh));
    level
}

/// On a device of the host's.
struct Adopted(HostDevice);

impl Way for Adopted {
    fn create(&self, out: &mut dm_context) -> dm_result {
        let desc = dm_vulkan_desc {
            get_instance_proc_addr: host_device::loader(functions::get_instance_proc_addr),
            log: Some(state::tell),
            ..self.0.vulkan()
        };
        // SAFETY: the host lives on.
        unsafe { dm_context_adopt(&desc, out) }
    }

    fn host(&self) -> Option<&HostDevice> {
        Some(&self.0)
    }
}

/// A host's own device.
fn adopted(method: u32, host: HostDevice, codes: Codes) {
    functions::load_from(host.entry.static_fn().get_instance_proc_addr);
    let character = tube(method);
    let way = Adopted(host);
    sweep::every_call(&way, &character, codes);
    if method == DM_TRACKING {
        sweep::broken_state(&way, &character);
    }
    fine(dm_rig_destroy(character.rig));
    fine(dm_level_destroy(character.level));
    for object in state::forget() {
        functions::destroy(&way.0.device, object);
    }
    assert_eq!(way.0.end(), Vec::<String>::new());
}

#[test]
fn on_a_hosts_device_any_call_may_fail() {
    if !no_gpu() {
        adopted(DM_IMPLICIT, HostDevice::with_layers(&[]), Codes::All);
    }
}

#[test]
fn on_a_hosts_device_any_call_may_fail_in_tracking() {
    if !no_gpu() {
        adopted(DM_TRACKING, HostDevice::with_layers(&[]), Codes::InTurn);
    }
}

/// Whatever fails, dermis uses Vulkan as it has to.
#[test]
fn on_a_validated_device_any_call_may_fail() {
    if !no_gpu() {
        adopted(DM_DQS, HostDevice::new(), Codes::All);
    }
}
