//! Projection of live vertices onto their iso-values (implicit skinning 2013, Eq. 4), with contact stops.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Access, Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "project",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/project.spv"
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
            name: "starts",
            access: Access::Read,
        },
        Binding {
            name: "geometric",
            access: Access::Read,
        },
        Binding {
            name: "vertices",
            access: Access::Read,
        },
        Binding {
            name: "iso_values",
            access: Access::Read,
        },
        Binding {
            name: "positions",
            access: Access::Write,
        },
        Binding {
            name: "anchors",
            access: Access::ReadWrite,
        },
        Binding {
            name: "gradients",
            access: Access::ReadWrite,
        },
        Binding {
            name: "status",
            access: Access::ReadWrite,
        },
        Binding {
            name: "group_counts",
            access: Access::Write,
        },
        Binding {
            name: "directions",
            access: Access::Read,
        },
        Binding {
            name: "rotations",
            access: Access::Read,
        },
        Binding {
            name: "fields",
            access: Access::Uniform,
        },
        Binding {
            name: "index",
            access: Access::Read,
        },
        Binding {
            name: "atlas",
            access: Access::Sampled,
        },
        Binding {
            name: "operators",
            access: Access::Sampled,
        },
        Binding {
            name: "opening",
            access: Access::Read,
        },
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [64, 1, 1],
};

/// No anchor from an earlier call.
pub const FRESH: u32 = 1;
/// Survivors have hit the iteration limit.
pub const LAST: u32 = 2;
/// Vertices in contact stay where they are and are only measured; new ones stay at their anchor.
pub const HOLD: u32 = 4;

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Row of the list's head.
    pub dispatch: u32,
    /// Newton steps of this call.
    pub steps: u32,
    /// Evaluations of the field in this call: one more than steps in the last call.
    pub evaluations: u32,
    /// [`FRESH`], [`LAST`], [`HOLD`].
    pub flags: u32,
    /// Step size σ.
    pub sigma: f32,
    /// |f − iso| that counts as settled.
    pub tolerance: f32,
    /// Cosine of the gradients' angle that counts as a discontinuity.
    pub cos_contact: f32,
}
