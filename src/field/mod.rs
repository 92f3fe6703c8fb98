//! One implicit field a bone: samples, HRBF, remap, box (implicit skinning 2013, section 4.1).

use glam::{DVec3, Mat3, Mat4, Vec3};

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

/// Hermite radial basis function d(x) = Σ λ t³ + 3 t (β·δ), in coordinates `(x - origin) / scale` (Eq. 1, φ = t³).
#[derive(Clone, Debug, Default)]
pub struct Hrbf {
    /// Centre of the part in rest space.
    pub origin: DVec3,
    /// Size of the part.
    pub scale: f64,
    /// Scaled centres.
    pub centers: Vec<DVec3>,
    /// λ a centre.
    pub lambda: Vec<f64>,
    /// β a centre.
    pub beta: Vec<DVec3>,
}

/// The implicit field of one joint's part.
#[derive(Clone, Debug)]
pub struct Field {
    /// Row of the joint that carries it.
    pub joint: u16,
    /// Bone segments in rest space (joint → child, one a child; a leaf has one of its own).
    pub segments: Vec<[Vec3; 2]>,
    /// Radius r of the support: farthest vertex of the part to the segments, rest units.
    pub radius: f32,
    /// Where the grid lies.
    pub bounds: FieldBox,
    /// The distance function that the grid samples.
    pub hrbf: Hrbf,
}
