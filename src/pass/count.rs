//! Counts, a workgroup, the listed vertices whose flags match, for the compaction that follows.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "count",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/count.spv"
    )),
    bindings: &[
        Binding::read("list"),
        Binding::read("dispatches"),
        Binding::read("flags"),
        Binding::write("group_counts"),
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
    /// Low byte of a matching flag.
    pub wanted: u32,
}
