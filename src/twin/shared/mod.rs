//! Twins of the included shader files (`shaders/shared`).

pub mod carry;
pub mod field;
pub mod list;
pub mod motion;
pub mod newton;
pub mod pace;
pub mod relaxation;
pub mod rotation;
pub mod set;
pub mod solid;
