//! Twin of `shaders/shared/carry.glsl`.

use glam::{Vec3, Vec4};

/// A point (w = 1) or a direction (w = 0) carried by three rows of a matrix.
pub fn carry(rows: &[[f32; 4]; 3], x: Vec4) -> Vec3 {
    Vec3::from_array(rows.map(|r| Vec4::from_array(r).dot(x)))
}
