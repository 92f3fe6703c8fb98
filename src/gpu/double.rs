//! A device whose n-th fallible call fails, for tests: stands between dermis and the driver.

use std::{
    cell::Cell,
    ffi::{CStr, c_void},
    sync::atomic::{AtomicUsize, Ordering},
};

use ash::vk;

use super::{
    Features, Gpu, GpuOptions, features,
    instance::{Canary, Instance},
    physical,
    shared::{Owner, Shared},
};
use crate::Result;

thread_local! {
    /// Calls until the one that fails, and with what.
    static FAILURE: Cell<Option<(u32, vk::Result)>> = const { Cell::new(None) };
}

/// Lets the call after `calls` more of this thread fail with `code`.
pub(super) fn arm(calls: u32, code: vk::Result) {
    FAILURE.set(Some((calls, code)));
}

/// Lets no call fail; true where one was still to come.
pub(super) fn disarm() -> bool {
    FAILURE.take().is_some()
}

/// The code with which this call has to fail.
fn strike() -> Option<vk::Result> {
    let (calls, code) = FAILURE.get()?;
    FAILURE.set(calls.checked_sub(1).map(|calls| (calls, code)));
    (calls == 0).then_some(code)
}

/// For each call a function of the same type that asks [`strike`] first.
macro_rules! doubles {
    ($($double:ident, $name:literal, $pfn:ty, ($($argument:ident: $kind:ty),*);)*) => {
        $(mod $double {
            use super::*;

            pub(super) static REAL: AtomicUsize = AtomicUsize::new(0);

            pub(super) unsafe extern "system" fn double($($argument: $kind),*) -> vk::Result {
                if let Some(code) = strike() {
                    return code;
                }
                // SAFETY: `replace` stored the driver's function of this type before it gave out this one.
                let real: $pfn = unsafe { std::mem::transmute(REAL.load(Ordering::Relaxed)) };
                // SAFETY: the caller's arguments, passed on.
                unsafe { real($($argument),*) }
            }
        })*

        /// The double of a function, or the function itself where it has none.
        fn replace(name: &CStr, real: *const c_void) -> *const c_void {
            match name.to_bytes() {
                $(name if name == $name.as_bytes() => {
                    $double::REAL.store(real as usize, Ordering::Relaxed);
                    let double: $pfn = $double::double;
                    double as *const c_void
                })*
                _ => real,
            }
        }
    };
}

doubles! {
    allocate_command_buffers, "vkAllocateCommandBuffers", vk::PFN_vkAllocateCommandBuffers, (a: vk::Device, b: *const vk::CommandBufferAllocateInfo<'_>, c: *mut vk::CommandBuffer);
    allocate_descriptor_sets, "vkAllocateDescriptorSets", vk::PFN_vkAllocateDescriptorSets, (a: vk::Device, b: *const vk::DescriptorSetAllocateInfo<'_>, c: *mut vk::DescriptorSet);
    allocate_memory, "vkAllocateMemory", vk::PFN_vkAllocateMemory, (a: vk::Device, b: *const vk::MemoryAllocateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, d: *mut vk::DeviceMemory);
    begin_command_buffer, "vkBeginCommandBuffer", vk::PFN_vkBeginCommandBuffer, (a: vk::CommandBuffer, b: *const vk::CommandBufferBeginInfo<'_>);
    bind_buffer_memory, "vkBindBufferMemory", vk::PFN_vkBindBufferMemory, (a: vk::Device, b: vk::Buffer, c: vk::DeviceMemory, d: vk::DeviceSize);
    bind_image_memory, "vkBindImageMemory", vk::PFN_vkBindImageMemory, (a: vk::Device, b: vk::Image, c: vk::DeviceMemory, d: vk::DeviceSize);
    create_buffer, "vkCreateBuffer", vk::PFN_vkCreateBuffer, (a: vk::Device, b: *const vk::BufferCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, d: *mut vk::Buffer);
    create_command_pool, "vkCreateCommandPool", vk::PFN_vkCreateCommandPool, (a: vk::Device, b: *const vk::CommandPoolCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, d: *mut vk::CommandPool);
    create_compute_pipelines, "vkCreateComputePipelines", vk::PFN_vkCreateComputePipelines, (a: vk::Device, b: vk::PipelineCache, c: u32, d: *const vk::ComputePipelineCreateInfo<'_>, e: *const vk::AllocationCallbacks<'_>, f: *mut vk::Pipeline);
    create_descriptor_pool, "vkCreateDescriptorPool", vk::PFN_vkCreateDescriptorPool, (a: vk::Device, b: *const vk::DescriptorPoolCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, d: *mut vk::DescriptorPool);
    create_descriptor_set_layout, "vkCreateDescriptorSetLayout", vk::PFN_vkCreateDescriptorSetLayout, (a: vk::Device, b: *const vk::DescriptorSetLayoutCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, d: *mut vk::DescriptorSetLayout);
    create_image, "vkCreateImage", vk::PFN_vkCreateImage, (a: vk::Device, b: *const vk::ImageCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, d: *mut vk::Image);
    create_image_view, "vkCreateImageView", vk::PFN_vkCreateImageView, (a: vk::Device, b: *const vk::ImageViewCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, d: *mut vk::ImageView);
    create_pipeline_layout, "vkCreatePipelineLayout", vk::PFN_vkCreatePipelineLayout, (a: vk::Device, b: *const vk::PipelineLayoutCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, d: *mut vk::PipelineLayout);
    create_query_pool, "vkCreateQueryPool", vk::PFN_vkCreateQueryPool, (a: vk::Device, b: *const vk::QueryPoolCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, d: *mut vk::QueryPool);
    create_sampler, "vkCreateSampler", vk::PFN_vkCreateSampler, (a: vk::Device, b: *const vk::SamplerCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, d: *mut vk::Sampler);
    create_semaphore, "vkCreateSemaphore", vk::PFN_vkCreateSemaphore, (a: vk::Device, b: *const vk::SemaphoreCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, d: *mut vk::Semaphore);
    create_shader_module, "vkCreateShaderModule", vk::PFN_vkCreateShaderModule, (a: vk::Device, b: *const vk::ShaderModuleCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, d: *mut vk::ShaderModule);
    end_command_buffer, "vkEndCommandBuffer", vk::PFN_vkEndCommandBuffer, (a: vk::CommandBuffer);
    map_memory, "vkMapMemory", vk::PFN_vkMapMemory, (a: vk::Device, b: vk::DeviceMemory, c: vk::DeviceSize, d: vk::DeviceSize, e: vk::MemoryMapFlags, f: *mut *mut c_void);
    queue_submit, "vkQueueSubmit", vk::PFN_vkQueueSubmit, (a: vk::Queue, b: u32, c: *const vk::SubmitInfo<'_>, d: vk::Fence);
    reset_command_pool, "vkResetCommandPool", vk::PFN_vkResetCommandPool, (a: vk::Device, b: vk::CommandPool, c: vk::CommandPoolResetFlags);
    wait_semaphores, "vkWaitSemaphores", vk::PFN_vkWaitSemaphores, (a: vk::Device, b: *const vk::SemaphoreWaitInfo<'_>, c: u64);
}

/// Opens a validated device behind the doubles.
pub(super) fn open() -> Result<(Gpu, std::sync::Arc<Canary>)> {
    let options = GpuOptions {
        validation: true,
        profile: super::Profile::Full,
        ..Default::default()
    };
    let instance = Instance::new(true)?;
    let canary = instance.canary.clone();
    let mut devices = physical::enumerate(&instance)?;
    let reports: Vec<_> = devices.iter().map(|d| &d.report).collect();
    let row = physical::select(&reports, &options.device)?;
    let physical = devices.swap_remove(row);
    let (real, features) = features::create_device(&instance, &physical, Features::ALL)?;
    let handle = real.handle();
    let load = |name: &CStr| {
        // SAFETY: device and instance are alive; what comes back is the function of that name or null.
        let function = unsafe {
            let get = instance.raw.fp_v1_0().get_device_proc_addr;
            get(handle, name.as_ptr())
        };
        replace(
            name,
            function.map_or(std::ptr::null(), |f| f as *const c_void),
        )
    };
    // SAFETY: the functions are the device's own or of the same type.
    let device = unsafe { ash::Device::load_with(load, handle) };
    let shared = Shared::with_device(
        &options,
        instance,
        physical,
        device,
        features,
        Owner::Dermis,
    )?;
    Ok((
        Gpu {
            shared: std::sync::Arc::new(shared),
        },
        canary,
    ))
}
