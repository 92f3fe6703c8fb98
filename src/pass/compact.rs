//! The list of a set's vertices, in the order of the seeds, with its head for indirect dispatch.

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
        Binding::words("seeds"),
        Binding::words("members"),
        Binding::read_write("dispatches"),
        Binding::write("listed"),
        Binding::texels("field_poses"),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [64, 1, 1],
};

/// Seeds of an invocation.
pub const SEEDS: u32 = 8;

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Row of the list's head.
    pub result: u32,
    /// Welded vertices.
    pub vertices: u32,
    /// Fields that an instance's part has room for.
    pub fields: u32,
    /// Number of the round of iterations, from the frame's beginning on; 0 outside of rounds.
    pub round: u32,
}
