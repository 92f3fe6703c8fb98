//! The one queue; submissions are numbered by a timeline semaphore.

use std::{
    sync::{Mutex, OnceLock},
    thread,
    time::Duration,
};

use ash::{prelude::VkResult, vk};

use super::fault::{Subject, lock, vulkan};
use crate::Result;

/// How often a wait is tried that fails for another reason than a lost device, and how long it rests in between.
const TRIES: u32 = 100;
const REST: Duration = Duration::from_millis(1);

const LOST: vk::Result = vk::Result::ERROR_DEVICE_LOST;

/// A queue whose n-th submission raises the semaphore to n.
pub(crate) struct Queue {
    raw: vk::Queue,
    timeline: vk::Semaphore,
    submitted: Mutex<u64>,
    /// The call that found the device lost, and what it was for. There is no way back.
    lost: OnceLock<(&'static str, String)>,
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
            lost: OnceLock::new(),
        })
    }

    /// Fails, as the call did that found it, where the device is lost.
    pub(crate) fn check(&self) -> Result<()> {
        match self.lost.get() {
            Some((call, subject)) => Err(vulkan(call, subject, LOST)),
            None => Ok(()),
        }
    }

    /// Keeps in mind where a call found the device lost.
    pub(crate) fn note<T>(
        &self,
        result: VkResult<T>,
        call: &'static str,
        subject: &str,
    ) -> Result<T> {
        if matches!(result, Err(LOST)) {
            _ = self.lost.set((call, subject.to_owned()));
        }
        result.subject(call, subject)
    }

    /// Number of the latest submission.
    pub(crate) fn submitted(&self) -> u64 {
        *lock(&self.submitted)
    }

    /// Number of the latest submission that is done; 0 when the device cannot tell any more.
    pub(crate) fn completed(&self, device: &ash::Device) -> u64 {
        // SAFETY: device and semaphore are alive.
        let value = unsafe { device.get_semaphore_counter_value(self.timeline) };
        let value = self.note(value, "vkGetSemaphoreCounterValue", "queue");
        value.unwrap_or(0)
    }

    /// Submits a recorded command buffer and gives the submission's number. `subject` names it in errors.
    pub(crate) fn submit(
        &self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        subject: &str,
    ) -> Result<u64> {
        self.check()?;
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
        let submission = unsafe { device.queue_submit(self.raw, &[info], vk::Fence::null()) };
        self.note(submission, "vkQueueSubmit", subject)?;
        *submitted += 1;
        Ok(*submitted)
    }

    /// Waits for a submission.
    pub(crate) fn wait(&self, device: &ash::Device, number: u64, subject: &str) -> Result<()> {
        self.check()?;
        self.wait_for(device, number, subject)
    }

    /// Waits for all submissions at the device's end, where nothing can be told and nothing may be destroyed before: a wait that
    /// runs out of memory is tried again. Of a lost device it ends at once or when the driver has given up its work.
    pub(crate) fn drain(&self, device: &ash::Device) {
        let number = self.submitted();
        for _ in 0..TRIES {
            match self.wait_for(device, number, "device") {
                Err(_) if self.check().is_ok() => thread::sleep(REST),
                _ => return,
            }
        }
    }

    fn wait_for(&self, device: &ash::Device, number: u64, subject: &str) -> Result<()> {
        let (semaphores, values) = ([self.timeline], [number]);
        let info = vk::SemaphoreWaitInfo::default()
            .semaphores(&semaphores)
            .values(&values);
        // SAFETY: device and semaphore are alive; the number was submitted, so that it will be signalled.
        let waited = unsafe { device.wait_semaphores(&info, u64::MAX) };
        self.note(waited, "vkWaitSemaphores", subject)
    }

    /// Destroys the semaphore; the device has to be idle and nobody may use the queue after it.
    pub(crate) fn destroy(&self, device: &ash::Device) {
        // SAFETY: see above; called once, at the device's end.
        unsafe { device.destroy_semaphore(self.timeline, None) };
    }
}
