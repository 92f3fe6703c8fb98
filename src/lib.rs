//! Real-time character skin with contact, volume and elasticity, on Vulkan compute.
//!
//! Data flows one way: [`asset`] (files) → [`rig`] (everything prepared once, immutable) → [`deformer`] (per frame,
//! on a [`gpu`] or on the CPU) → positions, normals and contact states.
//!
//! Spaces: **rest** is the space of the input file's vertices, **bone** the box of one field, **model** the posed result.

pub mod asset;
pub mod compose;
pub mod deformer;
pub mod error;
pub mod field;
pub mod frame;
pub mod gpu;
pub mod layout;
pub mod mesh;
pub mod pass;
pub mod render;
pub mod report;
pub mod rig;
pub mod twin;

pub use error::{Error, Result};
