//! Order-preserving compaction of a work list, with the head of the new list for indirect dispatch.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "compact",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/compact.spv"
    )),
    bindings: &[
        Binding::read("list"),
        Binding::read_write("dispatches"),
        Binding::read("flags"),
        Binding::read("group_counts"),
        Binding::write("kept"),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [64, 1, 1],
};

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Row of the list's head.
    pub dispatch: u32,
    /// Row of the new list's head.
    pub result: u32,
    /// Low byte of a matching flag.
    pub wanted: u32,
}
