//! A host's own Vulkan device, with validation, a buffer and a command buffer.
// Plain Vulkan on live objects, in the order of a program that does nothing else.
#![allow(clippy::undocumented_unsafe_blocks)]

use std::{
    ffi::{CStr, c_char, c_void},
    sync::Mutex,
};

use ash::{Device, Entry, Instance, ext, vk, vk::Handle as _};
use dermis::capi::*;

static MESSAGES: Mutex<Vec<String>> = Mutex::new(Vec::new());

unsafe extern "system" fn keep(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    _: *mut c_void,
) -> vk::Bool32 {
    let text = unsafe { CStr::from_ptr((*data).p_message) };
    MESSAGES.lock().unwrap().push(text.to_string_lossy().into());
    vk::FALSE
}

/// Bytes of the host's vertex buffer.
pub(crate) const BYTES: u64 = 1 << 20;

pub(crate) struct HostDevice {
    pub(crate) entry: Entry,
    pub(crate) instance: Instance,
    debug: ext::debug_utils::Instance,
    messenger: vk::DebugUtilsMessengerEXT,
    pub(crate) physical: vk::PhysicalDevice,
    pub(crate) device: Device,
    pub(crate) queue: vk::Queue,
    pub(crate) buffer: vk::Buffer,
    memory: vk::DeviceMemory,
    pool: vk::CommandPool,
    pub(crate) commands: vk::CommandBuffer,
}

/// A function of Vulkan's type, with the header's names for its types.
pub(crate) fn loader(get: vk::PFN_vkGetInstanceProcAddr) -> dm_get_instance_proc_addr {
    type Get = unsafe extern "system" fn(*mut c_void, *const c_char) -> dm_function;
    Some(unsafe { std::mem::transmute::<vk::PFN_vkGetInstanceProcAddr, Get>(get) })
}

impl HostDevice {
    /// The device for dm_context_adopt.
    pub(crate) fn vulkan(&self) -> dm_vulkan_desc {
        dm_vulkan_desc {
            size: size_of::<dm_vulkan_desc>() as u32,
            api_version: DM_API_VERSION,
            get_instance_proc_addr: loader(self.entry.static_fn().get_instance_proc_addr),
            instance: self.instance.handle().as_raw() as *mut _,
            physical_device: self.physical.as_raw() as *mut _,
            device: self.device.handle().as_raw() as *mut _,
            queue: self.queue.as_raw() as *mut _,
            queue_family: 0,
            features: 0,
            budget: 0,
            log: None,
            log_user: std::ptr::null_mut(),
        }
    }

    /// Its buffer as an output of 24 bytes a vertex.
    pub(crate) fn output(&self) -> dm_output_desc {
        dm_output_desc {
            size: size_of::<dm_output_desc>() as u32,
            stride: 24,
            buffer: self.buffer.as_raw(),
            bytes: BYTES,
            offset: 0,
            normal_offset: 12,
            normal_format: DM_NORMAL_F32,
            stages: vk::PipelineStageFlags::VERTEX_INPUT.as_raw(),
            access: vk::AccessFlags::VERTEX_ATTRIBUTE_READ.as_raw(),
            queue_family: DM_SAME_FAMILY,
            reserved: 0,
            instance_stride: 0,
        }
    }
}

impl HostDevice {
    /// With validation.
    pub(crate) fn new() -> Self {
        Self::with_layers(&[c"VK_LAYER_KHRONOS_validation".as_ptr()])
    }

    pub(crate) fn with_layers(layers: &[*const c_char]) -> Self {
        unsafe {
            let entry = Entry::load().unwrap();
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_2);
            let extensions = [ext::debug_utils::NAME.as_ptr()];
            let info = vk::InstanceCreateInfo::default()
                .application_info(&application)
                .enabled_layer_names(layers)
                .enabled_extension_names(&extensions);
            let instance = entry.create_instance(&info, None).unwrap();
            let debug = ext::debug_utils::Instance::new(&entry, &instance);
            use vk::DebugUtilsMessageSeverityFlagsEXT as Severity;
            let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
                .message_severity(Severity::WARNING | Severity::ERROR)
                .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
                .pfn_user_callback(Some(keep));
            let messenger = debug.create_debug_utils_messenger(&info, None).unwrap();
            let physical = instance.enumerate_physical_devices().unwrap()[0];
            let queues = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
            let mut timeline =
                vk::PhysicalDeviceTimelineSemaphoreFeatures::default().timeline_semaphore(true);
            let info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .push_next(&mut timeline);
            let device = instance.create_device(physical, &info, None).unwrap();
            let queue = device.get_device_queue(0, 0);
            let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::VERTEX_BUFFER;
            let info = vk::BufferCreateInfo::default().size(BYTES).usage(usage);
            let buffer = device.create_buffer(&info, None).unwrap();
            let needs = device.get_buffer_memory_requirements(buffer);
            let wanted =
                vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
            let types = instance.get_physical_device_memory_properties(physical);
            let types = types.memory_types_as_slice().iter().enumerate();
            let mut fitting = types.filter(|(row, kind)| {
                needs.memory_type_bits >> row & 1 == 1 && kind.property_flags.contains(wanted)
            });
            let info = vk::MemoryAllocateInfo::default()
                .allocation_size(needs.size)
                .memory_type_index(fitting.next().unwrap().0 as u32);
            let memory = device.allocate_memory(&info, None).unwrap();
            device.bind_buffer_memory(buffer, memory, 0).unwrap();
            let info = vk::CommandPoolCreateInfo::default()
                .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
            let pool = device.create_command_pool(&info, None).unwrap();
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(pool)
                .command_buffer_count(1);
            let commands = device.allocate_command_buffers(&info).unwrap()[0];
            Self {
                entry,
                instance,
                debug,
                messenger,
                physical,
                device,
                queue,
                buffer,
                memory,
                pool,
                commands,
            }
        }
    }

    /// Records.
    pub(crate) fn record(&self, record: impl FnOnce()) {
        let info = vk::CommandBufferBeginInfo::default();
        unsafe {
            self.device
                .begin_command_buffer(self.commands, &info)
                .unwrap();
            record();
            self.device.end_command_buffer(self.commands).unwrap();
        }
    }

    /// Records, submits and waits.
    pub(crate) fn run(&self, record: impl FnOnce()) {
        let commands = [self.commands];
        let submit = vk::SubmitInfo::default().command_buffers(&commands);
        self.record(record);
        unsafe {
            self.device
                .queue_submit(self.queue, &[submit], vk::Fence::null())
                .unwrap();
            self.device.queue_wait_idle(self.queue).unwrap();
        }
    }

    /// The first words of the vertex buffer.
    pub(crate) fn words(&self, count: usize) -> Vec<u32> {
        let flags = vk::MemoryMapFlags::empty();
        unsafe {
            let at = self
                .device
                .map_memory(self.memory, 0, BYTES, flags)
                .unwrap();
            let words = std::slice::from_raw_parts(at.cast::<u32>(), count).to_vec();
            self.device.unmap_memory(self.memory);
            words
        }
    }

    /// Destroys all that the host made; what dermis left on the device would be told by validation.
    pub(crate) fn end(self) -> Vec<String> {
        unsafe {
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_buffer(self.buffer, None);
            self.device.free_memory(self.memory, None);
            self.device.destroy_device(None);
            self.debug
                .destroy_debug_utils_messenger(self.messenger, None);
            self.instance.destroy_instance(None);
        }
        std::mem::take(&mut *MESSAGES.lock().unwrap())
    }
}
