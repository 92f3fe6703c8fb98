//! From welded vertices to the file's rows, positions bit for bit, normals with their hard edges.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Access, Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "scatter",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/scatter.spv"
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
            name: "rotations",
            access: Access::Read,
        },
        Binding {
            name: "positions",
            access: Access::Read,
        },
        Binding {
            name: "smooth_normals",
            access: Access::Read,
        },
        Binding {
            name: "skin_positions",
            access: Access::Write,
        },
        Binding {
            name: "skin_normals",
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
    /// Rows of the file.
    pub rows: u32,
}
