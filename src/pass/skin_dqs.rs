//! Dual-quaternion skinning of positions and normals (Kavan et al. 2008), after blending the joints' stretches.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "skin_dqs",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/skin_dqs.spv"
    )),
    bindings: &[
        Binding::words("rows"),
        Binding::texels("row_normals"),
        Binding::texels("vertices"),
        Binding::words("influence_joints"),
        Binding::words("influence_weights"),
        Binding::texels("palette"),
        Binding::write("positions"),
        Binding::write("normals"),
        Binding::write("rotations"),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [64, 1, 1],
};

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Rows to skin.
    pub rows: u32,
    /// Influences a vertex.
    pub width: u32,
    /// Joints.
    pub joints: u32,
}
