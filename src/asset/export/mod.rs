//! Files out: PLY and OBJ for one frame, these and OFF for a mesh, GLB for a baked animation, a rigged character or moving spheres;
//! each written as a whole or not at all.

mod atomic;
mod frame;
mod glb;
mod morph;
mod skinned;
mod spheres;
mod surface;
#[cfg(test)]
mod tests;

pub use atomic::write_atomic;
pub use frame::{PlyFrame, write_obj, write_ply};
pub use morph::{MorphAnimation, MorphFrame, write_glb_morph};
pub use skinned::write_glb_skinned;
pub use spheres::{SphereAnimation, SpherePath, SurfaceMesh, write_glb_spheres};
pub use surface::{SurfaceFormat, SurfaceFrame, write_surface};
