//! Memory: named allocations in budget classes, refused before they pass the budget.

use std::{collections::HashMap, sync::Mutex};

use ash::vk;
use gpu_allocator::{
    AllocationError, AllocationSizes, MemoryLocation,
    vulkan::{Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc},
};

use super::{fault::lock, instance::Instance, physical::Physical};
use crate::{
    Error, Result,
    report::{MemoryReport, NamedMemory},
};

/// What an allocation is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Class {
    /// Implicit fields of the bones.
    Fields,
    /// Operator volumes.
    Operators,
    /// Topology, weights and rest state of a mesh.
    Mesh,
    /// Poses on their way to the device; mapped.
    PoseRing,
    /// State and scratch of a frame, staging.
    Transient,
    /// Results on their way back; mapped.
    Readback,
}

impl Class {
    /// Name in reports and errors.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fields => "fields",
            Self::Operators => "operators",
            Self::Mesh => "mesh",
            Self::PoseRing => "pose_ring",
            Self::Transient => "transient",
            Self::Readback => "readback",
        }
    }

    pub(crate) fn location(self) -> MemoryLocation {
        match self {
            Self::PoseRing => MemoryLocation::CpuToGpu,
            Self::Readback => MemoryLocation::GpuToCpu,
            _ => MemoryLocation::GpuOnly,
        }
    }
}

/// What an allocation is called, what it is for and where it lies.
#[derive(Clone, Copy)]
pub(crate) struct Request<'a> {
    pub(crate) name: &'a str,
    pub(crate) class: Class,
    pub(crate) location: MemoryLocation,
}

impl Request<'_> {
    pub(crate) fn refuse(&self, bytes: u64, reason: impl Into<String>) -> Error {
        Error::Memory {
            name: self.name.to_owned(),
            class: self.class.name(),
            bytes,
            reason: reason.into(),
        }
    }
}

/// A piece of device memory with its row in the ledger. Has to be given back to [`Memory::free`].
pub(crate) struct Block {
    pub(crate) allocation: Allocation,
    row: u64,
}

struct Row {
    name: String,
    class: Class,
    bytes: u64,
}

struct Ledger {
    allocator: Option<Allocator>,
    rows: HashMap<u64, Row>,
    next: u64,
    total: u64,
}

/// The device's memory.
pub(crate) struct Memory {
    ledger: Mutex<Ledger>,
    limit: u64,
    budget: Option<u64>,
}

impl Memory {
    pub(crate) fn new(
        instance: &Instance,
        device: &ash::Device,
        physical: &Physical,
        budget: Option<u64>,
    ) -> Result<Self> {
        let sizes =
            AllocationSizes::new(16 << 20, 4 << 20).with_max_device_memblock_size(256 << 20);
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: device.clone(),
            physical_device: physical.raw,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: sizes,
        })
        .map_err(|e| Error::NoDevice {
            reason: format!("{}: {e}", physical.report.name),
        })?;
        let heap = physical.heap() / 8 * 7;
        Ok(Self {
            ledger: Mutex::new(Ledger {
                allocator: Some(allocator),
                rows: HashMap::new(),
                next: 0,
                total: 0,
            }),
            // A software device that runs out of memory ends the process, so the heap is a budget too.
            limit: budget.unwrap_or(heap).min(heap),
            budget,
        })
    }

    /// Refuses what would pass the budget.
    pub(crate) fn admit(&self, request: &Request<'_>, bytes: u64) -> Result<()> {
        self.check(lock(&self.ledger).total, request, bytes)
    }

    fn check(&self, used: u64, request: &Request<'_>, bytes: u64) -> Result<()> {
        if used.saturating_add(bytes) <= self.limit {
            return Ok(());
        }
        let limit = match self.budget {
            Some(budget) if budget == self.limit => "budget",
            _ => "device's memory",
        };
        let reason = format!(
            "would pass the {limit} of {} bytes, {used} are in use",
            self.limit
        );
        Err(request.refuse(bytes, reason))
    }

    pub(crate) fn allocate(
        &self,
        request: &Request<'_>,
        requirements: vk::MemoryRequirements,
        linear: bool,
    ) -> Result<Block> {
        let bytes = requirements.size;
        let mut ledger = lock(&self.ledger);
        self.check(ledger.total, request, bytes)?;
        let allocator = ledger.allocator.as_mut();
        let allocator = allocator.ok_or_else(|| request.refuse(bytes, "the device is gone"))?;
        let allocation = allocator
            .allocate(&AllocationCreateDesc {
                name: request.name,
                requirements,
                location: request.location,
                linear,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
            .map_err(|e| request.refuse(bytes, reason(&e)))?;
        let row = ledger.next;
        ledger.next += 1;
        ledger.total += bytes;
        let (name, class) = (request.name.to_owned(), request.class);
        ledger.rows.insert(row, Row { name, class, bytes });
        Ok(Block { allocation, row })
    }

    pub(crate) fn free(&self, block: Block) {
        let mut ledger = lock(&self.ledger);
        if let Some(row) = ledger.rows.remove(&block.row) {
            ledger.total -= row.bytes;
        }
        if let Some(allocator) = ledger.allocator.as_mut() {
            let freed = allocator.free(block.allocation);
            debug_assert!(freed.is_ok(), "{freed:?}");
        }
    }

    pub(crate) fn report(&self) -> MemoryReport {
        let ledger = lock(&self.ledger);
        let rows = ledger.rows.values();
        let mut report = MemoryReport::sum(rows.map(|r| (&*r.name, r.class.name(), r.bytes)));
        report.budget = self.budget;
        report
    }

    /// One row an allocation, in the order in which they were made.
    pub(crate) fn rows(&self) -> Vec<NamedMemory> {
        let ledger = lock(&self.ledger);
        let mut rows: Vec<_> = ledger.rows.iter().collect();
        rows.sort_unstable_by_key(|(number, _)| **number);
        let named = |(_, row): (&u64, &Row)| NamedMemory {
            name: row.name.clone(),
            class: row.class.name().into(),
            bytes: row.bytes,
        };
        rows.into_iter().map(named).collect()
    }

    /// Allocations that gpu-allocator itself still knows of.
    #[cfg(test)]
    pub(crate) fn live(&self) -> usize {
        let ledger = lock(&self.ledger);
        ledger
            .allocator
            .as_ref()
            .map_or(0, |a| a.generate_report().allocations.len())
    }

    /// Gives all memory back to the driver; for the device's end.
    pub(crate) fn close(&self) {
        lock(&self.ledger).allocator = None;
    }
}

/// Why there is no memory, with the call that failed.
fn reason(error: &AllocationError) -> String {
    match error {
        AllocationError::OutOfMemory => {
            let code = vk::Result::ERROR_OUT_OF_DEVICE_MEMORY;
            format!("vkAllocateMemory failed: {code:?}")
        }
        AllocationError::FailedToMap(code) => format!("vkMapMemory failed: {code}"),
        // Names vkAllocateMemory where it failed otherwise.
        other => other.to_string(),
    }
}
