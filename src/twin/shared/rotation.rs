//! Twin of `shaders/shared/rotation.glsl`: quaternions as xyzw.

use glam::{Vec3, Vec4};

/// `v` turned by the unit quaternion `q`.
pub fn rotate(q: Vec4, v: Vec3) -> Vec3 {
    let axis = q.truncate();
    v + 2.0 * axis.cross(axis.cross(v) + q.w * v)
}

/// The rotation half-way between two.
pub fn half_way(a: Vec4, b: Vec4) -> Vec4 {
    (a + if a.dot(b) < 0.0 { -b } else { b }).normalize()
}

/// `v` turned by the least rotation that carries unit `a` to unit `b`; `v` itself where they are opposite.
pub fn rotate_between(a: Vec3, b: Vec3, v: Vec3) -> Vec3 {
    let c = a.dot(b);
    if c < -0.9999 {
        return v;
    }
    let k = a.cross(b);
    v * c + k.cross(v) + k * (k.dot(v) / (1.0 + c))
}
