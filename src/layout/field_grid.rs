//! Structs of `shaders/field_grid.comp`: same names, same fields, same order, std430.

use bytemuck::{Pod, Zeroable};

/// Distances from the bone, in radii r, from which the field fades and where it has become 0.
///
/// Every vertex of the part is within r, so the fade leaves the part itself alone. It makes the support finite where the HRBF of
/// an open or thin part stays inside for ever.
pub const FADE: [f32; 2] = [1.35, 2.0];
/// A value below this is 0, and so is its gradient.
pub const SNAP: f32 = 1e-5;

/// One field as its grid is sampled: everything in the scaled coordinates of its HRBF.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GridField {
    /// Box coordinate (0,0,0).
    pub origin: [f32; 3],
    /// Radius r.
    pub radius: f32,
    /// Box edge along x.
    pub edge_x: [f32; 3],
    /// Row of the first centre.
    pub first_center: u32,
    /// Box edge along y.
    pub edge_y: [f32; 3],
    /// Number of centres.
    pub centers: u32,
    /// Box edge along z.
    pub edge_z: [f32; 3],
    /// Row of the first segment.
    pub first_segment: u32,
    /// Tile in the atlas.
    pub tile: [u32; 3],
    /// Number of segments.
    pub segments: u32,
}

/// A centre of an HRBF.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GridCenter {
    /// Place.
    pub position: [f32; 3],
    /// λ.
    pub lambda: f32,
    /// β.
    pub beta: [f32; 3],
    /// Unused.
    pub pad: u32,
}

/// A bone segment.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GridSegment {
    /// Its start.
    pub start: [f32; 3],
    /// Unused.
    pub pad0: u32,
    /// Its end.
    pub end: [f32; 3],
    /// Unused.
    pub pad1: u32,
}
