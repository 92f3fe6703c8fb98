//! From welded vertices to the file's rows, positions bit for bit, normals with their hard edges.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "scatter",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/scatter.spv"
    )),
    bindings: &[
        Binding::words("rows"),
        Binding::texels("row_normals"),
        Binding::texels("vertices"),
        Binding::texels("rotations"),
        Binding::texels("positions"),
        Binding::texels("smooth_normals"),
        Binding::write("skin_positions"),
        Binding::write("skin_normals"),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [64, 1, 1],
};

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Rows of the file.
    pub rows: u32,
    /// Welded vertices.
    pub vertices: u32,
}
