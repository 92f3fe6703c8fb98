//! Structs that shaders share.

pub mod field_grid;
