//! Weights with motions and rest pose fixed: vertex by vertex, mixed from the animation's and the geometry's (2016,
//! section 6.2).

use std::ops::Range;

use rayon::prelude::*;

use super::{
    Weighting,
    input::Frames,
    simplex::minimise,
    skin::{NOTHING, Skin, State},
};
use crate::sphere_mesh::lanes::V4;

/// γ: what a weight's change costs against a distance, in units of the diagonal's square.
pub(super) const GAMMA: f64 = 1e-4;
/// The same where weights are the animation's alone: decides what it leaves open.
const GAMMA_ANIMATION: f64 = 1e-7;
/// Vertices that share the motions of a chunk while these are at hand.
const BLOCK: usize = 128;

/// D of each of some vertices: D_kl = Σ_f μ (M_k p − x)·(M_l p − x). As weights sum to 1, wᵀ D w is the error of the vertex.
///
/// In this form nothing cancels: a vertex's distance to itself moved by one bone is small.
pub(super) fn errors(
    frames: &Frames,
    state: &State,
    skin: &Skin,
    vertices: Range<usize>,
) -> Vec<f64> {
    let square = skin.width * skin.width;
    let first = vertices.start;
    let mut all = vec![0.0; vertices.len() * square];
    let blocks = all.par_chunks_mut(BLOCK * square).enumerate();
    blocks.for_each(|(block, rows)| {
        let mut offs = vec![V4::default(); skin.width];
        for (chunk, motions) in frames.chunks.iter().zip(&state.motions) {
            for (k, row) in rows.chunks_exact_mut(square).enumerate() {
                let v = first + block * BLOCK + k;
                let (p, x, area) = (state.rest[v], chunk.position(v), chunk.area(v));
                let bones = skin.bones(v);
                for (off, bone) in offs.iter_mut().zip(bones) {
                    *off = motions[*bone as usize].apply(p) - x;
                }
                for k in 0..bones.len() {
                    let weighted = offs[k].times(area);
                    for l in 0..=k {
                        row[k * skin.width + l] += weighted.dot(offs[l]).sum();
                    }
                }
            }
        }
        for row in rows.chunks_exact_mut(square) {
            for k in 0..skin.width {
                for l in 0..k {
                    row[l * skin.width + k] = row[k * skin.width + l];
                }
            }
        }
    });
    all
}

/// One vertex's problem.
pub(super) struct Problem<'a> {
    /// D, `width` numbers a row.
    pub(super) errors: &'a [f64],
    pub(super) width: usize,
    /// γ Σ_f μ.
    pub(super) hold: f64,
}

impl Problem<'_> {
    /// wᵀ D w.
    pub(super) fn error(&self, w: &[f64]) -> f64 {
        let row = |k: usize| {
            let row = &self.errors[k * self.width..][..w.len()];
            w[k] * row.iter().zip(w).map(|(d, w)| d * w).sum::<f64>()
        };
        (0..w.len()).map(row).sum::<f64>().max(0.0)
    }

    /// D of some of the slots.
    pub(super) fn only(&self, slots: &[usize]) -> Vec<f64> {
        let row = |&k: &usize| slots.iter().map(move |&l| self.errors[k * self.width + l]);
        slots.iter().flat_map(row).collect()
    }

    /// Minimises α (wᵀ D w + γM |w − smooth|²) + (1 − α) γM |w − now|²; returns the weights.
    pub(super) fn solve(&self, alpha: f64, smooth: &[f64], now: &[f64]) -> Vec<f64> {
        let n = now.len();
        let mut a = vec![0.0; n * n];
        for (k, row) in a.chunks_exact_mut(n).enumerate() {
            for (l, cell) in row.iter_mut().enumerate() {
                *cell = alpha * self.errors[k * self.width + l];
            }
            row[k] += self.hold;
        }
        let target = |(s, w): (&f64, &f64)| self.hold * (alpha * s + (1.0 - alpha) * w);
        let b: Vec<f64> = smooth.iter().zip(now).map(target).collect();
        let mut w = now.to_vec();
        minimise(&a, &b, &mut w);
        tidy(&mut w);
        w
    }
}

/// Weights that do not count are 0, the rest sum to 1.
pub(super) fn tidy(w: &mut [f64]) {
    w.iter_mut()
        .filter(|w| **w <= NOTHING)
        .for_each(|w| *w = 0.0);
    let sum: f64 = w.iter().sum();
    w.iter_mut().for_each(|w| *w /= sum);
}

/// The weights that fit the animation best, and what α needs to know of them.
struct Best {
    weights: Vec<f64>,
    /// How much the error falls.
    gain: f64,
    /// Square of the weights' change.
    change: f64,
}

/// One step of the weights; `smooth` are the filtered ones.
pub(super) fn improve(frames: &Frames, state: &mut State, smooth: &[f64], kind: Weighting) {
    let all = errors(frames, state, &state.skin, 0..frames.vertices);
    let skin = &state.skin;
    let width = skin.width;
    let gamma = match kind {
        Weighting::Mixed => GAMMA,
        Weighting::Animation => GAMMA_ANIMATION,
    };
    let problem = |v: usize| Problem {
        errors: &all[v * width * width..][..width * width],
        width,
        hold: gamma * frames.weight[v],
    };
    let smooth = |v: usize| &smooth[v * width..][..skin.bones(v).len()];
    let best = |v: usize| {
        let (problem, now) = (problem(v), skin.weights(v));
        let weights = problem.solve(1.0, smooth(v), now);
        let before = problem.error(now);
        let gain = (before - problem.error(&weights)).max(0.0);
        let change = weights.iter().zip(now).map(|(a, b)| (a - b).powi(2)).sum();
        Best {
            weights,
            gain,
            change,
        }
    };
    let mut best: Vec<Best> = (0..skin.vertices()).into_par_iter().map(best).collect();
    if kind == Weighting::Mixed {
        let gain = best.iter().map(|b| b.gain).fold(0.0, f64::max);
        let change = best.iter().map(|b| b.change).fold(0.0, f64::max);
        best.par_iter_mut().enumerate().for_each(|(v, best)| {
            let alpha = alpha(share(best.gain, gain), share(best.change, change));
            best.weights = problem(v).solve(alpha, smooth(v), skin.weights(v));
        });
    }
    let rows = state.skin.weights.chunks_exact_mut(width);
    for (row, best) in rows.zip(best) {
        row[..best.weights.len()].copy_from_slice(&best.weights);
    }
}

/// 0 of 0 where nothing is.
fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

/// How much the animation decides: much where the error falls by a lot for a small change. Nothing changed: not at all.
fn alpha(gain: f64, change: f64) -> f64 {
    if gain + change > 0.0 {
        0.8 * gain / (gain + change)
    } else {
        0.0
    }
}
