//! Takes the samples of a projection and does nothing else: the ceiling of passes that follow fields, where they follow them.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Access, Binding, Declaration};

/// Places of an invocation.
pub const SAMPLES: u32 = 4;

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "ceiling_replay",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/ceiling_replay.spv"
    )),
    bindings: &[
        Binding::texels("places"),
        Binding::new("atlas", Access::Sampled),
        Binding::write("sums"),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [64, 1, 1],
};

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Invocations, [`SAMPLES`] places each.
    pub count: u32,
    /// Samples a place.
    pub repeats: u32,
}
