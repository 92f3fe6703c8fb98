//! Files in and out: glTF characters in; GLB, PLY and OBJ out. The only user of the `gltf` crate.

mod import;
mod model;

pub use import::load;
pub use model::{Channel, Clip, Influence, Interpolation, Joint, Model, Node, Primitive, Property};
