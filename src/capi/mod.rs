//! The C interface, `include/dermis.h`: contexts, rigs, deformers, spines and sphere-meshes behind handles, with error codes.
//!
//! `tools/libdermis` makes the C library of it; `cargo xtask header` writes the header, in which the documentation of these
//! items is the manual. Only the public side of the crate is used here.
//!
//! The one global state is the table of handles (`handle.rs`); the last error is a thread's own (`guard.rs`).
// Rust and C share one name for everything.
#![allow(non_camel_case_types, clippy::upper_case_acronyms)]

// The header has its items in this order.
mod guard;
mod handle;
mod log;
mod pointer;

mod context;
mod devices;
mod vulkan;

mod mesh;
mod options;
mod rig;
mod shapes;
mod skeleton;

mod deformer;
mod embed;
mod report;
mod settings;

mod flesh;
mod spine;

mod spheres;

mod levels;

mod collide;

mod particles;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod panic_tests;

pub use collide::*;
pub use context::*;
pub use deformer::*;
pub use devices::*;
pub use embed::*;
pub use flesh::*;
pub use guard::*;
pub use handle::*;
pub use levels::*;
pub use log::*;
pub use mesh::*;
pub use options::*;
pub use particles::*;
pub use report::*;
pub use rig::*;
pub use settings::*;
pub use shapes::*;
pub use skeleton::*;
pub use spheres::*;
pub use spine::*;
pub use vulkan::*;

/// Version of this interface; dm_context_desc has the one that a program was compiled with.
pub const DM_API_VERSION: u32 = 1;

/// Version of the interface that the library has: DM_API_VERSION of its own header.
///
/// Threads: any, at any time.
#[unsafe(no_mangle)]
pub extern "C" fn dm_api_version() -> u32 {
    DM_API_VERSION
}
