//! One implicit field a bone: samples, HRBF, remap, box (implicit skinning 2013, section 4.1).

mod atlas;
mod bone;
mod bounds;
mod ellipsoid;
mod fit;
mod grid;
mod hrbf;
mod sample;
mod surface;

use glam::{DVec3, Mat3, Mat4, Vec3};

pub use atlas::{AtlasLayout, TILE_BYTES, atlas_layout};
pub use fit::{Fitted, fit};
pub use grid::GridInput;
pub use hrbf::Hrbf;

pub use crate::layout::{MAX_FIELDS, field_grid::FADE};

/// Edge of a field's grid in texels.
pub const GRID: u32 = 32;

/// An oriented box in rest space; texel centres of the grid reach from face to face.
#[derive(Clone, Copy, Debug)]
pub struct FieldBox {
    /// Corner where box coordinates are (0,0,0).
    pub origin: Vec3,
    /// Unit axes as columns, x along the bone, right-handed.
    pub axes: Mat3,
    /// Edge lengths.
    pub size: Vec3,
}

impl FieldBox {
    /// Rest space → box coordinates, the box being [0, 1]³.
    pub fn from_rest(&self) -> Mat4 {
        self.to_rest().inverse()
    }

    /// Box coordinates → rest space.
    pub fn to_rest(&self) -> Mat4 {
        let scaled = Mat3::from_diagonal(self.size);
        Mat4::from_translation(self.origin) * Mat4::from_mat3(self.axes * scaled)
    }
}

/// The implicit field of one joint's part, or of an extra primitive: f = w(s) t_r(d), d the HRBF's distance, s the distance to the bone segments.
#[derive(Clone, Debug)]
pub struct Field {
    /// Row of the joint that carries it.
    pub joint: u16,
    /// Bone segments in rest space (joint → child, one a child; a leaf has one of its own, a primitive its axis).
    pub segments: Vec<[Vec3; 2]>,
    /// Radius r of the support: farthest vertex of the part to the segments, rest units.
    pub radius: f32,
    /// Where the grid lies.
    pub bounds: FieldBox,
    /// The distance function that the grid samples.
    pub hrbf: Hrbf,
}

impl Field {
    /// f in [0, 1] and ∇f in rest units at a point of rest space, in double precision and without the grid.
    pub fn evaluate(&self, rest: Vec3) -> (f64, DVec3) {
        self.at(rest.as_dvec3())
    }

    fn at(&self, x: DVec3) -> (f64, DVec3) {
        let (s, direction) = self.to_bone(x);
        let (weight, weight_slope) = fade(s, self.radius as f64);
        if weight == 0.0 {
            return (0.0, DVec3::ZERO);
        }
        let (d, gradient) = self.hrbf.evaluate(x);
        let (f, slope) = remap(d, self.radius as f64);
        (
            weight * f,
            weight * slope * gradient + weight_slope * f * direction,
        )
    }

    /// Distance to the nearest segment, and the unit direction away from it.
    fn to_bone(&self, x: DVec3) -> (f64, DVec3) {
        let mut nearest = (f64::INFINITY, DVec3::ZERO);
        for [start, end] in &self.segments {
            let (_, foot) = bone::project(x, start.as_dvec3(), end.as_dvec3());
            let s = x.distance(foot);
            if s < nearest.0 {
                nearest = (s, (x - foot).normalize_or_zero());
            }
        }
        nearest
    }
}

/// t_r(d) and its derivative: distance → [0, 1], 1 inside, 0.5 on the surface, 0 from d = r on.
fn remap(d: f64, r: f64) -> (f64, f64) {
    let x = (d / r).clamp(-1.0, 1.0);
    let q = x * x;
    let value = ((-0.1875 * q + 0.625) * q - 0.9375) * x + 0.5;
    (value, -0.9375 * (1.0 - q) * (1.0 - q) / r)
}

/// Fade w(s) and its derivative: 1 up to the first radius of [`FADE`], 0 from the second on.
fn fade(s: f64, r: f64) -> (f64, f64) {
    let [first, last] = FADE.map(|f| f as f64 * r);
    let x = ((last - s) / (last - first)).clamp(0.0, 1.0);
    (
        x * x * (3.0 - 2.0 * x),
        -6.0 * x * (1.0 - x) / (last - first),
    )
}

#[cfg(test)]
pub(crate) mod tests;
