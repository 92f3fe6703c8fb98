//! The C library: nothing but the exports of the Rust library's module `capi`.

pub use dermis::capi::*;
