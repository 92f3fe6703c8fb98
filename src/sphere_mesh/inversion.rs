//! Triangles that a collapse would turn over (2016, "Triangle inversion").

use multiversion::multiversion;

use super::lanes::{Points, V4, X4};

/// Whether a large triangle turns over in many frames where its first corner moves from `p` to `q`: Σ_f √(A A') n·n' < 0.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn turns(p: &[Points], q: &[Points], b: &[Points], c: &[Points]) -> bool {
    let normals = |group: usize| {
        let at = |points: &[Points]| V4::widen(&points[group]);
        let (p, q, b, c) = (at(p), at(q), at(b), at(c));
        ((b - p).cross(c - p), (b - q).cross(c - q))
    };
    // Hardly any turns in any frame, and roots are dear.
    let mut least = f64::INFINITY;
    for group in 0..p.len() {
        let (before, after) = normals(group);
        least = before.dot(after).0.into_iter().fold(least, f64::min);
    }
    if least >= 0.0 {
        return false;
    }
    let mut sum = X4::default();
    for group in 0..p.len() {
        let (before, after) = normals(group);
        let sizes = before.dot(before) * after.dot(after);
        // |n| is twice the area: √(A A') n·n' = N·N' / (2 √(|N| |N'|)).
        let scale = sizes.map(|s| {
            if s > 0.0 {
                s.sqrt().sqrt().recip()
            } else {
                0.0
            }
        });
        sum += before.dot(after) * scale;
    }
    sum.sum() < 0.0
}
