//! Twins of the included shader files (`shaders/shared`).

pub mod field;
pub mod list;
pub mod rotation;
pub mod set;
