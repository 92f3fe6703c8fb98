//! Importance of a vertex: total curvature, by cotangent Laplacian and angle deficit (2013, section 5; 2016, section 3).

use rayon::prelude::*;

use super::{
    input::Input,
    lanes::{LANES, V4, X4},
};

/// Greatest BBD² (κ₁² + κ₂²) that counts: a ball with 1/224 of the diagonal for its radius. Beyond are slivers.
const SHARPEST: f64 = 1e5;

/// (1 + BBD² (κ₁² + κ₂²))^`power` of each vertex in each frame, `[vertex][group]`.
pub(super) fn importance(input: &Input, power: f64) -> Vec<[f32; LANES]> {
    let mut values = vec![[0.0; LANES]; input.mesh.positions.len() * input.groups];
    let rows = values.par_chunks_exact_mut(input.groups).enumerate();
    rows.for_each(|(v, row)| {
        for (group, values) in row.iter_mut().enumerate() {
            // Lengths are in units of the diagonal already.
            let k = total(input, v, group).map(|k| (1.0 + k.min(SHARPEST)).powf(power));
            *values = k.narrow();
        }
    });
    values
}

/// κ₁² + κ₂² = 4 H² - 2 K of a vertex in four frames, at least 0.
fn total(input: &Input, v: usize, group: usize) -> X4 {
    let point = |v: u32| V4::widen(&input.position(v as usize)[group]);
    let here = point(v as u32);
    let mut laplacian = V4::default();
    let (mut area, mut deficit) = (X4::splat(1e-20), X4::splat(std::f64::consts::TAU));
    for corner in input.mesh.corners.row(v).chunks_exact(2) {
        let (a, b) = (point(corner[0]), point(corner[1]));
        let (ea, eb, ab) = (a - here, b - here, b - a);
        let cross = ea.cross(eb);
        let twice = cross.dot(cross).map(|x| x.sqrt() + 1e-20);
        // The edge to a faces the angle at b, the edge to b the angle at a.
        let half = twice.map(|x| 0.5 / x);
        let at_a = X4::default() - ea.dot(ab);
        let at_b = eb.dot(ab);
        laplacian = laplacian + ea.times(at_b * half) + eb.times(at_a * half);
        area += twice * X4::splat(1.0 / 6.0);
        deficit = deficit - twice.zip(ea.dot(eb), f64::atan2);
    }
    let mean = laplacian.dot(laplacian).zip(area, |l, a| l / (a * a));
    let gauss = deficit.zip(area, |d, a| 2.0 * d / a);
    mean.zip(gauss, |m, g| (m - g).max(0.0))
}
