//! The constant part of the Jacobi iteration on the relaxation energy (2014, Eq. 3).

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "goals",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/goals.spv"
    )),
    bindings: &[
        Binding::words("ring_offsets"),
        Binding::words("rings"),
        Binding::words("ring_weights"),
        Binding::texels("vertices"),
        Binding::texels("rotations"),
        Binding::texels("field_poses"),
        Binding::texels("geometric"),
        Binding::words("stirs"),
        Binding::write("goals"),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [64, 1, 1],
};

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Welded vertices.
    pub vertices: u32,
    /// Fields that an instance's part has room for.
    pub fields: u32,
}
