//! Weights with motions and rest pose fixed: vertex by vertex, mixed from the animation's and the geometry's (2016,
//! section 6.2).

use glam::DVec3;
use multiversion::multiversion;
use rayon::prelude::*;

use super::{
    Weighting,
    input::{Chunk, Frames},
    motion::Motion,
    simplex::{MOST, minimise},
    skin::{NOTHING, Skin, State},
};
use crate::sphere_mesh::lanes::V4;

/// γ: what a weight's change costs against a distance, in units of the diagonal's square.
pub(super) const GAMMA: f64 = 1e-4;
/// The same where weights are the animation's alone: decides what it leaves open.
const GAMMA_ANIMATION: f64 = 1e-7;
/// Vertices that share the motions of a chunk while these are at hand.
pub(super) const BLOCK: usize = 128;

/// D of each vertex: D_kl = Σ_f μ (M_k p − x)·(M_l p − x). As weights sum to 1, wᵀ D w is the error of the vertex.
///
/// In this form nothing cancels: a vertex's distance to itself moved by one bone is small.
pub(super) fn errors(frames: &Frames, state: &State, skin: &Skin) -> Vec<f64> {
    let square = skin.width * skin.width;
    let mut all = vec![0.0; frames.vertices * square];
    let blocks = all.par_chunks_mut(BLOCK * square).enumerate();
    blocks.for_each(|(block, rows)| {
        for (chunk, motions) in frames.chunks.iter().zip(&state.motions) {
            add(chunk, motions, &state.rest, skin, block * BLOCK, rows);
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

/// Adds a chunk's part to the lower halves of D, of vertices from `first` on.
#[multiversion(targets("x86_64+avx2"))]
fn add(
    chunk: &Chunk,
    motions: &[Motion],
    rest: &[DVec3],
    skin: &Skin,
    first: usize,
    rows: &mut [f64],
) {
    let mut offs = [V4::default(); MOST];
    for (row, matrix) in rows.chunks_exact_mut(skin.width * skin.width).enumerate() {
        let v = first + row;
        let (p, x, area) = (rest[v], chunk.position(v), chunk.area(v));
        let bones = skin.bones(v);
        for (off, bone) in offs.iter_mut().zip(bones) {
            *off = motions[*bone as usize].apply(p) - x;
        }
        for k in 0..bones.len() {
            let weighted = offs[k].times(area);
            for l in 0..=k {
                matrix[k * skin.width + l] += weighted.dot(offs[l]).sum();
            }
        }
    }
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

    /// Minimises α (wᵀ D w + γM |w − smooth|²) + (1 − α) γM |w − now|² into `w`.
    pub(super) fn solve(&self, alpha: f64, smooth: &[f64], now: &[f64], w: &mut [f64]) {
        w.copy_from_slice(now);
        if alpha <= 0.0 {
            return;
        }
        // Over α: wᵀ D w + r |w|² − 2 r bᵀ w, where r = γM / α and b = α smooth + (1 − α) now.
        let ridge = self.hold / alpha;
        let mut b = [0.0; MOST];
        for (b, (smooth, now)) in b.iter_mut().zip(smooth.iter().zip(now)) {
            *b = ridge * (alpha * smooth + (1.0 - alpha) * now);
        }
        minimise(self.errors, self.width, ridge, &b[..w.len()], w);
        tidy(w);
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

/// One step of the weights; `smooth` are the filtered ones.
pub(super) fn improve(frames: &Frames, state: &mut State, smooth: &[f64], kind: Weighting) {
    let all = errors(frames, state, &state.skin);
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
    let mut new = vec![0.0; skin.weights.len()];
    // The animation's weights, by how much the error falls with them, and the square of their change.
    let best = |(v, row): (usize, &mut [f64])| {
        let (problem, now) = (problem(v), skin.weights(v));
        let row = &mut row[..now.len()];
        problem.solve(1.0, smooth(v), now, row);
        let gain = (problem.error(now) - problem.error(row)).max(0.0);
        let change = row.iter().zip(now).map(|(a, b)| (a - b).powi(2)).sum();
        (gain, change)
    };
    let rows = new.par_chunks_mut(width).enumerate();
    let best: Vec<(f64, f64)> = rows.map(best).collect();
    if kind == Weighting::Mixed {
        let gain = best.iter().map(|b| b.0).fold(0.0, f64::max);
        let change = best.iter().map(|b| b.1).fold(0.0, f64::max);
        let rows = new.par_chunks_mut(width).zip(&best).enumerate();
        rows.for_each(|(v, (row, best))| {
            let now = skin.weights(v);
            let alpha = alpha(share(best.0, gain), share(best.1, change));
            problem(v).solve(alpha, smooth(v), now, &mut row[..now.len()]);
        });
    }
    state.skin.weights = new;
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
