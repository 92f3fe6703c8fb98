//! Sampling of all fields into their tiles of the atlas (implicit skinning 2013, section 4.1): one dispatch, once a character.

use bytemuck::{Pod, Zeroable};

use crate::{
    gpu::{Access, Binding, Declaration},
    layout::field_grid::{FADE, SNAP},
};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "field_grid",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/field_grid.spv"
    )),
    bindings: &[
        Binding::read("fields"),
        Binding::read("centers"),
        Binding::read("segments"),
        Binding::new("atlas", Access::ImageWrite),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [4, 4, 4],
};

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Distances from the bone, in radii, between which the field fades.
    pub fade: [f32; 2],
    /// Values below this become 0, with their gradients.
    pub snap: f32,
}

/// The constants of every run.
pub const CONSTANTS: Constants = Constants {
    fade: FADE,
    snap: SNAP,
};

/// Workgroups for a number of fields: 8 × 8 × 8 a tile, the fields one after the other along z.
pub fn groups(fields: usize) -> [u32; 3] {
    [8, 8, 8 * fields as u32]
}
