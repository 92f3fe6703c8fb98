//! Tangential relaxation with mean value coordinates (implicit skinning 2013, Eqs. 5 and 6).

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "relax",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/relax.spv"
    )),
    bindings: &[
        Binding::words("list"),
        Binding::words("dispatches"),
        Binding::words("ring_offsets"),
        Binding::words("rings"),
        Binding::words("mean_values"),
        Binding::texels("positions"),
        Binding::texels("anchors"),
        Binding::texels("gradients"),
        Binding::write("relaxed"),
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
}
