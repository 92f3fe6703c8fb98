//! Command buffers with their pools.

use std::sync::Arc;

use ash::vk;

use super::{
    fault::Subject,
    record::{Recorder, Scope},
    shared::{Grave, Shared},
};
use crate::Result;

/// A pool with all its command buffers; given back once the device is done with them.
struct Pool {
    shared: Arc<Shared>,
    raw: vk::CommandPool,
    buffers: Vec<vk::CommandBuffer>,
}

impl Pool {
    fn new(
        shared: &Arc<Shared>,
        subject: &str,
        flags: vk::CommandPoolCreateFlags,
        (level, count): (vk::CommandBufferLevel, u32),
    ) -> Result<Self> {
        let device = &shared.device;
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(shared.physical.family)
            .flags(flags);
        // SAFETY: the device is alive and has a queue of this family.
        let raw = unsafe { device.create_command_pool(&info, None) }
            .subject("vkCreateCommandPool", subject)?;
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(raw)
            .level(level)
            .command_buffer_count(count);
        // SAFETY: the pool was just made; where the allocation fails it is destroyed, and nobody else has it.
        let buffers = unsafe {
            let buffers = device.allocate_command_buffers(&info);
            buffers.inspect_err(|_| device.destroy_command_pool(raw, None))
        };
        let buffers = buffers.subject("vkAllocateCommandBuffers", subject)?;
        for buffer in &buffers {
            shared.name(*buffer, subject);
        }
        Ok(Self {
            shared: shared.clone(),
            raw,
            buffers,
        })
    }

    /// Starts recording into one of the buffers, which is initial.
    fn begin(
        &self,
        row: usize,
        info: &vk::CommandBufferBeginInfo<'_>,
        subject: &str,
    ) -> Result<Recorder<'_>> {
        let (shared, raw) = (&self.shared, self.buffers[row]);
        // SAFETY: the callers own the pool, and have just made or reset it.
        unsafe { shared.device.begin_command_buffer(raw, info) }
            .subject("vkBeginCommandBuffer", subject)?;
        Ok(Recorder { shared, raw })
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        let pool = self.raw;
        // SAFETY: the graveyard calls this when all submissions are done; destroying the pool frees its buffers.
        let destroy = move |d: &ash::Device| unsafe { d.destroy_command_pool(pool, None) };
        self.shared.bury(Grave::Other(Box::new(destroy)));
    }
}

/// A command buffer that is recorded anew for every submission.
pub(crate) struct Commands(Pool);

impl Commands {
    pub(crate) fn new(shared: &Arc<Shared>, subject: &str) -> Result<Self> {
        let (flags, level) = (
            vk::CommandPoolCreateFlags::TRANSIENT,
            vk::CommandBufferLevel::PRIMARY,
        );
        Pool::new(shared, subject, flags, (level, 1)).map(Self)
    }

    /// Starts afresh. The previous submission has to be done, which is why this is for the modules that wait.
    pub(crate) fn begin(&mut self, subject: &str) -> Result<Recorder<'_>> {
        let Pool { shared, raw, .. } = &self.0;
        // SAFETY: the callers waited for the previous submission, so the pool's only buffer is not pending.
        unsafe {
            let flags = vk::CommandPoolResetFlags::empty();
            shared.device.reset_command_pool(*raw, flags)
        }
        .subject("vkResetCommandPool", subject)?;
        let info = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        self.0.begin(0, &info, subject)
    }

    /// Submits what was recorded; gives the submission's number.
    pub(crate) fn submit(&mut self, subject: &str) -> Result<u64> {
        let Pool {
            shared, buffers, ..
        } = &self.0;
        shared.queue.submit(&shared.device, buffers[0], subject)
    }
}

/// Command buffers that are recorded once, for others to execute as often as they like.
pub(crate) struct Secondaries(Pool);

impl Secondaries {
    /// Records so many; `record` is told which.
    pub(crate) fn new(
        shared: &Arc<Shared>,
        subject: &str,
        count: usize,
        mut record: impl FnMut(usize, &Recorder<'_>),
    ) -> Result<Self> {
        let (flags, level) = (
            vk::CommandPoolCreateFlags::empty(),
            vk::CommandBufferLevel::SECONDARY,
        );
        let pool = Pool::new(shared, subject, flags, (level, count as u32))?;
        let inheritance = vk::CommandBufferInheritanceInfo::default();
        let info = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::SIMULTANEOUS_USE)
            .inheritance_info(&inheritance);
        for row in 0..count {
            let recorder = pool.begin(row, &info, subject)?;
            record(row, &recorder);
            recorder.end(subject)?;
        }
        Ok(Self(pool))
    }

    /// For [`Recorder::execute`].
    pub(crate) fn raw(&self, row: usize) -> vk::CommandBuffer {
        self.0.buffers[row]
    }
}

/// Records, submits and waits. What it records comes after all that was submitted before, and the CPU sees its results.
pub(crate) fn immediate(
    shared: &Arc<Shared>,
    subject: &str,
    record: impl FnOnce(&Recorder<'_>) -> Result<()>,
) -> Result<()> {
    let mut commands = Commands::new(shared, subject)?;
    let recorder = commands.begin(subject)?;
    recorder.barrier(Scope::ALL, Scope::ALL);
    record(&recorder)?;
    recorder.barrier(Scope::ALL, Scope::HOST);
    recorder.end(subject)?;
    let number = commands.submit(subject)?;
    shared.queue.wait(&shared.device, number, subject)
}
