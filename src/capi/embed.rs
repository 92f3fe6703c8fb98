//! Frames in a host's command buffer.

use std::ffi::c_void;

use ash::vk::{self, Handle as _};

use super::{
    context::gpu_of,
    deformer,
    guard::{Fault, Outcome, dm_result, guard},
    handle::{self, dm_context, dm_deformer, dm_output},
    pointer::{self, structs},
};
use crate::{
    deformer::{Normals, Output, VertexLayout},
    gpu::{Buffer, Gpu, Handover, HostCommands},
};

/// Number of frames that may be on the device at once: frame slots are below it.
pub const DM_FRAME_SLOTS: u32 = 2;

/// Format of normals: none are written.
pub const DM_NORMAL_NONE: u32 = 0;
/// Format of normals: three 32-bit floats.
pub const DM_NORMAL_F32: u32 = 1;
/// Format of normals: three signed normalised bytes and a byte of 0.
pub const DM_NORMAL_SNORM8: u32 = 2;

/// No other queue family.
pub const DM_SAME_FAMILY: u32 = u32::MAX;

/// How vertices lie in a buffer of the host's, and what reads them next. A vertex begins with its position, three 32-bit
/// floats in model space; what is not named here stays as it is. Offsets and stride in bytes, multiples of 4.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_output_desc {
    /// sizeof(dm_output_desc).
    pub size: u32,
    /// From vertex to vertex, at least 12.
    pub stride: u32,
    /// VkBuffer of the context's device, made for storage use.
    pub buffer: u64,
    /// Length of the buffer; dermis writes nothing behind it.
    pub bytes: u64,
    /// Where the first vertex begins.
    pub offset: u64,
    /// From a vertex's beginning to its normal, at least 12; 0 without normals.
    pub normal_offset: u32,
    /// DM_NORMAL_NONE, DM_NORMAL_F32 or DM_NORMAL_SNORM8.
    pub normal_format: u32,
    /// VkPipelineStageFlags that read the vertices next.
    pub stages: u32,
    /// VkAccessFlags of these.
    pub access: u32,
    /// Queue family that the buffer is released to after every frame, one of the device's or VK_QUEUE_FAMILY_EXTERNAL;
    /// DM_SAME_FAMILY for none. The host acquires it there, and before the next frame releases it there and acquires it for the
    /// context's family: what the frame does not write is lost otherwise.
    pub queue_family: u32,
    /// 0.
    pub reserved: u32,
    /// From the first vertex of an instance to that of the next; 0 where they follow each other, stride times vertices.
    pub instance_stride: u64,
}

structs!(dm_output_desc since instance_stride);

/// What an output's handle stands for.
pub(super) struct HostOutput {
    pub(super) output: Output,
    /// Number of the deformer's handle, or of the particles'.
    pub(super) source: u64,
}

/// Makes a buffer of the host's an output of a deformer: dm_frame_record writes one vertex for each of dm_rig_info.vertices, of
/// every instance.
///
/// context: the deformer's, made by dm_context_adopt or of the same device. desc: copied; the buffer stays the host's.
/// out: receives the handle, which is the caller's to destroy before the buffer.
///
/// Threads: any. Submits nothing.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_FOREIGN where the deformer is of another
/// context; DM_ERROR_ARGUMENT where the vertices do not fit, for a queue family that the device has not, or on the CPU;
/// DM_ERROR_MEMORY for a buffer longer than a shader can bind; DM_ERROR_VULKAN; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.
///
/// # Safety
/// desc and out are NULL or valid; the buffer is valid and as long as desc says until the output is destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_output_create(
    context: dm_context,
    deformer: dm_deformer,
    desc: *const dm_output_desc,
    out: *mut dm_output,
) -> dm_result {
    guard("dm_output_create", || {
        // SAFETY: the caller's promise.
        let desc = unsafe { pointer::read(desc, "desc")? };
        pointer::not_null(out, "out")?;
        let gpu = gpu_of(context)?;
        let mut layout = layout(&desc)?;
        // SAFETY: the caller's promise.
        let buffer = unsafe { host_buffer(&gpu, &desc)? };
        let output = deformer::with(deformer, |instance| {
            if instance.context != context {
                let message = "the deformer is of another context";
                return Err(Fault::new(dm_result::DM_ERROR_FOREIGN, message));
            }
            if layout.instance_stride == 0 {
                layout.instance_stride = layout.stride.saturating_mul(instance.rows() as u64);
            }
            Ok(instance
                .deformer
                .output(&buffer, &layout, &handover(&desc))?)
        })?;
        let source = deformer.id;
        let handle = handle::insert(HostOutput { output, source })?;
        // SAFETY: not NULL; the caller's promise.
        unsafe { pointer::put(out, handle) };
        Ok(())
    })
}

/// # Safety
/// The buffer is valid and as long as `desc` says until all handles to it are dropped.
pub(super) unsafe fn host_buffer(gpu: &Gpu, desc: &dm_output_desc) -> Outcome<Buffer> {
    let raw = vk::Buffer::from_raw(desc.buffer);
    // SAFETY: the caller's promise.
    Ok(unsafe { gpu.host_buffer(raw, "host_vertices", desc.bytes)? })
}

pub(super) fn layout(desc: &dm_output_desc) -> Outcome<VertexLayout> {
    let at = u64::from(desc.normal_offset);
    let normals = match desc.normal_format {
        DM_NORMAL_NONE => Normals::None,
        DM_NORMAL_F32 => Normals::Float(at),
        DM_NORMAL_SNORM8 => Normals::Byte(at),
        other => {
            let reason = format!("{other} is no format");
            return Err(Fault::argument("desc.normal_format", reason));
        }
    };
    if desc.reserved != 0 {
        return Err(Fault::argument("desc.reserved", "it has to be 0"));
    }
    Ok(VertexLayout {
        offset: desc.offset,
        stride: u64::from(desc.stride),
        instance_stride: desc.instance_stride,
        normals,
    })
}

pub(super) fn handover(desc: &dm_output_desc) -> Handover {
    let stages = match desc.stages {
        0 => vk::PipelineStageFlags::ALL_COMMANDS,
        stages => vk::PipelineStageFlags::from_raw(stages),
    };
    Handover {
        stages,
        access: vk::AccessFlags::from_raw(desc.access),
        family: (desc.queue_family != DM_SAME_FAMILY).then_some(desc.queue_family),
    }
}

/// # Safety
/// The command buffer is NULL, or a primary one that is being recorded outside of a render pass and of queries as long as the
/// handle is used.
pub(super) unsafe fn host_commands(command_buffer: *mut c_void) -> Outcome<HostCommands> {
    pointer::not_null(command_buffer, "command_buffer")?;
    // SAFETY: the caller's promise.
    Ok(unsafe { HostCommands::new(vk::CommandBuffer::from_raw(command_buffer as u64)) })
}

/// Destroys an output; the buffer stays as it is. The commands that were recorded with it have to be done.
///
/// Threads: any; a call that uses it on another thread completes first.
///
/// Returns DM_OK, or DM_ERROR_HANDLE where there is no such output (any more).
#[unsafe(no_mangle)]
pub extern "C" fn dm_output_destroy(output: dm_output) -> dm_result {
    guard("dm_output_destroy", || handle::destroy(output))
}

/// Records a frame into a command buffer of the host's: what dm_deformer_advance submits, and the writing of the output.
/// Submits nothing, waits for nothing, allocates nothing.
///
/// State before: the command buffer (VkCommandBuffer), a primary one, is being recorded, outside of a render pass and of
/// queries, for the family of the context's queue. Whatever was submitted to the queue before comes first, by a barrier. State
/// after: secondary command buffers have been executed, so that no pipeline, descriptor set or other state is bound any more;
/// the output's vertices are visible to the stages and accesses of its description, or released to its queue family.
///
/// The host submits the command buffer to the context's queue, once, and poses in the order of their recording.
///
/// matrices, count: as in dm_deformer_advance, the poses of all instances. output: of this deformer, or zero for none.
/// frame_slot: below DM_FRAME_SLOTS; what was recorded with it before has to be done, since its pose is overwritten.
///
/// Threads: any that may record into the command buffer.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_FOREIGN where the output is of another deformer; DM_ERROR_SIZE;
/// DM_ERROR_POSE; DM_ERROR_ARGUMENT for the slot, or on the CPU; DM_ERROR_DEVICE_LOST where another call has found it;
/// DM_ERROR_PANIC. Where it is not DM_OK nothing is recorded.
///
/// # Safety
/// The command buffer is NULL or in the state above; deformer and output are not destroyed before it is done; matrices is
/// NULL or has 16 times count numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_frame_record(
    deformer: dm_deformer,
    command_buffer: *mut c_void,
    frame_slot: u32,
    matrices: *const f32,
    count: usize,
    output: dm_output,
) -> dm_result {
    guard("dm_frame_record", || {
        // SAFETY: the caller's promise.
        let commands = unsafe { host_commands(command_buffer)? };
        let record = |output: Option<&mut Output>| {
            deformer::with(deformer, |instance| {
                // SAFETY: the caller's promise.
                unsafe { instance.set_poses(matrices, count)? };
                let slot = frame_slot as usize;
                let (deformer, poses) = (&mut instance.deformer, &instance.poses);
                Ok(deformer.record(&commands, slot, poses, output)?)
            })
        };
        if output.id == 0 {
            return record(None);
        }
        handle::with(output, |host| {
            if host.source != deformer.id {
                handle::get(deformer)?;
                let message = "the output is of another deformer";
                return Err(Fault::new(dm_result::DM_ERROR_FOREIGN, message));
            }
            record(Some(&mut host.output))
        })
    })
}
