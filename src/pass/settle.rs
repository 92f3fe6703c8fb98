//! The skin of a tracked frame: onto the iso-values, measured, with the vertices' states.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Access, Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "settle",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/settle.spv"
    )),
    bindings: &[
        Binding::words("list"),
        Binding::words("dispatches"),
        Binding::texels("starts"),
        Binding::texels("bodies"),
        Binding::words("seed_ranks"),
        Binding::write("positions"),
        Binding::read_write("status"),
        Binding::read_write("contact_set"),
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
    /// Fields that an instance's part has room for.
    pub fields: u32,
    /// Length of an instance's part of the list; 0 where all instances share it.
    pub listed: u32,
    /// Newton steps.
    pub steps: u32,
    /// 1: vertices in contact stay where they are and are only measured.
    pub hold: u32,
    /// Share of a step.
    pub sigma: f32,
    /// |f − iso| that counts as settled.
    pub tolerance: f32,
    /// Cosine of the gradients' angle that counts as a discontinuity.
    pub cos_contact: f32,
}
