//! The composed field at every vertex of the rest pose: iso-values and the directions of the gradients.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Access, Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "measure",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/measure.spv"
    )),
    bindings: &[
        Binding::texels("positions"),
        Binding::write("values"),
        Binding::write("directions"),
        Binding::texels("field_poses"),
        Binding::words("field_words"),
        Binding::words("index"),
        Binding::new("atlas", Access::Sampled),
        Binding::new("operators", Access::Sampled),
        Binding::words("opening"),
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
