//! Index of the posed field boxes on a 32³ grid: a bit mask of fields a cell.

use crate::gpu::{Access, Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "index",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/index.spv"
    )),
    bindings: &[
        Binding::new("fields", Access::Uniform),
        Binding::texels("field_poses"),
        Binding::words("field_words"),
        Binding::read_write("index"),
    ],
    constants: 0,
    local_size: [64, 1, 1],
};
