//! Samples a 3D atlas as fast as the device can: the ceiling of passes that follow fields.

use crate::gpu::{Access, Binding, Declaration};

/// Samples an invocation takes.
pub const SAMPLES: u32 = 16;

/// `count` invocations write the sum of their [`SAMPLES`] samples.
pub const DECLARATION: Declaration = Declaration {
    name: "ceiling_fetch",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/ceiling_fetch.spv"
    )),
    bindings: &[
        Binding::new("atlas", Access::Sampled),
        Binding::write("sums"),
    ],
    constants: 4,
    local_size: [64, 1, 1],
};
