//! Result codes, the last error, and the boundary that no panic crosses.

use std::{
    any::Any,
    cell::RefCell,
    ffi::{CString, c_char},
    panic::{AssertUnwindSafe, catch_unwind},
};

use super::DM_API_VERSION;
use crate::Error;

/// What a function returns; every function but dm_api_version and dm_last_error has one.
///
/// Where it is not DM_OK, nothing has been written through pointers and objects are as before, unless the function says so, and
/// dm_last_error tells more. What failed by DM_ERROR_MEMORY may be tried again.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum dm_result {
    /// Success.
    DM_OK = 0,
    /// A pointer is NULL that must not be.
    DM_ERROR_NULL = 1,
    /// The size in a struct is not one that this version knows.
    DM_ERROR_STRUCT_SIZE = 2,
    /// A handle is zero, of another kind, or of an object that was destroyed.
    DM_ERROR_HANDLE = 3,
    /// Objects of different contexts.
    DM_ERROR_FOREIGN = 4,
    /// The program was compiled with a header of another version.
    DM_ERROR_VERSION = 5,
    /// An argument or a member of a struct is out of its range.
    DM_ERROR_ARGUMENT = 6,
    /// A file cannot be read, or its content cannot be used.
    DM_ERROR_FILE = 7,
    /// A pose has a matrix that is not finite, not affine or without inverse.
    DM_ERROR_POSE = 8,
    /// Memory ran out, or the budget would be passed.
    DM_ERROR_MEMORY = 9,
    /// A Vulkan call failed.
    DM_ERROR_VULKAN = 10,
    /// The device was lost. From the call that finds it on, every function of its context and of what was made in it returns
    /// this and does nothing, but the destroying ones, which succeed; the context's log is told once. Contexts may be made anew,
    /// by dm_context_adopt when the host has a new device.
    DM_ERROR_DEVICE_LOST = 11,
    /// No Vulkan loader or no device that fits.
    DM_ERROR_NO_DEVICE = 12,
    /// An array of the caller has not the length that it has to have; the message says which.
    DM_ERROR_SIZE = 13,
    /// A defect in dermis. The object that was in use can only be destroyed: all other calls on it return this.
    DM_ERROR_PANIC = 14,
}

/// A code and its message.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) code: dm_result,
    pub(super) message: String,
}

pub(super) type Outcome<T = ()> = Result<T, Fault>;

impl Fault {
    pub(super) fn new(code: dm_result, message: impl Into<String>) -> Self {
        let message = message.into();
        Self { code, message }
    }

    pub(super) fn argument(name: &str, reason: impl std::fmt::Display) -> Self {
        Self::new(dm_result::DM_ERROR_ARGUMENT, format!("{name}: {reason}"))
    }

    /// Refuses a program that was compiled with another version's header.
    pub(super) fn check_version(given: u32) -> Outcome {
        if given == DM_API_VERSION {
            return Ok(());
        }
        let message =
            format!("desc.api_version is {given}, the library has version {DM_API_VERSION}");
        Err(Self::new(dm_result::DM_ERROR_VERSION, message))
    }

    pub(super) fn size(name: &str, given: usize, wanted: usize) -> Self {
        let message = format!("{name}: {given} given, it has to be {wanted}");
        Self::new(dm_result::DM_ERROR_SIZE, message)
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::new(code(&error), error.to_string())
    }
}

fn code(error: &Error) -> dm_result {
    match error {
        Error::File { .. } | Error::Asset { .. } => dm_result::DM_ERROR_FILE,
        Error::Joint { .. } | Error::Primitive { .. } | Error::Argument { .. } => {
            dm_result::DM_ERROR_ARGUMENT
        }
        Error::Pose { .. } => dm_result::DM_ERROR_POSE,
        Error::NoDevice { .. } => dm_result::DM_ERROR_NO_DEVICE,
        Error::Memory { .. } => dm_result::DM_ERROR_MEMORY,
        Error::Vulkan { code, .. } => match code.as_str() {
            "ERROR_DEVICE_LOST" => dm_result::DM_ERROR_DEVICE_LOST,
            "ERROR_OUT_OF_HOST_MEMORY"
            | "ERROR_OUT_OF_DEVICE_MEMORY"
            | "ERROR_OUT_OF_POOL_MEMORY" => dm_result::DM_ERROR_MEMORY,
            _ => dm_result::DM_ERROR_VULKAN,
        },
        Error::Pass { .. } => dm_result::DM_ERROR_VULKAN,
    }
}

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// Runs the body of the exported function `call`; keeps its error for dm_last_error.
pub(super) fn guard(call: &str, body: impl FnOnce() -> Outcome) -> dm_result {
    // What a panic leaves half done is behind a mutex, which refuses from then on.
    let fault = match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(())) => return dm_result::DM_OK,
        Ok(Err(fault)) => fault,
        Err(payload) => Fault::new(dm_result::DM_ERROR_PANIC, panic_message(&*payload)),
    };
    keep(&format!("{call}: {}", fault.message));
    fault.code
}

fn panic_message(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    format!("a defect in dermis: {}", text.unwrap_or("panic"))
}

fn keep(message: &str) {
    let message = c_text(message);
    // Without the thread's storage, at the thread's end, the message is lost.
    let _ = LAST.try_with(|last| last.replace(message));
}

/// C text; what stands behind a zero byte is left out.
pub(super) fn c_text(text: &str) -> CString {
    let text = text.split('\0').next().unwrap_or_default();
    CString::new(text).unwrap_or_default()
}

/// Message of the last call of this thread that failed, in English and UTF-8; "" where none has failed. Never NULL.
///
/// It names the function, the argument and the reason. The text belongs to dermis and stays valid until this thread calls
/// another function of dermis or ends.
#[unsafe(no_mangle)]
pub extern "C" fn dm_last_error() -> *const c_char {
    LAST.try_with(|last| last.borrow().as_ptr())
        .unwrap_or(c"".as_ptr())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_a_code() {
        assert_eq!(guard("call", || panic!("test")), dm_result::DM_ERROR_PANIC);
        // SAFETY: valid until the next call.
        let text = unsafe { std::ffi::CStr::from_ptr(dm_last_error()) };
        assert_eq!(text, c"call: a defect in dermis: test");
    }

    #[test]
    fn a_lost_device_has_a_code_of_its_own() {
        let vulkan = |code: &str| Error::Vulkan {
            call: "vkQueueSubmit",
            subject: "frame".into(),
            code: code.into(),
        };
        let lost = format!("{:?}", ash::vk::Result::ERROR_DEVICE_LOST);
        assert_eq!(code(&vulkan(&lost)), dm_result::DM_ERROR_DEVICE_LOST);
        assert_eq!(code(&vulkan("?")), dm_result::DM_ERROR_VULKAN);
    }
}
