//! Structs that shaders share.
