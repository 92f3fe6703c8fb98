//! Projection of live vertices onto their iso-values (implicit skinning 2013, Eq. 4), with contact stops.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Access, Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "project",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/project.spv"
    )),
    bindings: &[
        Binding::words("list"),
        Binding::words("dispatches"),
        Binding::texels("starts"),
        Binding::texels("geometric"),
        Binding::texels("vertices"),
        Binding::words("iso_values"),
        Binding::write("positions"),
        Binding::read_write("anchors"),
        Binding::read_write("gradients"),
        Binding::read_write("status"),
        Binding::read_write("live_set"),
        Binding::texels("directions"),
        Binding::texels("rotations"),
        Binding::read_write("contact_set"),
        Binding::words("seed_ranks"),
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

/// No anchor from an earlier call.
pub const FRESH: u32 = 1;
/// Survivors have hit the iteration limit.
pub const LAST: u32 = 2;
/// Vertices in contact stay where they are and are only measured; new ones stay at their anchor.
pub const HOLD: u32 = 4;

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
    /// Newton steps of this call.
    pub steps: u32,
    /// Evaluations of the field in this call: one more than steps in the last call.
    pub evaluations: u32,
    /// [`FRESH`], [`LAST`], [`HOLD`].
    pub flags: u32,
    /// Step size σ.
    pub sigma: f32,
    /// |f − iso| that counts as settled.
    pub tolerance: f32,
    /// Cosine of the gradients' angle that counts as a discontinuity.
    pub cos_contact: f32,
}
