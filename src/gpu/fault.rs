//! From Vulkan's result codes to errors that name the call and its subject.

use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::{prelude::VkResult, vk};

use crate::{Error, Result};

/// Names the subject of a Vulkan call that may fail.
pub(crate) trait Subject<T> {
    /// Turns a result code into an [`Error`] that names `call` and `subject`.
    fn subject(self, call: &'static str, subject: &str) -> Result<T>;
}

impl<T> Subject<T> for VkResult<T> {
    fn subject(self, call: &'static str, subject: &str) -> Result<T> {
        self.map_err(|code| vulkan(call, subject, code))
    }
}

/// An [`Error::Vulkan`].
pub(crate) fn vulkan(call: &'static str, subject: &str, code: vk::Result) -> Error {
    Error::Vulkan {
        call,
        subject: subject.to_owned(),
        code: format!("{code:?}"),
    }
}

/// Locks even after a panic elsewhere: what the mutexes here guard is consistent between any two statements.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
