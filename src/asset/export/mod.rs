//! Files out: PLY and OBJ for one frame, these and OFF for a mesh, GLB for a baked animation or a rigged character; each written as a whole or not
//! at all.

mod atomic;
mod frame;
mod glb;
mod morph;
mod skinned;
mod surface;
#[cfg(test)]
mod tests;

pub use atomic::write_atomic;
pub use frame::{PlyFrame, write_obj, write_ply};
pub use morph::{MorphAnimation, MorphFrame, write_glb_morph};
pub use skinned::write_glb_skinned;
pub use surface::{SurfaceFormat, SurfaceFrame, write_surface};
