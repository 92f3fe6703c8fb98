//! The oriented box of a field: along the bone, and no larger than where the field is felt.

use glam::{DMat3, DVec3};

use super::{FADE, Field, FieldBox};

/// A value below this is not felt: 4 % of r from the end of the support.
const FELT: f64 = 1e-4;
/// Points along an edge of the grid that looks for the support.
const COARSE: usize = 20;
/// Points along an edge of a plane that moves in from a face, and the moves within one coarse cell.
const PLANE: usize = 16;
const MOVES: usize = 4;

/// The box of `field`, whose own bounds are not looked at; `points` are the part's vertices.
pub(super) fn bounds(field: &Field, points: &[DVec3]) -> FieldBox {
    let axes = axes(field, points);
    let to_box = axes.transpose();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    // The fade ends here, so nothing can be cut.
    let margin = DVec3::splat(FADE[1] as f64 * field.radius as f64);
    for end in field.segments.iter().flatten() {
        let x = to_box * end.as_dvec3();
        low = low.min(x - margin);
        high = high.max(x + margin);
    }
    let felt = |x: DVec3| field.at(axes * x).0 > FELT;
    (low, high) = shrink(low, high, felt);
    FieldBox {
        origin: (axes * low).as_vec3(),
        axes: axes.as_mat3(),
        size: (high - low).as_vec3(),
    }
}

/// x along the bone; y and z along the part's principal axes across it.
fn axes(field: &Field, points: &[DVec3]) -> DMat3 {
    let spans: Vec<DVec3> = field
        .segments
        .iter()
        .map(|[a, b]| (*b - *a).as_dvec3())
        .collect();
    let sum: DVec3 = spans.iter().sum();
    let total: f64 = spans.iter().map(|s| s.length()).sum();
    let longest =
        spans.iter().copied().fold(
            DVec3::ZERO,
            |a, b| if b.length() > a.length() { b } else { a },
        );
    let x = if sum.length() > 0.5 * total {
        sum
    } else {
        longest
    };
    let x = x.try_normalize().unwrap_or(DVec3::X);
    let (u, v) = x.any_orthonormal_pair();
    let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let (mut uu, mut uv, mut vv) = (0.0, 0.0, 0.0);
    for p in points {
        let (a, b) = ((p - middle).dot(u), (p - middle).dot(v));
        uu += a * a;
        uv += a * b;
        vv += b * b;
    }
    let angle = 0.5 * f64::atan2(2.0 * uv, uu - vv);
    let y = angle.cos() * u + angle.sin() * v;
    DMat3::from_cols(x, y, x.cross(y))
}

/// The part of a box that holds every felt point: coarse cells first, then each face moves in as far as it feels nothing.
fn shrink(low: DVec3, high: DVec3, felt: impl Fn(DVec3) -> bool) -> (DVec3, DVec3) {
    let step = (high - low) / COARSE as f64;
    let (mut first, mut last) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for i in 0..COARSE.pow(3) {
        let cell = [i % COARSE, i / COARSE % COARSE, i / COARSE / COARSE];
        let x = low + step * DVec3::from_array(cell.map(|c| c as f64 + 0.5));
        if felt(x) {
            first = first.min(x);
            last = last.max(x);
        }
    }
    if first.x > last.x {
        return (low, high);
    }
    let (mut first, mut last) = ((first - step).max(low), (last + step).min(high));
    for axis in 0..3 {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let feels = |at: f64, first: DVec3, last: DVec3| {
            (0..PLANE * PLANE).any(|i| {
                let mut x = first;
                x[axis] = at;
                let share = |i: usize| i as f64 / (PLANE - 1) as f64;
                x[b] += share(i % PLANE) * (last - first)[b];
                x[c] += share(i / PLANE) * (last - first)[c];
                felt(x)
            })
        };
        let stride = step[axis] / MOVES as f64;
        for _ in 0..MOVES {
            if !feels(first[axis] + stride, first, last) {
                first[axis] += stride;
            }
            if !feels(last[axis] - stride, first, last) {
                last[axis] -= stride;
            }
        }
    }
    (first, last)
}
