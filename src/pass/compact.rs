//! Order-preserving compaction of a work list, with the head of the new list for indirect dispatch.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Access, Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "compact",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/compact.spv"
    )),
    bindings: &[
        Binding {
            name: "list",
            access: Access::Read,
        },
        Binding {
            name: "dispatches",
            access: Access::ReadWrite,
        },
        Binding {
            name: "flags",
            access: Access::Read,
        },
        Binding {
            name: "group_counts",
            access: Access::Read,
        },
        Binding {
            name: "kept",
            access: Access::Write,
        },
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
