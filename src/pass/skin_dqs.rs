//! Dual-quaternion skinning of positions and normals (Kavan et al. 2008), after blending the joints' stretches.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Access, Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "skin_dqs",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/skin_dqs.spv"
    )),
    bindings: &[
        Binding {
            name: "rows",
            access: Access::Read,
        },
        Binding {
            name: "row_normals",
            access: Access::Read,
        },
        Binding {
            name: "vertices",
            access: Access::Read,
        },
        Binding {
            name: "influence_joints",
            access: Access::Read,
        },
        Binding {
            name: "influence_weights",
            access: Access::Read,
        },
        Binding {
            name: "palette",
            access: Access::Read,
        },
        Binding {
            name: "positions",
            access: Access::Write,
        },
        Binding {
            name: "normals",
            access: Access::Write,
        },
        Binding {
            name: "rotations",
            access: Access::Write,
        },
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
}
