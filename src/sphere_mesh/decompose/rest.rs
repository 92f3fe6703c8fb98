//! The rest pose with weights and motions fixed: a system of three unknowns a vertex.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::{input::Frames, skin::State};
use crate::sphere_mesh::lanes::{V4, X4};

/// How much a vertex holds to its old place, as a share of the system's trace: where all motions of opposite bones cancel,
/// nothing else fixes it.
const HOLD: f64 = 1e-9;

pub(super) fn improve(frames: &Frames, state: &mut State) {
    let fixed = &*state;
    let place = |v: usize| place(frames, fixed, v).unwrap_or(fixed.rest[v]);
    state.rest = (0..frames.vertices).into_par_iter().map(place).collect();
}

/// Minimises Σ μ |L p - (x - t)|², L the blended rotation and t the blended translation.
fn place(frames: &Frames, state: &State, v: usize) -> Option<DVec3> {
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for (chunk, motions) in frames.chunks.iter().zip(&state.motions) {
        let (mut columns, mut off) = ([V4::default(); 3], chunk.position(v));
        for (bone, weight) in state.skin.pairs(v) {
            let (motion, weight) = (&motions[bone as usize], X4::splat(weight));
            for (sum, column) in columns.iter_mut().zip(motion.columns()) {
                *sum = *sum + column.times(weight);
            }
            off = off - motion.translation().times(weight);
        }
        let area = chunk.area(v);
        for i in 0..3 {
            for j in 0..3 {
                matrix.col_mut(j)[i] += (columns[i].dot(columns[j]) * area).sum();
            }
            right[i] += (columns[i].dot(off) * area).sum();
        }
    }
    let hold = HOLD * (matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z);
    matrix += DMat3::from_diagonal(DVec3::splat(hold));
    let p = matrix.inverse() * (right + hold * state.rest[v]);
    p.is_finite().then_some(p)
}
