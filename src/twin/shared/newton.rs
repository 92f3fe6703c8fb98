//! Twin of `shaders/shared/newton.glsl`.

use glam::Vec3;

/// Longest step over the radius.
pub const LEAP: f32 = 0.1;
/// |∇f| r below which there is no direction to go.
pub const FLAT: f32 = 1e-3;
/// Growth of |f − iso| that rounding explains.
pub const PIT: f32 = 1e-5;
const VALLEY: f32 = 10.0;
const GENTLE: f32 = 0.05;

/// `d`, not longer than `limit`.
pub fn shorten(d: Vec3, limit: f32) -> Vec3 {
    let l = d.length();
    if l > limit { d * (limit / l) } else { d }
}

/// A step from a sample (f, ∇f) towards the iso-value, not longer than `limit` radii.
pub fn newton(iso: f32, (f, g): (f32, Vec3), sigma: f32, radius: f32, limit: f32) -> Vec3 {
    let inverse = 1.0 / (radius * radius);
    let steep = g.length_squared() + VALLEY * (f - iso).max(0.0) * inverse;
    let factor = sigma * (iso - f) / steep.max(GENTLE * GENTLE * inverse);
    shorten(factor * g, limit * radius)
}
