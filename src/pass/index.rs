//! Index of the posed field boxes on a 32³ grid: a bit mask of fields a cell.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "index",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/index.spv"
    )),
    bindings: &[
        Binding::texels("field_poses"),
        Binding::words("field_words"),
        Binding::read_write("index"),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [64, 1, 1],
};

/// Workgroups that share one field's cells.
pub const SLICES: u32 = 4;

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Fields that an instance's part has room for.
    pub fields: u32,
}
