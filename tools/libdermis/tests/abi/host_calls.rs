//! The functions that need a host's device, with one set of arguments that works and a way to spoil each of them.
// Pointers are NULL or to what lives until the call returns; Vulkan's handles live as long as the host.
#![allow(clippy::undocumented_unsafe_blocks)]

use ash::vk::Handle as _;
use dermis::capi::*;

use crate::{
    calls::{
        Arguments, Call, Storage,
        Takes::{Context, Deformer, Nothing, Output, Particles},
        call, made,
    },
    fine, host,
    host_device::HostDevice,
    misuse::{sweep_arguments, sweep_handles},
    no_gpu,
};

unsafe extern "C" fn on_device(_user: *mut std::ffi::c_void, _device: *const dm_device_info) {}

/// The context, deformer and output of the arguments are on the host's device.
#[rustfmt::skip]
pub(crate) const HOST_CALLS: &[Call] = &[
    call("dm_context_adopt", Nothing, true, true, |a| unsafe {
        let mut desc = a.host().vulkan();
        desc.size = a.size::<dm_vulkan_desc>();
        if a.is_null(false) {
            desc.get_instance_proc_addr = None;
        }
        desc.instance = a.of(desc.instance);
        desc.physical_device = a.of(desc.physical_device);
        desc.device = a.of(desc.device);
        desc.queue = a.of(desc.queue);
        let mut out = dm_context::default();
        let result = dm_context_adopt(a.of(&mut desc), a.of(&mut out));
        made(result, || dm_context_destroy(out))
    }),
    call("dm_devices", Nothing, true, false, |a| unsafe {
        let report: dm_device_report = if a.is_null(false) { None } else { Some(on_device) };
        dm_devices(report, std::ptr::null_mut())
    }),
    call("dm_vulkan_get_requirements", Nothing, true, true, |a| unsafe {
        let raw = a.host().vulkan();
        let get = if a.is_null(false) { None } else { raw.get_instance_proc_addr };
        let mut out: dm_vulkan_requirements = std::mem::zeroed();
        out.size = a.size::<dm_vulkan_requirements>();
        dm_vulkan_get_requirements(get, a.of(raw.instance), a.of(raw.physical_device), a.of(&mut out))
    }),
    call("dm_output_create", Context, true, true, |a| unsafe {
        let mut desc = a.host().output();
        desc.size = a.size::<dm_output_desc>();
        let mut out = dm_output::default();
        let result = dm_output_create(a.context, a.deformer, a.of(&mut desc), a.of(&mut out));
        made(result, || dm_output_destroy(out))
    }),
    call("dm_particles_output", Context, true, true, |a| unsafe {
        let mut desc = a.host().output();
        desc.size = a.size::<dm_output_desc>();
        let mut out = dm_output::default();
        let result = dm_particles_output(a.context, a.particles, a.of(&mut desc), a.of(&mut out));
        made(result, || dm_output_destroy(out))
    }),
    call("dm_particles_record", Particles, true, false, |a| {
        let commands = a.of(a.host().commands.as_raw() as *mut _);
        let mut result = dm_result::DM_OK;
        a.host().run(|| {
            result = unsafe { dm_particles_record(a.particles, commands, 0, 1.0, 0.1, a.output) };
        });
        result
    }),
    call("dm_output_destroy", Output, false, false, |a| dm_output_destroy(a.output)),
    call("dm_frame_record", Deformer, true, false, |a| {
        let commands = a.of(a.host().commands.as_raw() as *mut _);
        let pose = a.from(&a.storage.numbers);
        let mut result = dm_result::DM_OK;
        a.host().run(|| {
            result = unsafe {
                dm_frame_record(a.deformer, commands, 0, pose, a.storage.joints, a.output)
            };
        });
        result
    }),
];

#[test]
fn every_function_on_a_hosts_device_refuses_what_is_wrong() {
    if no_gpu() {
        return;
    }
    let host = HostDevice::new();
    let (context, rig, deformer, info) = host::arm(&host);
    let mut output = dm_output::default();
    // SAFETY: the host's buffer is as long as the description says.
    fine(unsafe { dm_output_create(context, deformer, &host.output(), &mut output) });
    let identity = glam::Mat4::IDENTITY.to_cols_array();
    let storage = Storage {
        numbers: identity.repeat(info.joints as usize),
        joints: info.joints as usize,
        vertices: info.vertices,
        ..Storage::default()
    };
    let mut a = Arguments::new((context, rig, deformer), storage);
    a.fill_spheres();
    let mut flights = dm_output::default();
    // SAFETY: as above.
    let made = unsafe { dm_particles_output(context, a.particles, &host.output(), &mut flights) };
    fine(made);
    a.host = Some(host);
    for call in HOST_CALLS {
        a.output = match call.name {
            "dm_particles_record" => flights,
            _ => output,
        };
        if call.name != "dm_output_destroy" {
            sweep_arguments(call, &mut a);
        }
        sweep_handles(call, &mut a);
    }
    for output in [output, flights] {
        fine(dm_output_destroy(output));
    }
    a.clear_spheres();
    fine(dm_deformer_destroy(deformer));
    fine(dm_rig_destroy(rig));
    fine(dm_context_destroy(context));
    assert_eq!(a.host.take().unwrap().end(), Vec::<String>::new());
}
