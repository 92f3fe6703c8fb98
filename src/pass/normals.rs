//! Area-weighted normals of the welded mesh.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Access, Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "normals",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/normals.spv"
    )),
    bindings: &[
        Binding {
            name: "corner_offsets",
            access: Access::Read,
        },
        Binding {
            name: "corners",
            access: Access::Read,
        },
        Binding {
            name: "positions",
            access: Access::Read,
        },
        Binding {
            name: "smooth_normals",
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
    /// Welded vertices.
    pub vertices: u32,
}
