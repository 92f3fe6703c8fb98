//! Fleshing (2013): rows of the file that follow a spine of joints go where it bends them, blended with the method's skin.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "flesh",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/flesh.spv"
    )),
    bindings: &[
        Binding::texels("flesh_rows"),
        Binding::words("flesh_words"),
        Binding::texels("spine_weights"),
        Binding::texels("spine_points"),
        Binding::texels("palette"),
        Binding::read_write("skin_positions"),
        Binding::read_write("skin_normals"),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [64, 1, 1],
};

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Rows that follow a spine.
    pub count: u32,
    /// Rows of the file.
    pub rows: u32,
    /// Joints.
    pub joints: u32,
}
