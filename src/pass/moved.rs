//! The seeds that have to be projected: those that do not move as one with all fields around them.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "moved",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/moved.spv"
    )),
    bindings: &[
        Binding::words("list"),
        Binding::words("dispatches"),
        Binding::texels("geometric"),
        Binding::words("iso_values"),
        Binding::texels("directions"),
        Binding::words("influence_joints"),
        Binding::words("influence_weights"),
        Binding::texels("palette"),
        Binding::words("seed_ranks"),
        Binding::write("positions"),
        Binding::write("status"),
        Binding::read_write("live_set"),
        Binding::texels("field_poses"),
        Binding::words("field_words"),
        Binding::words("index"),
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
    /// Influences a vertex.
    pub width: u32,
}
