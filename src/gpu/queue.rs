//! The one queue; submissions are numbered by a timeline semaphore.

use std::sync::Mutex;

use ash::vk;

use super::fault::{Subject, lock};
use crate::Result;

/// A queue whose n-th submission raises the semaphore to n.
pub(crate) struct Queue {
    raw: vk::Queue,
    timeline: vk::Semaphore,
    submitted: Mutex<u64>,
}

impl Queue {
    /// Numbers the submissions to `raw`, a queue of `device`.
    pub(crate) fn new(device: &ash::Device, raw: vk::Queue) -> Result<Self> {
        let mut kind =
            vk::SemaphoreTypeCreateInfo::default().semaphore_type(vk::SemaphoreType::TIMELINE);
        let info = vk::SemaphoreCreateInfo::default().push_next(&mut kind);
        // SAFETY: the device is alive and was created with timeline semaphores.
        let timeline = unsafe { device.create_semaphore(&info, None) };
        Ok(Self {
            raw,
            timeline: timeline.subject("vkCreateSemaphore", "queue")?,
            submitted: Mutex::new(0),
        })
    }

    /// Number of the latest submission.
    pub(crate) fn submitted(&self) -> u64 {
        *lock(&self.submitted)
    }

    /// Number of the latest submission that is done; 0 when the device cannot tell any more.
    pub(crate) fn completed(&self, device: &ash::Device) -> u64 {
        // SAFETY: device and semaphore are alive.
        unsafe { device.get_semaphore_counter_value(self.timeline) }.unwrap_or(0)
    }

    /// Submits a recorded command buffer and gives the submission's number. `subject` names it in errors.
    pub(crate) fn submit(
        &self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        subject: &str,
    ) -> Result<u64> {
        let mut submitted = lock(&self.submitted);
        let (buffers, semaphores, values) = ([commands], [self.timeline], [*submitted + 1]);
        let mut timeline =
            vk::TimelineSemaphoreSubmitInfo::default().signal_semaphore_values(&values);
        let info = vk::SubmitInfo::default()
            .command_buffers(&buffers)
            .signal_semaphores(&semaphores)
            .push_next(&mut timeline);
        // SAFETY: the command buffer is recorded and not pending (its owner waits before it records again), the arrays
        // live until the call returns, and the lock makes this thread the queue's only user.
        unsafe { device.queue_submit(self.raw, &[info], vk::Fence::null()) }
            .subject("vkQueueSubmit", subject)?;
        *submitted += 1;
        Ok(*submitted)
    }

    /// Waits for a submission.
    pub(crate) fn wait(&self, device: &ash::Device, number: u64, subject: &str) -> Result<()> {
        let (semaphores, values) = ([self.timeline], [number]);
        let info = vk::SemaphoreWaitInfo::default()
            .semaphores(&semaphores)
            .values(&values);
        // SAFETY: device and semaphore are alive; the number was submitted, so that it will be signalled.
        unsafe { device.wait_semaphores(&info, u64::MAX) }.subject("vkWaitSemaphores", subject)
    }

    /// Destroys the semaphore; the device has to be idle and nobody may use the queue after it.
    pub(crate) fn destroy(&self, device: &ash::Device) {
        // SAFETY: see above; called once, at the device's end.
        unsafe { device.destroy_semaphore(self.timeline, None) };
    }
}
