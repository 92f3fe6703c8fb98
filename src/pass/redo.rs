//! Decides whether a step of tracking is done again in two halves.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "redo",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/redo.spv"
    )),
    bindings: &[
        Binding::read("faults"),
        Binding::words("seed_dispatches"),
        Binding::read_write("dispatches"),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [1, 1, 1],
};

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Row of the halves' head; of the seeds' heads, its number of items is that of the faults at rest.
    pub redo: u32,
    /// Welded vertices.
    pub vertices: u32,
    /// Faults more than at rest that are left as they are.
    pub allowed: u32,
}
