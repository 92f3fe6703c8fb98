//! Which bones move a vertex, and how much.

use glam::DVec3;

use super::{input::Frames, motion::Motion};
use crate::sphere_mesh::lanes::V4;

/// No bone: fills a vertex's last slots.
pub(super) const NONE: u32 = u32::MAX;
/// Weights up to this do not count.
pub(super) const NOTHING: f64 = 1e-9;

/// Bones and weights of all vertices, `width` slots each, the used ones first.
#[derive(Clone, Debug)]
pub(super) struct Skin {
    pub(super) width: usize,
    pub(super) bones: Vec<u32>,
    /// Not negative, sum 1 a vertex.
    pub(super) weights: Vec<f64>,
}

impl Skin {
    /// From lists of bones and weights, each no longer than `width`.
    pub(super) fn new(width: usize, lists: &[Vec<(u32, f64)>]) -> Self {
        let mut skin = Self {
            width,
            bones: vec![NONE; lists.len() * width],
            weights: vec![0.0; lists.len() * width],
        };
        for (v, list) in lists.iter().enumerate() {
            for (k, &(bone, weight)) in list.iter().take(width).enumerate() {
                skin.bones[v * width + k] = bone;
                skin.weights[v * width + k] = weight;
            }
        }
        skin
    }

    pub(super) fn vertices(&self) -> usize {
        self.bones.len() / self.width
    }

    /// Bones that a vertex may follow.
    pub(super) fn bones(&self, vertex: usize) -> &[u32] {
        let slots = &self.bones[vertex * self.width..][..self.width];
        let used = slots.iter().position(|&b| b == NONE);
        &slots[..used.unwrap_or(self.width)]
    }

    /// Their weights.
    pub(super) fn weights(&self, vertex: usize) -> &[f64] {
        &self.weights[vertex * self.width..][..self.bones(vertex).len()]
    }

    /// Bones and weights that count.
    pub(super) fn pairs(&self, vertex: usize) -> impl Iterator<Item = (u32, f64)> {
        let pairs = self.bones(vertex).iter().zip(self.weights(vertex));
        pairs.map(|(b, w)| (*b, *w)).filter(|p| p.1 > NOTHING)
    }

    /// Vertices of each bone and their weights.
    pub(super) fn by_bone(&self, bones: usize) -> Vec<Vec<(u32, f64)>> {
        let mut lists = vec![Vec::new(); bones];
        for v in 0..self.vertices() {
            for (bone, weight) in self.pairs(v) {
                lists[bone as usize].push((v as u32, weight));
            }
        }
        lists
    }
}

/// All that the decomposition seeks.
pub(super) struct State {
    pub(super) skin: Skin,
    /// Rest pose in units of the diagonal about the origin.
    pub(super) rest: Vec<DVec3>,
    /// Motion of each bone in each chunk of frames.
    pub(super) motions: Vec<Vec<Motion>>,
}

impl State {
    /// A vertex as it is skinned.
    #[inline(always)]
    pub(super) fn skinned(&self, motions: &[Motion], vertex: usize) -> V4 {
        let mut sum = V4::default();
        for (bone, weight) in self.skin.pairs(vertex) {
            let at = motions[bone as usize].apply(self.rest[vertex]);
            sum = sum + at.times(crate::sphere_mesh::lanes::X4::splat(weight));
        }
        sum
    }

    /// Sum over the vertices of squared distances, and the same by area over all area, for every frame; units of the
    /// sphere-mesh's diagonal.
    pub(super) fn errors(&self, frames: &Frames) -> Vec<(f64, f64)> {
        use rayon::prelude::*;
        let pairs = frames.chunks.par_iter().zip(&self.motions);
        let all = pairs.flat_map_iter(|(chunk, motions)| {
            let mut sums = [(0.0, 0.0, 0.0); crate::sphere_mesh::lanes::LANES];
            for v in 0..frames.vertices {
                let d = self.skinned(motions, v) - chunk.position(v);
                let (square, area) = (d.dot(d), chunk.area(v));
                for (lane, sum) in sums.iter_mut().enumerate() {
                    sum.0 += square.0[lane];
                    sum.1 += area.0[lane] * square.0[lane];
                    sum.2 += area.0[lane];
                }
            }
            let sums = sums.into_iter().take(chunk.frames);
            sums.map(|(plain, weighted, area)| (plain, weighted / area))
        });
        all.collect()
    }
}
