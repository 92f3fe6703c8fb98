//! One step of the diffusion of β over the mesh (implicit skinning 2013, section 5).

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "diffuse",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/diffuse.spv"
    )),
    bindings: &[
        Binding::words("list"),
        Binding::words("dispatches"),
        Binding::words("ring_offsets"),
        Binding::words("rings"),
        Binding::words("status"),
        Binding::words("betas"),
        Binding::write("diffused"),
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
    /// β is the contact state.
    pub first: u32,
}
