//! Twin of the pass that samples a 3D atlas.

use half::f16;

/// Texels an edge of a tile.
const TILE: u32 = 32;
/// Samples an invocation takes.
const SAMPLES: u32 = 16;
/// Invocations of a workgroup.
const GROUP: u32 = 64;

/// The sum of the samples of each of `count` invocations, from an atlas of `extent` texels, x fastest.
pub fn ceiling_fetch(atlas: &[[f16; 4]], extent: [u32; 3], count: u32) -> Vec<[f32; 4]> {
    (0..count).map(|i| sum(atlas, extent, i)).collect()
}

fn sum(atlas: &[[f16; 4]], extent: [u32; 3], i: u32) -> [f32; 4] {
    let tiles = extent.map(|e| e / TILE);
    let hash = (i / GROUP).wrapping_mul(2_654_435_761) >> 16;
    let tile = hash % (tiles[0] * tiles[1] * tiles[2]);
    let corner = [
        tile % tiles[0],
        tile / tiles[0] % tiles[1],
        tile / (tiles[0] * tiles[1]),
    ];
    let lane = [i % 8, i / 8 % 8].map(|l| l as f32 * 1.25 + 8.75);
    let start = [lane[0], lane[1], 0.75];
    let mut p = [0, 1, 2].map(|a| (corner[a] * TILE) as f32 + start[a]);
    let mut sum = [0.0; 4];
    for _ in 0..SAMPLES {
        let sample = sample(atlas, extent, p);
        sum = [0, 1, 2, 3].map(|c| sum[c] + sample[c]);
        p = [p[0] + 0.5, p[1] + 0.25, p[2] + 1.75];
    }
    sum
}

/// Trilinear sample at `p` in texels, where the centre of texel i lies at i + ½; clamps to the edge.
fn sample(atlas: &[[f16; 4]], extent: [u32; 3], p: [f32; 3]) -> [f32; 4] {
    let low = p.map(|p| (p - 0.5).floor());
    let mut sum = [0.0; 4];
    for corner in 0..8 {
        let (mut row, mut weight) = (0, 1.0);
        for axis in [2, 1, 0] {
            let high = corner >> axis & 1;
            let fraction = p[axis] - 0.5 - low[axis];
            weight *= if high == 1 { fraction } else { 1.0 - fraction };
            let texel = (low[axis] as i64 + high).clamp(0, i64::from(extent[axis]) - 1);
            row = row * extent[axis] as usize + texel as usize;
        }
        let texel = atlas[row].map(f16::to_f32);
        sum = [0, 1, 2, 3].map(|c| sum[c] + weight * texel[c]);
    }
    sum
}
