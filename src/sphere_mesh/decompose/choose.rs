//! Which bones a vertex may follow, chosen anew: those few of the spheres around its own that fit its motion best.
//!
//! A vertex between five or more regions cannot follow all spheres next to its own, and geometry alone does not know which.

use rayon::prelude::*;

use super::{
    filter::Filter,
    input::Frames,
    simplex::MOST,
    skin::{Skin, State},
    weights::{self, Problem},
};
use crate::mesh::Csr;

/// A choice replaces another where it lowers the vertex's error by more than this share.
const GAIN: f64 = 0.1;

/// Vertices whose problems, of up to [`MOST`] bones each, are in memory at once.
const AT_ONCE: usize = 1 << 16;

/// Spheres around each one, itself first: those next to it, then those next to these, at most [`MOST`].
pub(super) fn around(near: &Csr, rings: usize) -> Vec<Vec<u32>> {
    let one = |sphere: usize| {
        let mut found = vec![sphere as u32];
        let mut from = 0;
        for _ in 0..rings {
            let to = found.len();
            for k in from..to {
                for &s in near.row(found[k] as usize) {
                    if !found.contains(&s) {
                        found.push(s);
                    }
                }
            }
            from = to;
        }
        found.truncate(MOST);
        found
    };
    (0..near.len()).map(one).collect()
}

/// Chooses anew for every vertex from the spheres around its own.
pub(super) fn choose(
    frames: &Frames,
    state: &mut State,
    filter: &Filter,
    around: &[Vec<u32>],
    labels: &[u32],
) {
    let width = state.skin.width;
    let wide = widen(&state.skin, around, labels);
    let smooth = filter.apply(&wide);
    let square = wide.width * wide.width;
    let list = |v: usize, errors: &[f64]| {
        let problem = Problem {
            errors,
            width: wide.width,
            hold: weights::GAMMA * frames.weight[v],
        };
        let (bones, now) = (wide.bones(v), wide.weights(v));
        let smooth = &smooth[v * wide.width..][..bones.len()];
        let old: Vec<usize> = (0..state.skin.bones(v).len()).collect();
        let free = problem.solve(1.0, smooth, now);
        let mut best: Vec<usize> = (0..bones.len()).filter(|&k| free[k] > 0.0).collect();
        best.sort_by(|&a, &b| free[b].total_cmp(&free[a]));
        best.truncate(width);
        let fit = |set: &[usize]| {
            let sub = problem.only(set);
            let target: Vec<f64> = set.iter().map(|&k| smooth[k]).collect();
            let mut start: Vec<f64> = set.iter().map(|&k| free[k].max(now[k])).collect();
            weights::tidy(&mut start);
            let sub = Problem {
                errors: &sub,
                width: set.len(),
                ..problem
            };
            let w = sub.solve(1.0, &target, &start);
            (sub.error(&w), w)
        };
        let ((before, _), (after, w)) = (fit(&old), fit(&best));
        if after < (1.0 - GAIN) * before {
            best.iter().zip(w).map(|(&k, w)| (bones[k], w)).collect()
        } else {
            old.iter().map(|&k| (bones[k], now[k])).collect()
        }
    };
    let mut lists: Vec<Vec<(u32, f64)>> = Vec::with_capacity(frames.vertices);
    for first in (0..frames.vertices).step_by(AT_ONCE) {
        let vertices = first..frames.vertices.min(first + AT_ONCE);
        let errors = weights::errors(frames, state, &wide, vertices.clone());
        let rows = vertices.into_par_iter().zip(errors.par_chunks(square));
        lists.par_extend(rows.map(|(v, errors)| list(v, errors)));
    }
    state.skin = Skin::new(width, &lists);
}

/// The bones of each vertex, then the others around its sphere with weight 0.
fn widen(skin: &Skin, around: &[Vec<u32>], labels: &[u32]) -> Skin {
    let list = |v: usize| {
        let own = skin.bones(v);
        let mut list: Vec<(u32, f64)> = own
            .iter()
            .copied()
            .zip(skin.weights(v).iter().copied())
            .collect();
        let others = around[labels[v] as usize].iter();
        list.extend(others.filter(|b| !own.contains(b)).map(|&b| (b, 0.0)));
        list.truncate(MOST);
        list
    };
    let lists: Vec<_> = (0..skin.vertices()).map(list).collect();
    let width = lists.iter().map(Vec::len).max().unwrap_or(1);
    Skin::new(width, &lists)
}
