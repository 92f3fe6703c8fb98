//! What a frame records to hand its buffer over, seen through functions of the host's between dermis and the driver.
//!
//! lavapipe has one queue family. `VK_QUEUE_FAMILY_EXTERNAL` is another to it: validation follows the release and the host's
//! own acquisition as it would follow those between two families.
// Pointers are to what lives until the call returns; Vulkan's handles live as long as the host.
#![allow(clippy::undocumented_unsafe_blocks)]

use std::{
    ffi::{CStr, c_char, c_void},
    sync::{Mutex, OnceLock},
};

use ash::vk::{self, Handle as _};
use dermis::capi::{dm_result::*, *};

use crate::{
    fine,
    host::arm_of,
    host_device::{BYTES, HostDevice},
    last_error, no_gpu,
};

/// A command that matters here, in the order of recording.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Recorded {
    Dispatch,
    /// A barrier over all memory: to what.
    Memory(vk::PipelineStageFlags, vk::AccessFlags),
    /// A barrier on a buffer.
    Buffer(Buffer),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Buffer {
    stages: (vk::PipelineStageFlags, vk::PipelineStageFlags),
    access: (vk::AccessFlags, vk::AccessFlags),
    families: (u32, u32),
    buffer: vk::Buffer,
    range: (u64, u64),
}

/// A function before it is cast to its own type.
type Any = unsafe extern "system" fn();

/// The functions that stand behind ours, and what went through them. One test uses this.
struct Real {
    get_instance: OnceLock<dm_get_instance_proc_addr>,
    get_device: OnceLock<vk::PFN_vkGetDeviceProcAddr>,
    barrier: OnceLock<vk::PFN_vkCmdPipelineBarrier>,
    dispatch: OnceLock<vk::PFN_vkCmdDispatch>,
    indirect: OnceLock<vk::PFN_vkCmdDispatchIndirect>,
}

static REAL: Real = Real {
    get_instance: OnceLock::new(),
    get_device: OnceLock::new(),
    barrier: OnceLock::new(),
    dispatch: OnceLock::new(),
    indirect: OnceLock::new(),
};
static RECORDED: Mutex<Vec<Recorded>> = Mutex::new(Vec::new());

fn keep(recorded: Recorded) {
    RECORDED.lock().unwrap().push(recorded);
}

unsafe extern "system" fn dispatch(commands: vk::CommandBuffer, x: u32, y: u32, z: u32) {
    keep(Recorded::Dispatch);
    unsafe { REAL.dispatch.get().unwrap()(commands, x, y, z) }
}

unsafe extern "system" fn indirect(commands: vk::CommandBuffer, buffer: vk::Buffer, offset: u64) {
    keep(Recorded::Dispatch);
    unsafe { REAL.indirect.get().unwrap()(commands, buffer, offset) }
}

#[allow(clippy::too_many_arguments)]
unsafe extern "system" fn barrier(
    commands: vk::CommandBuffer,
    from: vk::PipelineStageFlags,
    to: vk::PipelineStageFlags,
    flags: vk::DependencyFlags,
    memory_count: u32,
    memory: *const vk::MemoryBarrier<'_>,
    buffer_count: u32,
    buffers: *const vk::BufferMemoryBarrier<'_>,
    image_count: u32,
    images: *const vk::ImageMemoryBarrier<'_>,
) {
    for row in 0..memory_count as usize {
        let memory = unsafe { &*memory.add(row) };
        keep(Recorded::Memory(to, memory.dst_access_mask));
    }
    for row in 0..buffer_count as usize {
        let b = unsafe { &*buffers.add(row) };
        keep(Recorded::Buffer(Buffer {
            stages: (from, to),
            access: (b.src_access_mask, b.dst_access_mask),
            families: (b.src_queue_family_index, b.dst_queue_family_index),
            buffer: b.buffer,
            range: (b.offset, b.size),
        }));
    }
    unsafe {
        REAL.barrier.get().unwrap()(
            commands,
            from,
            to,
            flags,
            memory_count,
            memory,
            buffer_count,
            buffers,
            image_count,
            images,
        )
    }
}

unsafe extern "system" fn get_device(
    device: vk::Device,
    name: *const c_char,
) -> vk::PFN_vkVoidFunction {
    let found = unsafe { REAL.get_device.get().unwrap()(device, name) }?;
    // The types are those that Vulkan gives to functions of these names.
    unsafe {
        Some(match CStr::from_ptr(name).to_bytes() {
            b"vkCmdPipelineBarrier" => {
                REAL.barrier.get_or_init(|| std::mem::transmute(found));
                std::mem::transmute::<vk::PFN_vkCmdPipelineBarrier, Any>(barrier)
            }
            b"vkCmdDispatch" => {
                REAL.dispatch.get_or_init(|| std::mem::transmute(found));
                std::mem::transmute::<vk::PFN_vkCmdDispatch, Any>(dispatch)
            }
            b"vkCmdDispatchIndirect" => {
                REAL.indirect.get_or_init(|| std::mem::transmute(found));
                std::mem::transmute::<vk::PFN_vkCmdDispatchIndirect, Any>(indirect)
            }
            _ => found,
        })
    }
}

unsafe extern "system" fn get_instance(instance: *mut c_void, name: *const c_char) -> dm_function {
    unsafe {
        let found = REAL.get_instance.get().unwrap().unwrap()(instance, name)?;
        if CStr::from_ptr(name) != c"vkGetDeviceProcAddr" {
            return Some(found);
        }
        REAL.get_device.get_or_init(|| std::mem::transmute(found));
        Some(std::mem::transmute::<vk::PFN_vkGetDeviceProcAddr, Any>(
            get_device,
        ))
    }
}

/// The host's side: takes the buffer back for the queue that dermis records for.
fn acquire(host: &HostDevice) {
    let barrier = [vk::BufferMemoryBarrier::default()
        .buffer(host.buffer)
        .size(BYTES)
        .dst_access_mask(vk::AccessFlags::SHADER_WRITE)
        .src_queue_family_index(vk::QUEUE_FAMILY_EXTERNAL)
        .dst_queue_family_index(0)];
    unsafe {
        host.device.cmd_pipeline_barrier(
            host.commands,
            vk::PipelineStageFlags::TOP_OF_PIPE,
            vk::PipelineStageFlags::COMPUTE_SHADER,
            vk::DependencyFlags::empty(),
            &[],
            &barrier,
            &[],
        );
    }
}

#[test]
fn a_buffer_is_handed_over_as_its_description_says() {
    if no_gpu() {
        return;
    }
    let host = HostDevice::new();
    REAL.get_instance
        .get_or_init(|| host.vulkan().get_instance_proc_addr);
    let mut through = host.vulkan();
    through.get_instance_proc_addr = Some(get_instance);
    let (context, rig, deformer, info) = arm_of(&through);
    let (joints, vertices) = (info.joints as usize, info.vertices as usize);
    let mut pose = vec![0f32; 16 * joints];
    let create = |queue_family| {
        let (mut out, desc) = (dm_output::default(), host.output());
        let desc = dm_output_desc {
            queue_family,
            ..desc
        };
        let result = unsafe { dm_output_create(context, deformer, &desc, &mut out) };
        (result, out)
    };
    // What the frames of an output record; between them the host takes the buffer back where it was given away.
    let mut play = |queue_family: u32| {
        let (created, out) = create(queue_family);
        fine(created);
        let mut frames = Vec::new();
        for slot in [0, 1, 0] {
            let commands = host.commands.as_raw() as *mut _;
            let seconds = 0.3 + slot as f32 + frames.len() as f32;
            host.run(|| unsafe {
                if queue_family == vk::QUEUE_FAMILY_EXTERNAL && !frames.is_empty() {
                    acquire(&host);
                }
                fine(dm_rig_pose_clip(rig, 0, seconds, pose.as_mut_ptr(), joints));
                RECORDED.lock().unwrap().clear();
                fine(dm_frame_record(
                    deformer,
                    commands,
                    slot,
                    pose.as_ptr(),
                    joints,
                    out,
                ));
            });
            frames.push(std::mem::take(&mut *RECORDED.lock().unwrap()));
        }
        fine(dm_output_destroy(out));
        frames
    };
    let visible = Recorded::Memory(
        vk::PipelineStageFlags::VERTEX_INPUT,
        vk::AccessFlags::VERTEX_ATTRIBUTE_READ,
    );
    // A buffer that stays in the family is made visible, all of memory at once.
    for frame in [DM_SAME_FAMILY, 0].into_iter().flat_map(&mut play) {
        assert_eq!(frame[frame.len() - 2..], [Recorded::Dispatch, visible]);
        let of_buffer = |r: &&Recorded| matches!(r, Recorded::Buffer(_));
        assert_eq!(frame.iter().filter(of_buffer).count(), 0);
    }
    // One that leaves is released, all of it and once, after everything that is written; who acquires it says what it is for.
    let released = Recorded::Buffer(Buffer {
        stages: (
            vk::PipelineStageFlags::COMPUTE_SHADER,
            vk::PipelineStageFlags::BOTTOM_OF_PIPE,
        ),
        access: (vk::AccessFlags::SHADER_WRITE, vk::AccessFlags::empty()),
        families: (0, vk::QUEUE_FAMILY_EXTERNAL),
        buffer: host.buffer,
        range: (0, BYTES),
    });
    let frames = play(vk::QUEUE_FAMILY_EXTERNAL);
    assert_eq!(frames.len(), 3);
    for frame in frames {
        assert_eq!(frame[frame.len() - 2..], [Recorded::Dispatch, released]);
        assert_eq!(frame.iter().filter(|r| **r == released).count(), 1);
        assert!(!frame.contains(&visible));
    }
    // Taken back, it holds the skin.
    host.run(|| acquire(&host));
    let mut positions = vec![0f32; 3 * vertices];
    unsafe {
        let mut skin: dm_skin = std::mem::zeroed();
        skin.size = size_of::<dm_skin>() as u32;
        (skin.vertices, skin.positions) = (info.vertices, positions.as_mut_ptr());
        fine(dm_deformer_read(deformer, &skin));
    }
    let words = host.words(6 * vertices);
    let written = words.chunks(6).flat_map(|v| v[..3].to_vec());
    assert!(written.eq(positions.iter().map(|x| x.to_bits())));
    // A family that the device has not is refused.
    assert_eq!(create(99).0, DM_ERROR_ARGUMENT, "{}", last_error());
    assert!(last_error().contains("queue family"), "{}", last_error());
    fine(dm_deformer_destroy(deformer));
    fine(dm_context_destroy(context));
    fine(dm_rig_destroy(rig));
    assert_eq!(host.end(), Vec::<String>::new());
}
