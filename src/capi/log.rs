//! What a context tells besides results: warnings, and the messages of the validation layers.

use std::{
    ffi::{c_char, c_void},
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use super::guard::{Fault, Outcome, c_text, dm_result};
use crate::gpu::Gpu;

/// Level of a message: a call failed, or Vulkan's validation layers complain.
pub const DM_LOG_ERROR: i32 = 0;
/// Level of a message: something was mended or left out.
pub const DM_LOG_WARNING: i32 = 1;
/// Level of a message: for information.
pub const DM_LOG_INFO: i32 = 2;

/// Receives messages of a context: its own user pointer, DM_LOG_ERROR, DM_LOG_WARNING or DM_LOG_INFO, and text in UTF-8
/// that is valid during the call only.
///
/// It is called within calls of dermis, by the thread that made the call; calls on several threads may call it at once.
/// No object is locked meanwhile, so that it may call dermis. It must return: neither throw nor jump. NULL for none.
pub type dm_log =
    Option<unsafe extern "C" fn(user: *mut c_void, level: i32, message: *const c_char)>;

/// The function and pointer of a user.
pub(super) struct Target {
    pub(super) log: dm_log,
    pub(super) user: *mut c_void,
}

// SAFETY: the pointer is only handed to the function, which by contract may be called on any thread.
unsafe impl Send for Target {}
// SAFETY: as above.
unsafe impl Sync for Target {}

/// Tells a user what happens in a context.
pub(super) struct Logger {
    target: Target,
    /// None on the CPU.
    gpu: Option<Gpu>,
    validated: bool,
    /// That the device is lost is told once.
    told_loss: AtomicBool,
    /// Messages of the validation layers that were passed on.
    told: Mutex<usize>,
}

impl Logger {
    pub(super) fn new(target: Target, gpu: Option<Gpu>, validated: bool) -> Arc<Self> {
        Arc::new(Self {
            target,
            gpu,
            validated,
            told_loss: AtomicBool::new(false),
            told: Mutex::new(0),
        })
    }

    /// Fails where the device is lost.
    pub(super) fn check(&self) -> Outcome {
        let gpu = self.gpu.as_ref();
        Ok(gpu.map_or(Ok(()), Gpu::check)?)
    }

    pub(super) fn tell(&self, level: i32, message: &str) {
        let Some(log) = self.target.log else { return };
        let message = c_text(message);
        // SAFETY: the user's function and pointer, valid as long as the context by contract; the text lives until it returns.
        unsafe { log(self.target.user, level, message.as_ptr()) }
    }

    /// Tells what the layers said since the last time.
    pub(super) fn flush(&self) {
        let Some(gpu) = self.gpu.as_ref().filter(|_| self.validated) else {
            return;
        };
        let messages = gpu.validation_messages();
        let first = {
            let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
            std::mem::replace(&mut *told, messages.len()).min(messages.len())
        };
        for message in &messages[first..] {
            self.tell(DM_LOG_ERROR, message);
        }
    }

    /// Passes a result on after telling what belongs to it.
    pub(super) fn finish<T>(&self, outcome: Outcome<T>) -> Outcome<T> {
        self.flush();
        if let Err(Fault { code, message }) = &outcome {
            let loss = *code == dm_result::DM_ERROR_DEVICE_LOST;
            if !loss || !self.told_loss.swap(true, Ordering::Relaxed) {
                self.tell(DM_LOG_ERROR, message);
            }
        }
        outcome
    }
}
