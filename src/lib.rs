//! Real-time character skin with contact, volume and elasticity, on Vulkan compute.
//!
//! Data flows one way: [`asset`] (files) → [`rig`] (everything prepared once, immutable) → [`deformer`] (per frame,
//! on a [`gpu`] or on the CPU) → positions, normals and contact states.
//!
//! Spaces: **rest** is the space of the input file's vertices, **bone** the box of one field, **model** the posed result.
//!
//! ```
//! use std::{path::Path, sync::Arc};
//!
//! use dermis::{
//!     Error, Result, asset,
//!     deformer::{Deformer, Device, Settings},
//!     gpu::{Gpu, GpuOptions},
//!     rig::{Options, Pose, Rig},
//! };
//!
//! # fn main() -> Result<()> {
//! let model = asset::load(Path::new("assets/arm.glb"))?;
//! let rig = Arc::new(Rig::prepare(&model, &Options::default(), &|_progress| {})?);
//! let device = match Gpu::new(&GpuOptions::default()) {
//!     Ok(gpu) => Device::Gpu(gpu),
//!     Err(Error::NoDevice { .. }) => Device::Cpu,
//!     Err(error) => return Err(error),
//! };
//! let mut deformer = Deformer::new(&device, Arc::clone(&rig), &Settings::default())?;
//! for frame in 0..3 {
//!     let pose = Pose::from_clip(&model, &rig.skeleton, 0, frame as f32 / 30.0)?;
//!     deformer.advance(&pose)?; // recorded and submitted, not waited for
//!     let skin = deformer.read()?; // waits
//!     assert_eq!(skin.positions.len(), model.positions.len());
//! }
//! # Ok(())
//! # }
//! ```

pub mod asset;
#[cfg(feature = "capi")]
pub mod capi;
pub mod compose;
pub mod deformer;
pub mod error;
pub mod field;
pub mod flesh;
pub mod frame;
pub mod gpu;
pub mod layout;
pub mod mesh;
pub mod particles;
pub mod pass;
pub mod render;
pub mod report;
pub mod rig;
pub mod sphere_mesh;
pub mod twin;

pub use error::{Error, Result};

/// Compiles and runs the examples of README.md as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
