//! Twin of the pass that takes a projection's samples and does nothing else.

use super::Image;
use crate::pass::ceiling_replay::SAMPLES;

/// The sum of the samples of each invocation: its places (texture coordinates), `repeats` times.
pub fn ceiling_replay(atlas: &Image, places: &[[f32; 4]], repeats: u32) -> Vec<[f32; 4]> {
    let sum = |places: &[[f32; 4]]| {
        let samples = places.iter().map(|p| atlas.sample([p[0], p[1], p[2]]));
        let once = samples.fold([0.0; 4], |sum, s| [0, 1, 2, 3].map(|c| sum[c] + s[c]));
        once.map(|x: f32| x * repeats as f32)
    };
    places.chunks_exact(SAMPLES as usize).map(sum).collect()
}
