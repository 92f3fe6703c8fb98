//! Files in and out: glTF characters in; GLB, PLY and OBJ out. The only user of the `gltf` crate.

mod model;

pub use model::{Channel, Clip, Influence, Interpolation, Joint, Model, Node, Primitive, Property};
