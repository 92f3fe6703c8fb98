//! From the skin to the host's vertex buffer, in the host's layout.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "output",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/output.spv"
    )),
    bindings: &[
        Binding::texels("skin_positions"),
        Binding::texels("skin_normals"),
        Binding::write("host_vertices"),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [64, 1, 1],
};

/// No normals are written.
pub const NO_NORMALS: u32 = 0;
/// Normals are three 32-bit floats.
pub const FLOAT_NORMALS: u32 = 1;
/// Normals are three signed normalised bytes, and a byte of 0.
pub const BYTE_NORMALS: u32 = 2;

/// Push constants; offsets and strides in words of 32 bits.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Rows of the file.
    pub rows: u32,
    /// Where the first vertex begins.
    pub offset: u32,
    /// From vertex to vertex.
    pub stride: u32,
    /// From a vertex's beginning to its normal.
    pub normal_offset: u32,
    /// From instance to instance.
    pub instance: u32,
    /// [`NO_NORMALS`], [`FLOAT_NORMALS`] or [`BYTE_NORMALS`].
    pub normals: u32,
}
