//! Twin of `shaders/shared/relaxation.glsl`.

use glam::Vec3;

use super::{
    list,
    newton::{LEAP, shorten},
};

const WEIGHT: f32 = 0.9;
const SLIDE: f32 = 0.3;

/// What a relaxation step reads of the vertices.
#[derive(Clone, Copy, Debug)]
pub struct Relaxation<'a> {
    /// Offsets of the one-rings.
    pub offsets: &'a [u32],
    /// Neighbours.
    pub rings: &'a [u32],
    /// Their weights over the sum of a ring.
    pub weights: &'a [f32],
    /// Constant part of the iteration; w: pace.
    pub goals: &'a [[f32; 4]],
    /// Where the vertices are.
    pub starts: &'a [[f32; 4]],
    /// Where they were one iteration ago.
    pub befores: &'a [[f32; 4]],
}

impl Relaxation<'_> {
    /// Where a vertex is.
    pub fn start(&self, v: u32) -> Vec3 {
        at(self.starts, v)
    }

    /// Share of its steps that it takes.
    pub fn pace(&self, v: u32) -> f32 {
        self.goals[v as usize][3]
    }

    /// Its neighbours.
    pub fn ring(&self, v: u32) -> &[u32] {
        &self.rings[list::range(self.offsets, v)]
    }

    /// Where it slides, beside a normal that is 0 where there is no tangent plane.
    pub fn relaxed(&self, v: u32, normal: Vec3, freedom: f32, omega: f32, radius: f32) -> Vec3 {
        let x = self.start(v);
        let pace = self.pace(v);
        let freedom = if normal == Vec3::ZERO {
            0.0
        } else {
            freedom * pace
        };
        let tangent = |d: Vec3| d - normal * normal.dot(d);
        let mut goal = at(self.goals, v);
        for k in list::range(self.offsets, v) {
            goal += self.weights[k] * self.start(self.rings[k]);
        }
        let y = x + freedom * shorten(WEIGHT * tangent(goal - x), SLIDE * radius);
        let leap = tangent((omega - 1.0) * (y - at(self.befores, v)));
        y + freedom * shorten(leap, LEAP * radius)
    }
}

/// A vertex of a buffer.
pub fn at(buffer: &[[f32; 4]], v: u32) -> Vec3 {
    Vec3::from_slice(&buffer[v as usize])
}

/// The unit normal of a gradient; 0 where it is 0.
pub fn normal(slope: Vec3) -> Vec3 {
    slope / slope.length().max(1e-20)
}
