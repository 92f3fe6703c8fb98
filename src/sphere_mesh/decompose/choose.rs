//! Which bones a vertex may follow, chosen anew: those few of the spheres around its own that fit its motion best.
//!
//! A vertex between five or more regions cannot follow all spheres next to its own, and geometry alone does not know which.

use multiversion::multiversion;
use rayon::prelude::*;

use super::{
    filter::Filter,
    input::{Chunk, Frames},
    motion::Motion,
    simplex::MOST,
    skin::{Skin, State},
    weights::{self, BLOCK, Problem},
};
use crate::mesh::Csr;

/// A choice replaces another where it lowers the vertex's error by more than this share.
const GAIN: f64 = 0.05;
/// Spheres that a vertex does not follow and that are looked at closely.
const OTHERS: usize = 4;
/// Least filtered weight of a sphere that a vertex may begin to follow: farther away it would start an island.
const NEAR: f64 = 0.01;
/// Most groups of frames by which these are found.
const GROUPS: usize = 8;

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
    let wide = promising(frames, state, around, labels);
    let smooth = filter.apply(&wide, around.len());
    let errors = weights::errors(frames, state, &wide);
    let list = |(v, errors): (usize, &[f64])| {
        let problem = Problem {
            errors,
            width: wide.width,
            hold: weights::GAMMA * frames.weight[v],
        };
        let (bones, now) = (wide.bones(v), wide.weights(v));
        let old: Vec<usize> = (0..state.skin.bones(v).len()).collect();
        let kept = || old.iter().map(|&k| (bones[k], now[k])).collect();
        if old.len() == bones.len() {
            return kept();
        }
        let smooth = &smooth[v * wide.width..][..bones.len()];
        let mut free = now.to_vec();
        problem.solve(1.0, smooth, now, &mut free);
        let near = |k: usize| k < old.len() || smooth[k] > NEAR;
        let mut best: Vec<usize> = (0..bones.len())
            .filter(|&k| free[k] > 0.0 && near(k))
            .collect();
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
            let mut w = start.clone();
            sub.solve(1.0, &target, &start, &mut w);
            (sub.error(&w), w)
        };
        let ((before, _), (after, w)) = (fit(&old), fit(&best));
        if after < (1.0 - GAIN) * before {
            best.iter().zip(w).map(|(&k, w)| (bones[k], w)).collect()
        } else {
            kept()
        }
    };
    let rows = errors.par_chunks(wide.width * wide.width).enumerate();
    let lists: Vec<Vec<(u32, f64)>> = rows.map(list).collect();
    state.skin = Skin::new(width, &lists);
}

/// The bones of each vertex, then those others around its sphere that promise most, with weight 0.
fn promising(frames: &Frames, state: &State, around: &[Vec<u32>], labels: &[u32]) -> Skin {
    let skin = &state.skin;
    let new = |v: usize| {
        let own = skin.bones(v);
        let others = around[labels[v] as usize].iter();
        let others = others.filter(|b| !own.contains(b));
        Rating {
            error: 0.0,
            others: others.map(|&b| (b, 0.0, 0.0)).collect(),
        }
    };
    let mut ratings: Vec<Rating> = (0..frames.vertices).into_par_iter().map(new).collect();
    let step = frames.chunks.len().div_ceil(GROUPS);
    let blocks = ratings.par_chunks_mut(BLOCK).enumerate();
    blocks.for_each(|(block, ratings)| {
        let groups = frames.chunks.iter().zip(&state.motions).step_by(step);
        groups.for_each(|(chunk, motions)| rate(chunk, motions, state, block * BLOCK, ratings));
    });
    let list = |(v, rating): (usize, &Rating)| {
        let own = skin.bones(v).iter().zip(skin.weights(v));
        let own = own.map(|(b, w)| (*b, *w));
        let others = rating.best().into_iter().map(|bone| (bone, 0.0));
        own.chain(others).take(MOST).collect()
    };
    let lists: Vec<Vec<(u32, f64)>> = ratings.par_iter().enumerate().map(list).collect();
    let width = lists.iter().map(Vec::len).max().unwrap_or(1);
    Skin::new(width, &lists)
}

/// What a vertex's distances say of the bones that it does not follow.
struct Rating {
    /// Σ μ |y|², y how far the vertex is off.
    error: f64,
    /// Bone, Σ μ y·z and Σ μ |z|², z how far off the bone alone would have it.
    others: Vec<(u32, f64, f64)>,
}

impl Rating {
    /// Bones with the greatest gains. On the way from y to z the error is least at t = y·(y − z) / |y − z|², where it is less
    /// by (y·(y − z))² / |y − z|².
    fn best(&self) -> Vec<u32> {
        let gain = |&(bone, product, square): &(u32, f64, f64)| {
            let towards = self.error - product;
            let way = self.error - 2.0 * product + square;
            (towards > 0.0 && way > 0.0).then_some((towards * towards / way, bone))
        };
        let mut gains: Vec<(f64, u32)> = self.others.iter().filter_map(gain).collect();
        gains.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        gains.truncate(OTHERS);
        gains.iter().map(|gain| gain.1).collect()
    }
}

/// Adds a group of frames to the ratings of vertices from `first` on.
#[multiversion(targets("x86_64+avx2"))]
fn rate(chunk: &Chunk, motions: &[Motion], state: &State, first: usize, ratings: &mut [Rating]) {
    for (row, rating) in ratings.iter_mut().enumerate() {
        let v = first + row;
        let (p, x, area) = (state.rest[v], chunk.position(v), chunk.area(v));
        let off = state.skinned(motions, v) - x;
        let weighted = off.times(area);
        rating.error += weighted.dot(off).sum();
        for (bone, product, square) in &mut rating.others {
            let alone = motions[*bone as usize].apply(p) - x;
            *product += weighted.dot(alone).sum();
            *square += alone.times(area).dot(alone).sum();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bones_that_promise_most_are_those_that_cancel_what_is_left() {
        // y = (1, 0): z a little nearer, z against it, z beside it, z farther out.
        let with = |bone: u32, [x, y]: [f64; 2]| (bone, x, x * x + y * y);
        let rating = Rating {
            error: 1.0,
            others: vec![
                with(5, [0.9, 0.0]),
                with(7, [-1.0, 0.5]),
                with(3, [0.0, 2.0]),
                with(9, [2.0, 1.0]),
                with(4, [0.0, 1.0]),
            ],
        };
        assert_eq!(rating.best(), [5, 7, 4, 3]);
    }
}
