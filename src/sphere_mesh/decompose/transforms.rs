//! Motions of the bones with weights and rest pose fixed: bone by bone, frame by frame.

use glam::{DMat3, DQuat, DVec3};
use multiversion::multiversion;
use rayon::prelude::*;

use super::{
    input::{Chunk, Frames},
    motion::{Fit, Moments, Motion},
    skin::State,
};
use crate::{
    mesh::Csr,
    sphere_mesh::lanes::{V4, X4},
};

/// A bone whose weights' squares sum to less has too few vertices for a motion of its own (Le & Deng 2012).
const MINOR: f64 = 3.0;

/// What moves which vertices, and how bones hang together.
pub(super) struct Bones<'a> {
    /// Vertices and weights of each bone.
    pub(super) vertices: Vec<Vec<(u32, f64)>>,
    /// Bones adjacent in the sphere-mesh.
    pub(super) near: &'a Csr,
    /// Where each bone meets others: the other, the place at rest and how much it counts.
    pub(super) joints: &'a [Vec<(usize, DVec3, f64)>],
    /// Centres at rest, in units of the diagonal about the origin.
    pub(super) centres: &'a [DVec3],
}

impl Bones<'_> {
    fn minor(&self) -> Vec<bool> {
        let square = |list: &Vec<(u32, f64)>| list.iter().map(|p| p.1 * p.1).sum::<f64>();
        self.vertices.iter().map(|l| square(l) < MINOR).collect()
    }
}

/// Fits every bone by itself to the vertices that it moves most: where the iterations begin.
pub(super) fn start(frames: &Frames, state: &State, bones: &Bones) -> Vec<Vec<Motion>> {
    let rest = &state.rest;
    let one = |chunk: &Chunk| {
        let mut motions = vec![Motion::identity(); bones.centres.len()];
        for (motion, list) in motions.iter_mut().zip(&bones.vertices) {
            let mut fit = Fit::default();
            for &(v, weight) in list {
                let mass = chunk.area(v as usize) * X4::splat(weight * weight);
                let weighted = chunk.position(v as usize).times(mass);
                fit.add(mass, rest[v as usize], weighted);
            }
            solve(&fit, motion, chunk.frames);
        }
        follow(&mut motions, bones, chunk.frames);
        motions
    };
    frames.chunks.par_iter().map(one).collect()
}

/// One round over all bones of every frame: each is fitted to what the others leave of its vertices. Returns the sum of
/// squared distances afterwards.
pub(super) fn improve(frames: &Frames, state: &mut State, bones: &Bones) -> f64 {
    let mut all = std::mem::take(&mut state.motions);
    let fixed = &*state;
    let pairs = frames.chunks.par_iter().zip(&mut all);
    let sums = pairs.map(|(chunk, motions)| sweep(chunk, fixed, motions, bones));
    let sum = sums.collect::<Vec<f64>>().iter().sum();
    state.motions = all;
    sum
}

fn sweep(chunk: &Chunk, state: &State, motions: &mut [Motion], bones: &Bones) -> f64 {
    let mut off = distances(chunk, state, motions);
    for (bone, list) in bones.vertices.iter().enumerate() {
        let before = motions[bone];
        let mut fit = left(chunk, &state.rest, list, &off).wanted(&before);
        for &(other, place, count) in &bones.joints[bone] {
            let count = X4::splat(count);
            fit.add(count, place, motions[other].apply(place).times(count));
        }
        solve(&fit, &mut motions[bone], chunk.frames);
        shift(&mut off, &state.rest, list, &motions[bone].against(&before));
    }
    follow(motions, bones, chunk.frames);
    squares(&off).0[..chunk.frames].iter().sum()
}

#[multiversion(targets("x86_64+avx2"))]
fn squares(off: &[V4]) -> X4 {
    let mut sum = X4::default();
    for off in off {
        sum += off.dot(*off);
    }
    sum
}

/// How far every vertex is from where it should be.
#[multiversion(targets("x86_64+avx2"))]
fn distances(chunk: &Chunk, state: &State, motions: &[Motion]) -> Vec<V4> {
    let mut off = Vec::with_capacity(state.rest.len());
    for v in 0..state.rest.len() {
        off.push(state.skinned(motions, v) - chunk.position(v));
    }
    off
}

/// What a bone's vertices say of its motion.
#[multiversion(targets("x86_64+avx2"))]
fn left(chunk: &Chunk, rest: &[DVec3], list: &[(u32, f64)], off: &[V4]) -> Moments {
    let mut moments = Moments::default();
    for &(v, weight) in list {
        let v = v as usize;
        moments.add(chunk.area(v) * X4::splat(weight), weight, rest[v], off[v]);
    }
    moments
}

/// Moves a bone's vertices by what its motion has changed.
#[multiversion(targets("x86_64+avx2"))]
fn shift(off: &mut [V4], rest: &[DVec3], list: &[(u32, f64)], change: &Motion) {
    for &(v, weight) in list {
        let v = v as usize;
        off[v] = off[v] + change.apply(rest[v]).times(X4::splat(weight));
    }
}

fn solve(fit: &Fit, motion: &mut Motion, frames: usize) {
    for lane in 0..frames {
        let before = motion.lane(lane).0;
        if let Some((rotation, translation)) = fit.solve(lane, before) {
            motion.set(lane, rotation, translation);
        }
    }
}

/// Minor bones move as the bones next to them: mean rotation, and mean place of the bone's centre. Where these are minor
/// too, a bone keeps its own motion; one without vertices moves as the nearest that has some.
fn follow(motions: &mut [Motion], bones: &Bones, frames: usize) {
    let minor = bones.minor();
    let fitted = motions.to_vec();
    for bone in (0..motions.len()).filter(|&b| minor[b]) {
        let near = bones.near.row(bone).iter().map(|&b| b as usize);
        let mut guides: Vec<usize> = near.filter(|&b| !minor[b]).collect();
        if guides.is_empty() && bones.vertices[bone].is_empty() {
            let far = |&b: &usize| bones.centres[b].distance_squared(bones.centres[bone]);
            let others = (0..motions.len()).filter(|&b| !bones.vertices[b].is_empty());
            guides.extend(others.min_by(|a, b| far(a).total_cmp(&far(b))));
        }
        if guides.is_empty() {
            continue;
        }
        for lane in 0..frames {
            let parts = guides.iter().map(|&b| fitted[b].lane(lane));
            let (rotation, translation) = mean(parts, bones.centres[bone]);
            motions[bone].set(lane, rotation, translation);
        }
    }
}

/// Mean of rigid motions about a point.
fn mean(motions: impl Iterator<Item = (DMat3, DVec3)>, centre: DVec3) -> (DMat3, DVec3) {
    let (mut turn, mut place, mut count) = (DQuat::from_array([0.0; 4]), DVec3::ZERO, 0.0);
    for (rotation, translation) in motions {
        let q = DQuat::from_mat3(&rotation);
        turn = turn + if turn.dot(q) < 0.0 { -q } else { q };
        place += rotation * centre + translation;
        count += 1.0;
    }
    let rotation = DMat3::from_quat(turn.normalize());
    (rotation, place / count - rotation * centre)
}
