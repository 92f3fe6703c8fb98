//! On a host's device: the skin in its vertex buffer is the skin that is read, misuse is refused, and nothing is left behind.
// Pointers are NULL or to what lives until the call returns; Vulkan's handles live as long as the host.
#![allow(clippy::undocumented_unsafe_blocks)]

use std::ptr::{null, null_mut};

use ash::vk::Handle as _;
use dermis::capi::{dm_result::*, *};

use crate::{fine, host_device::HostDevice, last_error, no_gpu, raw};

#[track_caller]
fn refused(result: dm_result, wanted: dm_result, named: &str) {
    assert_eq!(result, wanted, "{}", last_error());
    assert!(last_error().contains(named), "{named}: {}", last_error());
}

/// A context on a host's device, called directly, the arm, and a deformer.
pub(crate) fn arm(host: &HostDevice) -> (dm_context, dm_rig, dm_deformer, dm_rig_info) {
    arm_of(&host.vulkan())
}

/// A context on a host's device, the arm, and a deformer.
pub(crate) fn arm_of(desc: &dm_vulkan_desc) -> (dm_context, dm_rig, dm_deformer, dm_rig_info) {
    let (mut context, mut rig) = (dm_context::default(), dm_rig::default());
    let mut deformer = dm_deformer::default();
    let mut info = dm_rig_info {
        size: size_of::<dm_rig_info>() as u32,
        ..Default::default()
    };
    unsafe {
        fine(dm_context_adopt(desc, &mut context));
        fine(dm_rig_load(raw::path().as_ptr(), null(), &mut rig));
        fine(dm_rig_get_info(rig, &mut info));
        fine(dm_deformer_create(context, rig, null(), &mut deformer));
    }
    (context, rig, deformer, info)
}

#[test]
fn a_host_gets_its_skin_and_its_device_back_as_it_was() {
    if no_gpu() {
        return;
    }
    let host = HostDevice::new();
    let (context, rig, deformer, info) = arm(&host);
    let mut out = dm_output::default();
    let (joints, vertices) = (info.joints as usize, info.vertices as usize);
    let mut pose = vec![0f32; 16 * joints];
    let mut memory = dm_memory {
        size: size_of::<dm_memory>() as u32,
        ..Default::default()
    };
    let mut positions = vec![0f32; 3 * vertices];
    unsafe {
        fine(dm_output_create(
            context,
            deformer,
            &host.output(),
            &mut out,
        ));
        for slot in [0, 1, 0] {
            let seconds = 0.3 + slot as f32;
            fine(dm_rig_pose_clip(rig, 0, seconds, pose.as_mut_ptr(), joints));
            let commands = host.commands.as_raw() as *mut _;
            let pose = pose.as_ptr();
            host.run(|| fine(dm_frame_record(deformer, commands, slot, pose, joints, out)));
        }
        let mut skin: dm_skin = std::mem::zeroed();
        skin.size = size_of::<dm_skin>() as u32;
        (skin.vertices, skin.positions) = (info.vertices, positions.as_mut_ptr());
        fine(dm_deformer_read(deformer, &skin));
        fine(dm_output_destroy(out));
        fine(dm_deformer_destroy(deformer));
        fine(dm_context_memory(context, &mut memory));
        fine(dm_context_destroy(context));
        fine(dm_rig_destroy(rig));
    }
    assert_eq!((memory.total, memory.buffers), (0, 0));
    let words = host.words(6 * vertices);
    let written = words.chunks(6).flat_map(|v| v[..3].to_vec());
    assert!(written.eq(positions.iter().map(|x| x.to_bits())));
    assert_eq!(host.end(), Vec::<String>::new());
}

#[test]
fn a_host_gets_the_skins_of_several_instances_from_one_call() {
    if no_gpu() {
        return;
    }
    let host = HostDevice::new();
    let (context, rig, one, info) = arm(&host);
    fine(dm_deformer_destroy(one));
    let (joints, vertices) = (info.joints as usize, info.vertices as usize);
    let seconds = [0.2f32, 0.9, 0.5];
    let mut poses = vec![0f32; 16 * joints * seconds.len()];
    for (pose, seconds) in poses.chunks_mut(16 * joints).zip(seconds) {
        fine(unsafe { dm_rig_pose_clip(rig, 0, seconds, pose.as_mut_ptr(), joints) });
    }
    let (mut deformer, mut out) = (dm_deformer::default(), dm_output::default());
    let apart = 24 * vertices as u64 + 48;
    unsafe {
        let mut settings: dm_settings = std::mem::zeroed();
        settings.size = size_of::<dm_settings>() as u32;
        fine(dm_settings_default(&mut settings));
        settings.instances = seconds.len() as u32;
        fine(dm_deformer_create(context, rig, &settings, &mut deformer));
        let mut desc = host.output();
        desc.instance_stride = apart - 72;
        let created = dm_output_create(context, deformer, &desc, &mut out);
        refused(created, DM_ERROR_ARGUMENT, "in the next one");
        desc.instance_stride = apart;
        desc.bytes = 2 * apart + 24 * vertices as u64 - 4;
        let created = dm_output_create(context, deformer, &desc, &mut out);
        refused(created, DM_ERROR_ARGUMENT, "each of 3 instances");
        desc.bytes += 4;
        fine(dm_output_create(context, deformer, &desc, &mut out));
        let commands = host.commands.as_raw() as *mut _;
        let record = |count| dm_frame_record(deformer, commands, 0, poses.as_ptr(), count, out);
        refused(record(joints), DM_ERROR_SIZE, "count");
        host.run(|| fine(record(3 * joints)));
    }
    let words = host.words(2 * apart as usize / 4 + 6 * vertices);
    for instance in 0..3 {
        let mut positions = vec![0f32; 3 * vertices];
        let mut skin: dm_skin = unsafe { std::mem::zeroed() };
        skin.size = size_of::<dm_skin>() as u32;
        (skin.vertices, skin.positions) = (info.vertices, positions.as_mut_ptr());
        skin.instance = instance;
        fine(unsafe { dm_deformer_read(deformer, &skin) });
        let first = instance as usize * apart as usize / 4;
        let written = words[first..].chunks(6).take(vertices);
        let written = written.flat_map(|v| v[..3].to_vec());
        assert!(
            written.eq(positions.iter().map(|x| x.to_bits())),
            "{instance}"
        );
        skin.instance = 3;
        refused(
            unsafe { dm_deformer_read(deformer, &skin) },
            DM_ERROR_ARGUMENT,
            "3, counted from 0, of 3",
        );
    }
    fine(dm_output_destroy(out));
    fine(dm_deformer_destroy(deformer));
    fine(dm_context_destroy(context));
    fine(dm_rig_destroy(rig));
    assert_eq!(host.end(), Vec::<String>::new());
}

#[test]
fn misuse_of_a_hosts_device_is_refused() {
    if no_gpu() {
        return;
    }
    let host = HostDevice::new();
    let (context, rig, deformer, info) = arm(&host);
    let (mut out, mut none) = (dm_output::default(), dm_context::default());
    let adopt = |change: &dyn Fn(&mut dm_vulkan_desc)| {
        let mut desc = host.vulkan();
        change(&mut desc);
        unsafe { dm_context_adopt(&desc, &mut dm_context::default()) }
    };
    refused(adopt(&|d| d.size = 4), DM_ERROR_STRUCT_SIZE, "size is 4");
    refused(adopt(&|d| d.api_version = 9), DM_ERROR_VERSION, "9");
    let untrue = adopt(&|d| d.features = DM_FEATURE_SYNCHRONIZATION2);
    refused(untrue, DM_ERROR_ARGUMENT, "vkCmdPipelineBarrier2KHR");
    refused(
        adopt(&|d| d.features = 1 << 9),
        DM_ERROR_ARGUMENT,
        "features",
    );
    refused(
        adopt(&|d| d.queue_family = 99),
        DM_ERROR_ARGUMENT,
        "queue_family",
    );
    refused(
        adopt(&|d| d.device = null_mut()),
        DM_ERROR_NULL,
        "desc.device",
    );
    refused(
        adopt(&|d| d.queue = null_mut()),
        DM_ERROR_NULL,
        "desc.queue",
    );
    let no_loader = adopt(&|d| d.get_instance_proc_addr = None);
    refused(no_loader, DM_ERROR_NULL, "get_instance_proc_addr");
    let create = |change: &dyn Fn(&mut dm_output_desc)| {
        let mut desc = host.output();
        change(&mut desc);
        unsafe { dm_output_create(context, deformer, &desc, &mut dm_output::default()) }
    };
    refused(create(&|d| d.size = 0), DM_ERROR_STRUCT_SIZE, "size is 0");
    refused(create(&|d| d.bytes = 100), DM_ERROR_ARGUMENT, "end at byte");
    refused(
        create(&|d| d.stride = 14),
        DM_ERROR_ARGUMENT,
        "multiple of 4",
    );
    refused(
        create(&|d| d.normal_format = 7),
        DM_ERROR_ARGUMENT,
        "normal_format",
    );
    refused(create(&|d| d.reserved = 1), DM_ERROR_ARGUMENT, "reserved");
    refused(create(&|d| d.buffer = 0), DM_ERROR_MEMORY, "handle");
    let joints = info.joints as usize;
    let pose = glam::Mat4::IDENTITY.to_cols_array().repeat(joints);
    let commands = host.commands.as_raw() as *mut _;
    unsafe {
        let wanted = dm_vulkan_get_requirements(None, null_mut(), null_mut(), null_mut());
        refused(wanted, DM_ERROR_NULL, "out");
        refused(dm_context_adopt(null(), &mut none), DM_ERROR_NULL, "desc");
        refused(
            dm_context_adopt(&host.vulkan(), null_mut()),
            DM_ERROR_NULL,
            "out",
        );
        let mut wanted: dm_vulkan_requirements = std::mem::zeroed();
        wanted.size = size_of::<dm_vulkan_requirements>() as u32;
        let raw = host.vulkan();
        fine(dm_vulkan_get_requirements(
            raw.get_instance_proc_addr,
            raw.instance,
            raw.physical_device,
            &mut wanted,
        ));
        assert!(wanted.extension_count <= 8 && wanted.queue_family == 0);
        let created = dm_output_create(dm_context::default(), deformer, &host.output(), &mut out);
        refused(created, DM_ERROR_HANDLE, "zero");
        let mut second = dm_context::default();
        fine(dm_context_adopt(&host.vulkan(), &mut second));
        let created = dm_output_create(second, deformer, &host.output(), &mut out);
        refused(created, DM_ERROR_FOREIGN, "another context");
        fine(dm_context_destroy(second));
        let mut other = dm_deformer::default();
        fine(dm_deformer_create(context, rig, null(), &mut other));
        fine(dm_output_create(context, other, &host.output(), &mut out));
        let record = |commands, slot, pose: &[f32], count, out| {
            dm_frame_record(deformer, commands, slot, pose.as_ptr(), count, out)
        };
        let zero = dm_output::default();
        refused(
            record(commands, 0, &pose, joints, out),
            DM_ERROR_FOREIGN,
            "another deformer",
        );
        refused(
            record(commands, 2, &pose, joints, zero),
            DM_ERROR_ARGUMENT,
            "2 of 2",
        );
        refused(record(commands, 0, &pose, 1, zero), DM_ERROR_SIZE, "count");
        refused(
            record(null_mut(), 0, &pose, joints, zero),
            DM_ERROR_NULL,
            "command_buffer",
        );
        let mut broken = pose.clone();
        broken[5] = f32::NAN;
        refused(
            record(commands, 0, &broken, joints, zero),
            DM_ERROR_POSE,
            "joint",
        );
        fine(dm_output_destroy(out));
        refused(dm_output_destroy(out), DM_ERROR_HANDLE, "destroyed");
        refused(
            record(commands, 0, &pose, joints, out),
            DM_ERROR_HANDLE,
            "destroyed",
        );
        fine(dm_deformer_destroy(other));
        fine(dm_deformer_destroy(deformer));
        refused(
            record(commands, 0, &pose, joints, zero),
            DM_ERROR_HANDLE,
            "destroyed",
        );
        fine(dm_context_destroy(context));
        fine(dm_rig_destroy(rig));
    }
    host.end();
}
