//! Particles fall for a frame and bounce off a sphere-mesh that moves (sphere-meshes 2016, section 6.1 and appendix B).

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Binding, Declaration};

/// The pass as the frame sees it.
pub const DECLARATION: Declaration = Declaration {
    name: "particles",
    spirv: include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/shaders/spirv/particles.spv"
    )),
    bindings: &[
        Binding::texels("particle_solids"),
        Binding::read_write("particle_positions"),
        Binding::read_write("particle_velocities"),
    ],
    constants: size_of::<Constants>() as u32,
    local_size: [64, 1, 1],
};

/// What counts as touching, against sizes and coordinates: less than that inside is on the surface.
pub const TOUCH: f32 = 4e-6;

/// Share of a way that goes inwards by rounding.
pub const SLIDE: f32 = 1e-6;

/// Push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Constants {
    /// Acceleration of all particles.
    pub gravity: [f32; 3],
    /// Seconds of the frame.
    pub seconds: f32,
    /// Share of the normal speed that a bounce leaves.
    pub restitution: f32,
    /// Coulomb's coefficient.
    pub friction: f32,
    /// Diagonal of the sphere-mesh's box.
    pub size: f32,
    /// Particles.
    pub count: u32,
    /// Solids of the sphere-mesh.
    pub solids: u32,
    /// Contacts of a particle in a frame, at most.
    pub contacts: u32,
    /// Rounds in which a particle's place on a solid is found; 0 where nothing moves.
    pub carries: u32,
}
