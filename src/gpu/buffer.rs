//! Buffers, and rings of one mapped buffer a frame in flight.

use std::sync::{Arc, Mutex};

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::{
    fault::{Subject, lock},
    memory::{Block, Class, Request},
    shared::{Grave, Shared},
};
use crate::Result;

/// Frames that may be on the device at once.
pub const FRAMES_IN_FLIGHT: usize = 2;

/// One of the [`FRAMES_IN_FLIGHT`] frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot(pub(crate) usize);

impl Slot {
    /// Number `index`; none past the last.
    pub fn new(index: usize) -> Option<Self> {
        (index < FRAMES_IN_FLIGHT).then_some(Self(index))
    }

    /// 0 or 1.
    pub fn index(self) -> usize {
        self.0
    }
}

/// A buffer on the device; clones share it, the last one gives it back once the device is done with it.
#[derive(Clone)]
pub struct Buffer(Arc<Inner>);

struct Inner {
    shared: Arc<Shared>,
    raw: vk::Buffer,
    name: String,
    class: Class,
    bytes: u64,
    mapped: bool,
    /// Empty on the way out, and where the buffer is the host's.
    block: Mutex<Option<Block>>,
    /// Memory and handle are the host's.
    hosted: bool,
}

impl Buffer {
    /// A buffer for every use that dermis has for buffers.
    pub(crate) fn new(shared: &Arc<Shared>, request: Request<'_>, bytes: u64) -> Result<Self> {
        shared.collect();
        shared.memory.admit(&request, bytes)?;
        let most = u64::from(shared.physical.properties.limits.max_storage_buffer_range);
        if bytes == 0 || bytes > most {
            return Err(request.refuse(
                bytes,
                format!("a buffer has 1 to {most} bytes on this device"),
            ));
        }
        let raw = create(&shared.device, request.name, bytes)?;
        let block = back(shared, raw, &request).inspect_err(|_| {
            // SAFETY: the buffer was just made and nobody else has it.
            unsafe { shared.device.destroy_buffer(raw, None) }
        })?;
        shared.name(raw, request.name);
        Ok(Self(Arc::new(Inner {
            shared: shared.clone(),
            raw,
            name: request.name.to_owned(),
            class: request.class,
            bytes,
            mapped: block.allocation.mapped_ptr().is_some()
                && request.location != MemoryLocation::GpuOnly,
            block: Mutex::new(Some(block)),
            hosted: false,
        })))
    }

    /// The first `bytes` of a buffer of the host's, which has to be made for storage use.
    ///
    /// # Safety
    /// The buffer is of this device, that long, and alive until the last clone of this handle is dropped.
    pub(crate) unsafe fn of_host(
        shared: &Arc<Shared>,
        raw: vk::Buffer,
        name: &str,
        bytes: u64,
    ) -> Result<Self> {
        let buffer = Self(Arc::new(Inner {
            shared: shared.clone(),
            raw,
            name: name.to_owned(),
            class: Class::Readback,
            bytes,
            mapped: false,
            block: Mutex::new(None),
            hosted: true,
        }));
        let most = u64::from(shared.physical.properties.limits.max_storage_buffer_range);
        if raw == vk::Buffer::null() || bytes == 0 || bytes > most {
            let reason = format!("a buffer has a handle and 1 to {most} bytes on this device");
            return Err(buffer.refuse(bytes, reason));
        }
        Ok(buffer)
    }

    /// Memory and handle are the host's.
    pub(crate) fn is_hosted(&self) -> bool {
        self.0.hosted
    }

    /// Name of the allocation.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Size in bytes.
    pub fn bytes(&self) -> u64 {
        self.0.bytes
    }

    /// Budget class.
    pub fn class(&self) -> Class {
        self.0.class
    }

    /// The CPU reads and writes it in place.
    pub fn is_mapped(&self) -> bool {
        self.0.mapped
    }

    /// The Vulkan handle, valid while this buffer lives.
    pub(crate) fn raw(&self) -> vk::Buffer {
        self.0.raw
    }

    /// Both are handles to the same device.
    pub(crate) fn is_of(&self, shared: &Arc<Shared>) -> bool {
        Arc::ptr_eq(&self.0.shared, shared)
    }

    pub(crate) fn refuse(&self, bytes: u64, reason: impl Into<String>) -> crate::Error {
        crate::Error::Memory {
            name: self.0.name.clone(),
            class: self.0.class.name(),
            bytes,
            reason: reason.into(),
        }
    }

    /// Fails where `offset + bytes` lies past the end.
    pub(crate) fn check(&self, offset: u64, bytes: u64) -> Result<()> {
        match offset.checked_add(bytes) {
            Some(end) if end <= self.0.bytes => Ok(()),
            _ => Err(self.refuse(
                bytes,
                format!("at {offset} they pass the end at {}", self.0.bytes),
            )),
        }
    }

    /// Writes a mapped buffer.
    pub(crate) fn write(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        self.check(offset, bytes.len() as u64)?;
        let mut block = lock(&self.0.block);
        let slice = block.as_mut().and_then(|b| b.allocation.mapped_slice_mut());
        let slice = slice.filter(|_| self.0.mapped);
        let slice =
            slice.ok_or_else(|| self.refuse(bytes.len() as u64, "the buffer is not mapped"))?;
        slice[offset as usize..offset as usize + bytes.len()].copy_from_slice(bytes);
        Ok(())
    }

    /// Reads a mapped buffer.
    pub(crate) fn read(&self, offset: u64, bytes: &mut [u8]) -> Result<()> {
        self.check(offset, bytes.len() as u64)?;
        let block = lock(&self.0.block);
        let slice = block.as_ref().and_then(|b| b.allocation.mapped_slice());
        let slice = slice.filter(|_| self.0.mapped);
        let slice =
            slice.ok_or_else(|| self.refuse(bytes.len() as u64, "the buffer is not mapped"))?;
        bytes.copy_from_slice(&slice[offset as usize..offset as usize + bytes.len()]);
        Ok(())
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        if let Some(block) = lock(&self.block).take() {
            self.shared.bury(Grave::Buffer(self.raw, block));
        }
    }
}

fn create(device: &ash::Device, name: &str, bytes: u64) -> Result<vk::Buffer> {
    use vk::BufferUsageFlags as Usage;
    let usage = Usage::STORAGE_BUFFER
        | Usage::UNIFORM_BUFFER
        | Usage::UNIFORM_TEXEL_BUFFER
        | Usage::TRANSFER_SRC
        | Usage::TRANSFER_DST
        | Usage::INDIRECT_BUFFER
        | Usage::VERTEX_BUFFER
        | Usage::INDEX_BUFFER;
    let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
    // SAFETY: the device is alive and the size is not 0.
    unsafe { device.create_buffer(&info, None) }.subject("vkCreateBuffer", name)
}

/// Allocates and binds the memory of a new buffer.
fn back(shared: &Shared, raw: vk::Buffer, request: &Request<'_>) -> Result<Block> {
    // SAFETY: the buffer was just made.
    let requirements = unsafe { shared.device.get_buffer_memory_requirements(raw) };
    let block = shared.memory.allocate(request, requirements, true)?;
    // SAFETY: the buffer has no memory yet; the block was allocated for its requirements and outlives it.
    let bound = unsafe {
        let (memory, offset) = (block.allocation.memory(), block.allocation.offset());
        shared.device.bind_buffer_memory(raw, memory, offset)
    };
    match bound.subject("vkBindBufferMemory", request.name) {
        Ok(()) => Ok(block),
        Err(error) => {
            shared.memory.free(block);
            Err(error)
        }
    }
}

/// One mapped buffer a frame in flight: the CPU writes one while the device reads the other.
#[derive(Clone)]
pub struct Ring(pub(crate) [Buffer; FRAMES_IN_FLIGHT]);

impl Ring {
    pub(crate) fn new(shared: &Arc<Shared>, name: &str, class: Class, bytes: u64) -> Result<Self> {
        let location = match class {
            Class::Readback => MemoryLocation::GpuToCpu,
            _ => MemoryLocation::CpuToGpu,
        };
        let request = Request {
            name,
            class,
            location,
        };
        let slot = || Buffer::new(shared, request, bytes);
        Ok(Self([slot()?, slot()?]))
    }

    /// Name of the allocations.
    pub fn name(&self) -> &str {
        self.0[0].name()
    }

    /// Bytes of one slot.
    pub fn bytes(&self) -> u64 {
        self.0[0].bytes()
    }

    /// Writes the slot's buffer from its beginning.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::Error::Memory) where `bytes` is longer than the slot.
    pub fn write(&self, slot: Slot, bytes: &[u8]) -> Result<()> {
        self.write_at(slot, 0, bytes)
    }

    /// Writes the slot's buffer from `offset` in bytes.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::Error::Memory) where the end lies past the slot's.
    pub fn write_at(&self, slot: Slot, offset: u64, bytes: &[u8]) -> Result<()> {
        self.0[slot.0].write(offset, bytes)
    }

    /// Reads the slot's buffer from its beginning; its frame has to be done.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::Error::Memory) where `bytes` is longer than the slot.
    pub fn read(&self, slot: Slot, bytes: &mut [u8]) -> Result<()> {
        self.0[slot.0].read(0, bytes)
    }
}
