//! Copies vectors as fast as the device can: the ceiling of passes that stream vertices.

use crate::gpu::{Access, Binding, Declaration};

/// `count` invocations copy one vec4 each.
pub const DECLARATION: Declaration = Declaration {
    name: "ceiling_copy",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/ceiling_copy.spv"
    )),
    bindings: &[
        Binding {
            name: "source",
            access: Access::Read,
        },
        Binding {
            name: "target",
            access: Access::Write,
        },
    ],
    constants: 4,
    local_size: [64, 1, 1],
};
