//! The rest pose with weights and motions fixed: a system of three unknowns a vertex.

use glam::{DMat3, DVec3};
use multiversion::multiversion;
use rayon::prelude::*;

use super::{
    input::{Chunk, Frames},
    motion::Motion,
    skin::{Skin, State},
};
use crate::sphere_mesh::lanes::{S4, V4, X4};

/// How much a vertex holds to its old place, as a share of the system's trace: where all motions of opposite bones cancel,
/// nothing else fixes it.
const HOLD: f64 = 1e-9;

/// Vertices that share the motions of a chunk while these are at hand.
const BLOCK: usize = 128;

pub(super) fn improve(frames: &Frames, state: &mut State) {
    let mut rest = state.rest.clone();
    let blocks = rest.par_chunks_mut(BLOCK).enumerate();
    blocks.for_each(|(block, rest)| {
        let mut systems = vec![System::default(); rest.len()];
        for (chunk, motions) in frames.chunks.iter().zip(&state.motions) {
            add(chunk, motions, &state.skin, block * BLOCK, &mut systems);
        }
        for (p, system) in rest.iter_mut().zip(systems) {
            *p = system.solve(*p).unwrap_or(*p);
        }
    });
    state.rest = rest;
}

/// Σ μ LᵀL and Σ μ Lᵀ (x - t) of a vertex, L the blended rotation and t the blended translation: p minimises
/// Σ μ |L p - (x - t)|².
#[derive(Clone, Copy, Default)]
struct System {
    /// xx xy xz yy yz zz.
    matrix: S4,
    right: V4,
}

#[multiversion(targets("x86_64+avx2"))]
fn add(chunk: &Chunk, motions: &[Motion], skin: &Skin, first: usize, systems: &mut [System]) {
    for (k, system) in systems.iter_mut().enumerate() {
        let v = first + k;
        let (mut columns, mut off) = ([V4::default(); 3], chunk.position(v));
        for (bone, weight) in skin.pairs(v) {
            let (motion, weight) = (&motions[bone as usize], X4::splat(weight));
            for (sum, column) in columns.iter_mut().zip(motion.columns()) {
                *sum = *sum + column.times(weight);
            }
            off = off - motion.translation().times(weight);
        }
        let area = chunk.area(v);
        let [x, y, z] = columns;
        let [wx, wy, wz] = [x.times(area), y.times(area), z.times(area)];
        let products = [
            wx.dot(x),
            wx.dot(y),
            wx.dot(z),
            wy.dot(y),
            wy.dot(z),
            wz.dot(z),
        ];
        system.matrix = system.matrix + S4(products);
        system.right = system.right + V4([wx.dot(off), wy.dot(off), wz.dot(off)]);
    }
}

impl System {
    fn solve(&self, before: DVec3) -> Option<DVec3> {
        let [xx, xy, xz, yy, yz, zz] = self.matrix.0.map(X4::sum);
        let hold = HOLD * (xx + yy + zz);
        let columns = [xx + hold, xy, xz, xy, yy + hold, yz, xz, yz, zz + hold];
        let right = DVec3::from(self.right.0.map(X4::sum));
        let p = DMat3::from_cols_array(&columns).inverse() * (right + hold * before);
        p.is_finite().then_some(p)
    }
}
