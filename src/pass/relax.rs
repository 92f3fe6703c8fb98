//! Tangential relaxation with mean value coordinates (implicit skinning 2013, Eqs. 5 and 6).

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Access, Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "relax",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/relax.spv"
    )),
    bindings: &[
        Binding {
            name: "list",
            access: Access::Read,
        },
        Binding {
            name: "dispatches",
            access: Access::Read,
        },
        Binding {
            name: "ring_offsets",
            access: Access::Read,
        },
        Binding {
            name: "rings",
            access: Access::Read,
        },
        Binding {
            name: "mean_values",
            access: Access::Read,
        },
        Binding {
            name: "positions",
            access: Access::Read,
        },
        Binding {
            name: "anchors",
            access: Access::Read,
        },
        Binding {
            name: "gradients",
            access: Access::Read,
        },
        Binding {
            name: "relaxed",
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
    /// Row of the list's head.
    pub dispatch: u32,
}
