//! Vulkan as dermis sees it: every function that can fail asks first whether it has to, and what is made and destroyed is
//! counted. A function that is not here is missing, so that none goes by unnoticed.
// The caller's arguments are passed on to the driver's function of the same name, which is loaded before its wrapper is given out.
#![allow(
    clippy::undocumented_unsafe_blocks,
    clippy::too_many_arguments,
    clippy::missing_transmute_annotations
)]

use std::{
    cell::Cell,
    ffi::{CStr, c_char, c_void},
};

use ash::vk::{self, Handle, Result as Code};

use crate::state::{Verdict, gone, made, once, strike};

const MEMORY: &[Code] = &[
    Code::ERROR_OUT_OF_HOST_MEMORY,
    Code::ERROR_OUT_OF_DEVICE_MEMORY,
];
const DEVICE_MEMORY: &[Code] = &[Code::ERROR_OUT_OF_DEVICE_MEMORY];
const MAP: &[Code] = &[MEMORY[0], MEMORY[1], Code::ERROR_MEMORY_MAP_FAILED];
const POOL: &[Code] = &[MEMORY[0], MEMORY[1], Code::ERROR_OUT_OF_POOL_MEMORY];
const LOSS: &[Code] = &[MEMORY[0], MEMORY[1], Code::ERROR_DEVICE_LOST];

thread_local! {
    /// The driver's functions: that of the instance, that of the device, and one that waits for the device.
    static INSTANCE: Cell<Option<vk::PFN_vkGetInstanceProcAddr>> = const { Cell::new(None) };
    static DEVICE: Cell<Option<vk::PFN_vkGetDeviceProcAddr>> = const { Cell::new(None) };
    static IDLE: Cell<Option<(vk::Device, vk::PFN_vkDeviceWaitIdle)>> = const { Cell::new(None) };
}

/// The code with which a call has to fail. A device is idle before it is lost, since this one goes on.
fn failure(name: &'static str, codes: &'static [Code]) -> Option<Code> {
    match strike(name, codes) {
        Verdict::Pass => None,
        Verdict::Fail(code) => Some(code),
        Verdict::Lose => {
            if let Some((device, idle)) = IDLE.get() {
                assert_eq!(unsafe { idle(device) }, Code::SUCCESS);
            }
            Some(Code::ERROR_DEVICE_LOST)
        }
    }
}

/// Functions with a result: name in Vulkan, codes with which it may fail, arguments, and what to do where it does not.
macro_rules! fallible {
    ($($name:ident $text:literal $pfn:ident $codes:ident ($($argument:ident: $kind:ty),*) |$real:ident| $body:expr;)*) => {
        $(mod $name {
            use super::*;

            thread_local! { static REAL: Cell<Option<vk::$pfn>> = const { Cell::new(None) }; }

            pub(super) fn wrap(real: unsafe extern "system" fn()) -> vk::PFN_vkVoidFunction {
                let wrapped: vk::$pfn = wrapped;
                REAL.set(Some(unsafe { std::mem::transmute::<unsafe extern "system" fn(), vk::$pfn>(real) }));
                Some(unsafe { std::mem::transmute::<vk::$pfn, unsafe extern "system" fn()>(wrapped) })
            }

            unsafe extern "system" fn wrapped($($argument: $kind),*) -> Code {
                if let Some(code) = failure($text, $codes) {
                    return code;
                }
                let $real = REAL.get().unwrap();
                unsafe { $body }
            }
        })*

        fn fallible(name: &str, real: unsafe extern "system" fn()) -> vk::PFN_vkVoidFunction {
            match name {
                $($text => $name::wrap(real),)*
                _ => None,
            }
        }
    };
}

/// Functions that destroy: name in Vulkan and kind of the object.
macro_rules! destroying {
    ($($name:ident $text:literal $pfn:ident $kind:literal $handle:ty;)*) => {
        $(mod $name {
            use super::*;

            thread_local! { static REAL: Cell<Option<vk::$pfn>> = const { Cell::new(None) }; }

            pub(super) fn wrap(real: unsafe extern "system" fn()) -> vk::PFN_vkVoidFunction {
                let wrapped: vk::$pfn = wrapped;
                REAL.set(Some(unsafe { std::mem::transmute::<unsafe extern "system" fn(), vk::$pfn>(real) }));
                Some(unsafe { std::mem::transmute::<vk::$pfn, unsafe extern "system" fn()>(wrapped) })
            }

            unsafe extern "system" fn wrapped(
                parent: Parent<$handle>,
                handle: $handle,
                callbacks: *const vk::AllocationCallbacks<'_>,
            ) {
                if handle.is_null() || gone($kind, handle.as_raw()) {
                    return;
                }
                unsafe { REAL.get().unwrap()(parent, handle, callbacks) }
            }
        })*

        fn destroying(name: &str, real: unsafe extern "system" fn()) -> vk::PFN_vkVoidFunction {
            match name {
                $($text => $name::wrap(real),)*
                _ => None,
            }
        }

        /// Destroys an object that was made once for all runs.
        pub(crate) fn destroy(device: &ash::Device, (kind, handle): (&'static str, u64)) {
            match kind {
                "DescriptorSetLayout" => unsafe {
                    device.destroy_descriptor_set_layout(Handle::from_raw(handle), None)
                },
                "PipelineLayout" => unsafe { device.destroy_pipeline_layout(Handle::from_raw(handle), None) },
                "ShaderModule" => unsafe { device.destroy_shader_module(Handle::from_raw(handle), None) },
                "Pipeline" => unsafe { device.destroy_pipeline(Handle::from_raw(handle), None) },
                other => panic!("{other}"),
            }
        }
    };
}

/// What an object is destroyed with.
type Parent<T> = <T as Child>::Parent;

trait Child {
    type Parent;
}

macro_rules! children {
    ($parent:ty: $($child:ty),*) => { $(impl Child for $child { type Parent = $parent; })* };
}

children!(vk::Device: vk::Buffer, vk::BufferView, vk::CommandPool, vk::DescriptorPool, vk::DescriptorSetLayout, vk::DeviceMemory, vk::Image, vk::ImageView, vk::Pipeline, vk::PipelineLayout, vk::QueryPool, vk::Sampler, vk::Semaphore, vk::ShaderModule);
children!(vk::Instance: vk::DebugUtilsMessengerEXT);

#[rustfmt::skip]
fallible! {
    allocate_command_buffers "vkAllocateCommandBuffers" PFN_vkAllocateCommandBuffers MEMORY (d: vk::Device, i: *const vk::CommandBufferAllocateInfo<'_>, o: *mut vk::CommandBuffer) |real| real(d, i, o);
    allocate_descriptor_sets "vkAllocateDescriptorSets" PFN_vkAllocateDescriptorSets POOL (d: vk::Device, i: *const vk::DescriptorSetAllocateInfo<'_>, o: *mut vk::DescriptorSet) |real| real(d, i, o);
    allocate_memory "vkAllocateMemory" PFN_vkAllocateMemory MEMORY (d: vk::Device, i: *const vk::MemoryAllocateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::DeviceMemory) |real| made("DeviceMemory", real(d, i, c, o), o);
    begin_command_buffer "vkBeginCommandBuffer" PFN_vkBeginCommandBuffer MEMORY (b: vk::CommandBuffer, i: *const vk::CommandBufferBeginInfo<'_>) |real| real(b, i);
    bind_buffer_memory "vkBindBufferMemory" PFN_vkBindBufferMemory MEMORY (d: vk::Device, b: vk::Buffer, m: vk::DeviceMemory, o: vk::DeviceSize) |real| real(d, b, m, o);
    bind_image_memory "vkBindImageMemory" PFN_vkBindImageMemory MEMORY (d: vk::Device, b: vk::Image, m: vk::DeviceMemory, o: vk::DeviceSize) |real| real(d, b, m, o);
    create_buffer "vkCreateBuffer" PFN_vkCreateBuffer MEMORY (d: vk::Device, i: *const vk::BufferCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::Buffer) |real| made("Buffer", real(d, i, c, o), o);
    create_buffer_view "vkCreateBufferView" PFN_vkCreateBufferView MEMORY (d: vk::Device, i: *const vk::BufferViewCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::BufferView) |real| made("BufferView", real(d, i, c, o), o);
    create_command_pool "vkCreateCommandPool" PFN_vkCreateCommandPool MEMORY (d: vk::Device, i: *const vk::CommandPoolCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::CommandPool) |real| made("CommandPool", real(d, i, c, o), o);
    create_compute_pipelines "vkCreateComputePipelines" PFN_vkCreateComputePipelines MEMORY (d: vk::Device, p: vk::PipelineCache, n: u32, i: *const vk::ComputePipelineCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::Pipeline) |real| once("Pipeline", &parts_of_pipeline(d, n, i), o, || real(d, p, n, i, c, o));
    create_debug_utils_messenger "vkCreateDebugUtilsMessengerEXT" PFN_vkCreateDebugUtilsMessengerEXT MEMORY (n: vk::Instance, i: *const vk::DebugUtilsMessengerCreateInfoEXT<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::DebugUtilsMessengerEXT) |real| made("DebugUtilsMessengerEXT", real(n, i, c, o), o);
    create_descriptor_pool "vkCreateDescriptorPool" PFN_vkCreateDescriptorPool MEMORY (d: vk::Device, i: *const vk::DescriptorPoolCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::DescriptorPool) |real| made("DescriptorPool", real(d, i, c, o), o);
    create_descriptor_set_layout "vkCreateDescriptorSetLayout" PFN_vkCreateDescriptorSetLayout MEMORY (d: vk::Device, i: *const vk::DescriptorSetLayoutCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::DescriptorSetLayout) |real| once("DescriptorSetLayout", &parts_of_set(d, i), o, || real(d, i, c, o));
    create_device "vkCreateDevice" PFN_vkCreateDevice LOSS (p: vk::PhysicalDevice, i: *const vk::DeviceCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::Device) |real| once("Device", &[p.as_raw()], o, || real(p, i, c, o));
    create_image "vkCreateImage" PFN_vkCreateImage MEMORY (d: vk::Device, i: *const vk::ImageCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::Image) |real| made("Image", real(d, i, c, o), o);
    create_image_view "vkCreateImageView" PFN_vkCreateImageView MEMORY (d: vk::Device, i: *const vk::ImageViewCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::ImageView) |real| made("ImageView", real(d, i, c, o), o);
    create_instance "vkCreateInstance" PFN_vkCreateInstance MEMORY (i: *const vk::InstanceCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::Instance) |real| once("Instance", &[(*i).enabled_layer_count.into()], o, || real(i, c, o));
    create_pipeline_layout "vkCreatePipelineLayout" PFN_vkCreatePipelineLayout MEMORY (d: vk::Device, i: *const vk::PipelineLayoutCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::PipelineLayout) |real| once("PipelineLayout", &parts_of_layout(d, i), o, || real(d, i, c, o));
    create_query_pool "vkCreateQueryPool" PFN_vkCreateQueryPool MEMORY (d: vk::Device, i: *const vk::QueryPoolCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::QueryPool) |real| made("QueryPool", real(d, i, c, o), o);
    create_sampler "vkCreateSampler" PFN_vkCreateSampler MEMORY (d: vk::Device, i: *const vk::SamplerCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::Sampler) |real| made("Sampler", real(d, i, c, o), o);
    create_semaphore "vkCreateSemaphore" PFN_vkCreateSemaphore MEMORY (d: vk::Device, i: *const vk::SemaphoreCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::Semaphore) |real| made("Semaphore", real(d, i, c, o), o);
    create_shader_module "vkCreateShaderModule" PFN_vkCreateShaderModule MEMORY (d: vk::Device, i: *const vk::ShaderModuleCreateInfo<'_>, c: *const vk::AllocationCallbacks<'_>, o: *mut vk::ShaderModule) |real| once("ShaderModule", &parts_of_module(d, i), o, || real(d, i, c, o));
    device_wait_idle "vkDeviceWaitIdle" PFN_vkDeviceWaitIdle LOSS (d: vk::Device) |real| real(d);
    end_command_buffer "vkEndCommandBuffer" PFN_vkEndCommandBuffer MEMORY (b: vk::CommandBuffer) |real| real(b);
    enumerate_device_extensions "vkEnumerateDeviceExtensionProperties" PFN_vkEnumerateDeviceExtensionProperties MEMORY (p: vk::PhysicalDevice, l: *const c_char, n: *mut u32, o: *mut vk::ExtensionProperties) |real| real(p, l, n, o);
    enumerate_instance_extensions "vkEnumerateInstanceExtensionProperties" PFN_vkEnumerateInstanceExtensionProperties MEMORY (l: *const c_char, n: *mut u32, o: *mut vk::ExtensionProperties) |real| real(l, n, o);
    enumerate_instance_layers "vkEnumerateInstanceLayerProperties" PFN_vkEnumerateInstanceLayerProperties MEMORY (n: *mut u32, o: *mut vk::LayerProperties) |real| real(n, o);
    enumerate_physical_devices "vkEnumeratePhysicalDevices" PFN_vkEnumeratePhysicalDevices MEMORY (i: vk::Instance, n: *mut u32, o: *mut vk::PhysicalDevice) |real| real(i, n, o);
    get_query_pool_results "vkGetQueryPoolResults" PFN_vkGetQueryPoolResults LOSS (d: vk::Device, p: vk::QueryPool, a: u32, n: u32, b: usize, o: *mut c_void, s: vk::DeviceSize, f: vk::QueryResultFlags) |real| real(d, p, a, n, b, o, s, f);
    get_semaphore_counter_value "vkGetSemaphoreCounterValue" PFN_vkGetSemaphoreCounterValue LOSS (d: vk::Device, s: vk::Semaphore, o: *mut u64) |real| real(d, s, o);
    map_memory "vkMapMemory" PFN_vkMapMemory MAP (d: vk::Device, m: vk::DeviceMemory, a: vk::DeviceSize, n: vk::DeviceSize, f: vk::MemoryMapFlags, o: *mut *mut c_void) |real| real(d, m, a, n, f, o);
    queue_submit "vkQueueSubmit" PFN_vkQueueSubmit LOSS (q: vk::Queue, n: u32, i: *const vk::SubmitInfo<'_>, f: vk::Fence) |real| real(q, n, i, f);
    reset_command_pool "vkResetCommandPool" PFN_vkResetCommandPool DEVICE_MEMORY (d: vk::Device, p: vk::CommandPool, f: vk::CommandPoolResetFlags) |real| real(d, p, f);
    set_object_name "vkSetDebugUtilsObjectNameEXT" PFN_vkSetDebugUtilsObjectNameEXT MEMORY (d: vk::Device, i: *const vk::DebugUtilsObjectNameInfoEXT<'_>) |real| real(d, i);
    wait_semaphores "vkWaitSemaphores" PFN_vkWaitSemaphores LOSS (d: vk::Device, i: *const vk::SemaphoreWaitInfo<'_>, t: u64) |real| real(d, i, t);
}

#[rustfmt::skip]
destroying! {
    destroy_buffer "vkDestroyBuffer" PFN_vkDestroyBuffer "Buffer" vk::Buffer;
    destroy_buffer_view "vkDestroyBufferView" PFN_vkDestroyBufferView "BufferView" vk::BufferView;
    destroy_command_pool "vkDestroyCommandPool" PFN_vkDestroyCommandPool "CommandPool" vk::CommandPool;
    destroy_debug_utils_messenger "vkDestroyDebugUtilsMessengerEXT" PFN_vkDestroyDebugUtilsMessengerEXT "DebugUtilsMessengerEXT" vk::DebugUtilsMessengerEXT;
    destroy_descriptor_pool "vkDestroyDescriptorPool" PFN_vkDestroyDescriptorPool "DescriptorPool" vk::DescriptorPool;
    destroy_descriptor_set_layout "vkDestroyDescriptorSetLayout" PFN_vkDestroyDescriptorSetLayout "DescriptorSetLayout" vk::DescriptorSetLayout;
    destroy_image "vkDestroyImage" PFN_vkDestroyImage "Image" vk::Image;
    destroy_image_view "vkDestroyImageView" PFN_vkDestroyImageView "ImageView" vk::ImageView;
    destroy_pipeline "vkDestroyPipeline" PFN_vkDestroyPipeline "Pipeline" vk::Pipeline;
    destroy_pipeline_layout "vkDestroyPipelineLayout" PFN_vkDestroyPipelineLayout "PipelineLayout" vk::PipelineLayout;
    destroy_query_pool "vkDestroyQueryPool" PFN_vkDestroyQueryPool "QueryPool" vk::QueryPool;
    destroy_sampler "vkDestroySampler" PFN_vkDestroySampler "Sampler" vk::Sampler;
    destroy_semaphore "vkDestroySemaphore" PFN_vkDestroySemaphore "Semaphore" vk::Semaphore;
    destroy_shader_module "vkDestroyShaderModule" PFN_vkDestroyShaderModule "ShaderModule" vk::ShaderModule;
    free_memory "vkFreeMemory" PFN_vkFreeMemory "DeviceMemory" vk::DeviceMemory;
}

/// Devices and instances are made once, and so never destroyed.
unsafe extern "system" fn destroy_device(
    device: vk::Device,
    _: *const vk::AllocationCallbacks<'_>,
) {
    gone("Device", device.as_raw());
}

unsafe extern "system" fn destroy_instance(
    instance: vk::Instance,
    _: *const vk::AllocationCallbacks<'_>,
) {
    gone("Instance", instance.as_raw());
}

unsafe fn slice<'a, T>(first: *const T, count: u32) -> &'a [T] {
    match count {
        0 => &[],
        count => unsafe { std::slice::from_raw_parts(first, count as usize) },
    }
}

unsafe fn parts_of_set(
    device: vk::Device,
    info: *const vk::DescriptorSetLayoutCreateInfo<'_>,
) -> Vec<u64> {
    let bindings = unsafe { slice((*info).p_bindings, (*info).binding_count) };
    let words = bindings
        .iter()
        .map(|b| u64::from(b.binding) << 32 | b.descriptor_type.as_raw() as u64);
    [device.as_raw()].into_iter().chain(words).collect()
}

unsafe fn parts_of_layout(
    device: vk::Device,
    info: *const vk::PipelineLayoutCreateInfo<'_>,
) -> Vec<u64> {
    let (sets, ranges) = unsafe {
        let info = &*info;
        (
            slice(info.p_set_layouts, info.set_layout_count),
            slice(info.p_push_constant_ranges, info.push_constant_range_count),
        )
    };
    let sets = sets.iter().map(|s| s.as_raw());
    let words = sets.chain(ranges.iter().map(|r| u64::from(r.size)));
    [device.as_raw()].into_iter().chain(words).collect()
}

unsafe fn parts_of_module(
    device: vk::Device,
    info: *const vk::ShaderModuleCreateInfo<'_>,
) -> Vec<u64> {
    let words = unsafe { slice((*info).p_code, (*info).code_size as u32 / 4) };
    let words = words.iter().map(|w| u64::from(*w));
    [device.as_raw()].into_iter().chain(words).collect()
}

unsafe fn parts_of_pipeline(
    device: vk::Device,
    count: u32,
    info: *const vk::ComputePipelineCreateInfo<'_>,
) -> Vec<u64> {
    assert_eq!(count, 1);
    unsafe {
        let (info, special) = (&*info, &*(*info).stage.p_specialization_info);
        let bytes = slice(special.p_data.cast::<u8>(), special.data_size as u32);
        let (module, layout) = (info.stage.module.as_raw(), info.layout.as_raw());
        [device.as_raw(), module, layout]
            .into_iter()
            .chain(bytes.iter().map(|b| u64::from(*b)))
            .collect()
    }
}

/// Cannot fail and make nothing.
const OTHERS: [&str; 13] = [
    "vkGetBufferMemoryRequirements",
    "vkGetDeviceQueue",
    "vkGetImageMemoryRequirements",
    "vkGetPhysicalDeviceFeatures2",
    "vkGetPhysicalDeviceFormatProperties",
    "vkGetPhysicalDeviceMemoryProperties",
    "vkGetPhysicalDeviceMemoryProperties2",
    "vkGetPhysicalDeviceProperties",
    "vkGetPhysicalDeviceProperties2",
    "vkGetPhysicalDeviceQueueFamilyProperties",
    "vkGetPhysicalDeviceQueueFamilyProperties2",
    "vkUnmapMemory",
    "vkUpdateDescriptorSets",
];

/// A function for dermis in place of the driver's.
fn wrap(name: *const c_char, real: vk::PFN_vkVoidFunction) -> vk::PFN_vkVoidFunction {
    let name = unsafe { CStr::from_ptr(name) }.to_str().unwrap();
    let real = real?;
    unsafe {
        match name {
            "vkGetInstanceProcAddr" => Some(
                std::mem::transmute::<vk::PFN_vkGetInstanceProcAddr, _>(get_instance_proc_addr),
            ),
            "vkGetDeviceProcAddr" => {
                DEVICE.set(Some(std::mem::transmute::<
                    unsafe extern "system" fn(),
                    vk::PFN_vkGetDeviceProcAddr,
                >(real)));
                Some(std::mem::transmute::<vk::PFN_vkGetDeviceProcAddr, _>(
                    get_device_proc_addr,
                ))
            }
            "vkDestroyDevice" => Some(std::mem::transmute::<vk::PFN_vkDestroyDevice, _>(
                destroy_device,
            )),
            "vkDestroyInstance" => Some(std::mem::transmute::<vk::PFN_vkDestroyInstance, _>(
                destroy_instance,
            )),
            _ if OTHERS.contains(&name) || name.starts_with("vkCmd") => Some(real),
            _ => fallible(name, real).or_else(|| destroying(name, real)),
        }
    }
}

pub(crate) unsafe extern "system" fn get_instance_proc_addr(
    instance: vk::Instance,
    name: *const c_char,
) -> vk::PFN_vkVoidFunction {
    wrap(name, unsafe { INSTANCE.get().unwrap()(instance, name) })
}

unsafe extern "system" fn get_device_proc_addr(
    device: vk::Device,
    name: *const c_char,
) -> vk::PFN_vkVoidFunction {
    let get = DEVICE.get().unwrap();
    unsafe {
        let idle = get(device, c"vkDeviceWaitIdle".as_ptr()).unwrap();
        IDLE.set(Some((
            device,
            std::mem::transmute::<unsafe extern "system" fn(), vk::PFN_vkDeviceWaitIdle>(idle),
        )));
        wrap(name, get(device, name))
    }
}

/// Lets the wrappers of this thread load from here.
pub(crate) fn load_from(get: vk::PFN_vkGetInstanceProcAddr) {
    INSTANCE.set(Some(get));
}
