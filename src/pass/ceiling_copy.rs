//! Copies vectors as fast as the device can: the ceiling of passes that stream vertices.

use crate::gpu::{Binding, Declaration};

/// `count` invocations copy one vec4 each.
pub const DECLARATION: Declaration = Declaration {
    name: "ceiling_copy",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/ceiling_copy.spv"
    )),
    bindings: &[Binding::read("source"), Binding::write("target")],
    constants: 4,
    local_size: [64, 1, 1],
};
