//! One iteration of tracking: relaxation, then Newton (2014, section 5.2).

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Access, Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "track",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/track.spv"
    )),
    bindings: &[
        Binding::words("list"),
        Binding::words("dispatches"),
        Binding::words("ring_offsets"),
        Binding::words("rings"),
        Binding::words("ring_weights"),
        Binding::texels("bodies"),
        Binding::texels("goals"),
        Binding::texels("starts"),
        Binding::texels("befores"),
        Binding::texels("slopes"),
        Binding::write("tracks"),
        Binding::write("gradients"),
        Binding::texels("field_poses"),
        Binding::words("field_words"),
        Binding::words("index"),
        Binding::new("atlas", Access::Sampled),
        Binding::new("operators", Access::Sampled),
        Binding::words("opening"),
        Binding::read_write("live_set"),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [64, 1, 1],
};

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Row of the list's head.
    pub dispatch: u32,
    /// Welded vertices.
    pub vertices: u32,
    /// Fields that an instance's part has room for.
    pub fields: u32,
    /// 1: those that still move enter the set for the next list, with their neighbours.
    pub enter: u32,
    /// ω of the semi-iteration, 1 for none of it.
    pub omega: f32,
    /// Share of the Newton step.
    pub sigma: f32,
    /// Movement that counts as rest, over the radius.
    pub stillness: f32,
}
