//! Files in and out: glTF characters and OBJ, PLY and OFF meshes in; GLB, PLY and OBJ out; NumPy arrays either way. [`Arrays`] make a character without a file. The only user of the `gltf` crate.

mod arrays;
mod export;
mod import;
mod model;
mod npy;
mod sequence;
mod surface;

pub use arrays::{ArrayJoint, Arrays};
pub use export::{
    MorphAnimation, MorphFrame, PlyFrame, SphereAnimation, SpherePath, SurfaceFormat, SurfaceFrame,
    SurfaceMesh, write_atomic, write_glb_morph, write_glb_skinned, write_glb_spheres, write_obj,
    write_ply, write_surface,
};
pub use import::{ROW_LIMIT, load, load_morph, load_still};
pub use model::{
    Channel, Clip, Influence, Interpolation, Joint, Model, Node, Primitive, Property, Spine,
};
pub use npy::{load_rows, write_rows};
pub use sequence::{Room, Sequence, load_sequence};
pub use surface::{Surface, is_surface, load_surface};
