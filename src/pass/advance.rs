//! Begin of a tracking step: positions carried on by the change of their part's joint (2014, section 5).

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "advance",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/advance.spv"
    )),
    bindings: &[
        Binding::texels("tracked"),
        Binding::texels("tracked_before"),
        Binding::texels("tracked_slopes"),
        Binding::texels("geometric"),
        Binding::texels("vertices"),
        Binding::texels("bodies"),
        Binding::words("influence_joints"),
        Binding::words("influence_weights"),
        Binding::texels("palette"),
        Binding::texels("directions"),
        Binding::write("track_a"),
        Binding::write("track_b"),
        Binding::write("track_c"),
        Binding::write("slopes_a"),
        Binding::write("slopes_b"),
        Binding::read_write("around"),
        Binding::read_write("stirs"),
        Binding::read_write("live_set"),
        Binding::words("dispatches"),
        Binding::texels("field_poses"),
        Binding::words("field_words"),
        Binding::words("index"),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [64, 1, 1],
};

/// No row: a whole step.
pub const NO_ROW: u32 = u32::MAX;

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Welded vertices.
    pub vertices: u32,
    /// Influences a vertex.
    pub width: u32,
    /// Movement that counts as rest, over the part's radius.
    pub stillness: f32,
    /// Joints.
    pub joints: u32,
    /// Fields that an instance's part has room for.
    pub fields: u32,
    /// Row whose number of items says whether the skin is carried on into a half; [`NO_ROW`] for a whole step.
    pub redo: u32,
}
