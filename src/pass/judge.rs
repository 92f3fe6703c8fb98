//! Faults that a step of tracking left: vertices that went too far, or with an inverted triangle outside contacts.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "judge",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/judge.spv"
    )),
    bindings: &[
        Binding::words("list"),
        Binding::words("dispatches"),
        Binding::words("corner_offsets"),
        Binding::words("corners"),
        Binding::texels("bodies"),
        Binding::texels("tracks"),
        Binding::texels("slopes"),
        Binding::texels("field_poses"),
        Binding::texels("tracked"),
        Binding::texels("vertices"),
        Binding::texels("palette"),
        Binding::read_write("faults"),
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
    /// Welded vertices.
    pub vertices: u32,
    /// Joints.
    pub joints: u32,
    /// Fields that an instance's part has room for.
    pub fields: u32,
}
