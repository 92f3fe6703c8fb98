//! Area-weighted normals of the welded mesh.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "normals",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/normals.spv"
    )),
    bindings: &[
        Binding::words("corner_offsets"),
        Binding::words("corners"),
        Binding::texels("positions"),
        Binding::write("smooth_normals"),
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
}
