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
        Binding::read("list"),
        Binding::read("dispatches"),
        Binding::read("ring_offsets"),
        Binding::read("rings"),
        Binding::read("mean_values"),
        Binding::read("positions"),
        Binding::read("anchors"),
        Binding::read("gradients"),
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
}
