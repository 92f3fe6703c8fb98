//! End of a frame of tracking: the settled skin follows the tracked one at the pace of what moves around it.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Access, Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "ease",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/ease.spv"
    )),
    bindings: &[
        Binding::words("list"),
        Binding::words("dispatches"),
        Binding::texels("tracked"),
        Binding::words("stirs"),
        Binding::texels("bodies"),
        Binding::texels("vertices"),
        Binding::texels("palette"),
        Binding::read_write("corrections"),
        Binding::read_write("positions"),
        Binding::read_write("status"),
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
    /// Row of the list's head.
    pub dispatch: u32,
    /// Welded vertices.
    pub vertices: u32,
    /// Joints.
    pub joints: u32,
    /// Fields that an instance's part has room for.
    pub fields: u32,
    /// |f − iso| that counts as settled.
    pub tolerance: f32,
}
