//! The C interface: its header, its symbols, misuse of every function, and the skin that it gives.
#![allow(clippy::unwrap_used)]

mod calls;
mod compiler;
mod facade;
mod flesh_calls;
mod host;
mod host_calls;
mod host_device;
mod misuse;
mod raw;
mod release;
mod skin;
mod sphere_calls;
mod spheres;
mod symbols;
mod tells;

use std::{
    ffi::{CStr, c_char, c_void},
    path::PathBuf,
    sync::Mutex,
};

use dermis::capi::{dm_last_error, dm_result};

/// The root of the workspace.
fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The header as it is committed.
fn header() -> String {
    std::fs::read_to_string(root().join("include/dermis.h")).unwrap()
}

/// This thread's last error.
fn last_error() -> String {
    // SAFETY: never NULL, and valid until the next call.
    let text = unsafe { CStr::from_ptr(dm_last_error()) };
    text.to_str().unwrap().to_owned()
}

/// `DERMIS_NO_GPU=1` asks to leave out what needs a device.
fn no_gpu() -> bool {
    let skip = std::env::var("DERMIS_NO_GPU").is_ok_and(|v| v == "1");
    if skip {
        eprintln!("skipped: DERMIS_NO_GPU=1");
    }
    skip
}

/// Fails with the last error where a call did not succeed.
#[track_caller]
fn fine(result: dm_result) {
    assert_eq!(result, dm_result::DM_OK, "{}", last_error());
}

/// Messages of a context, with their levels.
type Messages = Mutex<Vec<(i32, String)>>;

/// Keeps a message in the [`Messages`] that `user` points to.
unsafe extern "C" fn keep(user: *mut c_void, level: i32, message: *const c_char) {
    // SAFETY: the tests pass a list that outlives the context, and the text is valid during the call.
    let (messages, text) = unsafe { (&*user.cast::<Messages>(), CStr::from_ptr(message)) };
    let text = text.to_str().unwrap().to_owned();
    messages.lock().unwrap().push((level, text));
}
