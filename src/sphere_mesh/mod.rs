//! Animated sphere-meshes (Thiery, Guy, Boubekeur & Eisemann 2016): a captured sequence as a few spheres with constant
//! radii, joined by edges and triangles along which they are interpolated.
//!
//! [`build`] collapses edges until nothing is left to collapse and keeps every step in a [`Hierarchy`], whose
//! [`Level`]s have any number of spheres. [`Collider`] says where moving spheres meet one of them.

mod collapse;
mod collide;
mod curvature;
mod decompose;
mod distance;
mod export;
mod extent;
mod extract;
mod facets;
mod file;
mod hierarchy;
mod input;
mod inversion;
mod lanes;
mod level;
mod options;
mod outer;
mod quadric;
mod region;
mod rows;
mod shape;
mod sight;
mod solve;
#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;
mod topology;
mod tree;

pub use collide::{Collider, Hit, Moving, Sweep};
pub use decompose::{Decomposing, Decomposition, Weighting, decompose};
pub use distance::{Distances, Sheets, distances, surface_facets};
pub use export::write_ma;
pub use extract::{Skin, extract};
pub use hierarchy::{Hierarchy, Merge};
pub use level::Level;
pub use options::Options;
pub use shape::{Ball, Shape};

use crate::{Error, Result, asset::Sequence, report::Progress};

/// Bytes that a build needs for one vertex in so many frames, at most, the sequence included.
pub fn bytes_a_vertex(frames: usize) -> u64 {
    // The mesh, neighbours, triangles and edges of a region.
    const REGION: u64 = 2048;
    // The sequence and extents; positions, importance, quadrics with their temporal terms, and centres of what collapses make.
    const FRAME: u64 = 12 + 64;
    const PADDED: u64 = 12 + 4 + 128 + 12;
    let padded = frames.div_ceil(lanes::LANES).saturating_mul(lanes::LANES) as u64;
    REGION
        .saturating_add(FRAME.saturating_mul(frames as u64))
        .saturating_add(PADDED.saturating_mul(padded))
}

/// Builds the whole hierarchy of a sequence. Rows that coincide in every frame are one vertex; any number of components,
/// boundaries and non-manifold edges are welcome; faces are counter-clockwise seen from outside, or no sphere has a radius.
///
/// # Errors
/// [`Error::Asset`] naming the frame or triangle where the sequence cannot be used; [`Error::Argument`] for options out of
/// range.
pub fn build(
    sequence: &Sequence,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Hierarchy> {
    if !(0.0..=1.0).contains(&options.curvature) {
        return Err(Error::argument("curvature", "a power is from 0 to 1"));
    }
    if !(options.temporal >= 0.0 && options.temporal <= 1e9) {
        return Err(Error::argument("temporal", "a weight is from 0 to 1e9"));
    }
    Ok(collapse::build(
        input::Input::new(sequence)?,
        options,
        progress,
    ))
}
