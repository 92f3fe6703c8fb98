//! A sequence of the benches' own.

use dermis::asset::Sequence;
use glam::{Quat, Vec3};

/// A tube that bends more from frame to frame.
pub(crate) fn tube(rings: usize, around: usize, frames: usize) -> Sequence {
    let bent = |turn: f32| {
        let point = |i: usize| {
            let t = (i / around) as f32 / (rings - 1) as f32 * 2.0 - 1.0;
            let a = (i % around) as f32 / around as f32 * std::f32::consts::TAU;
            let r = 0.2 + 0.05 * (7.0 * t).sin();
            Quat::from_rotation_z(turn * t.max(0.0)) * Vec3::new(t, r * a.cos(), r * a.sin())
        };
        (0..rings * around).map(point).collect()
    };
    let (n, m) = (around as u32, rings as u32);
    let quads = (0..m - 1).flat_map(|i| (0..n).map(move |k| (i, k)));
    let triangles = quads.flat_map(|(i, k)| {
        let next = (k + 1) % n;
        let [a, b, c, d] = [i * n + k, i * n + next, (i + 1) * n + k, (i + 1) * n + next];
        [[a, b, c], [b, d, c]]
    });
    Sequence {
        path: "tube".into(),
        triangles: triangles.collect(),
        frames: (0..frames)
            .map(|f| bent(f as f32 / frames as f32))
            .collect(),
    }
}
