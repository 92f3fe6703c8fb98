//! Poisson-disk samples of a part's surface (2013, section 4.1).

use glam::DVec3;

use super::bone::Parts;

/// A point of the surface with its unit normal, in rest space.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint {
    pub(super) position: DVec3,
    pub(super) normal: DVec3,
}

/// Points spread over the triangles of a part, besides its vertices.
const ON_TRIANGLES: usize = 1000;
/// At most so many vertices are candidates.
const ON_VERTICES: usize = 1000;

/// Candidates for samples: vertices of the part and points on triangles that lie wholly in it, in a shuffled but fixed order.
pub(super) fn candidates(parts: &Parts, joint: usize, own: &[u32]) -> Vec<SurfacePoint> {
    let at = |v: u32| parts.vertex(v);
    let stride = own.len().div_ceil(ON_VERTICES).max(1);
    let mut points: Vec<SurfacePoint> = own.iter().step_by(stride).map(|&v| at(v)).collect();
    points.extend(on_triangles(parts, joint, own, at));
    points.retain(|p| p.normal.length() > 0.5);
    let mut keyed: Vec<(u32, SurfacePoint)> = points
        .into_iter()
        .enumerate()
        .map(|(i, p)| (shuffle(i as u32), p))
        .collect();
    keyed.sort_by_key(|&(key, _)| key);
    keyed.into_iter().map(|(_, p)| p).collect()
}

/// Points on the triangles wholly in the part, evenly by area.
fn on_triangles(
    parts: &Parts,
    joint: usize,
    own: &[u32],
    at: impl Fn(u32) -> SurfacePoint,
) -> Vec<SurfacePoint> {
    let inside = |v: u32| parts.part[v as usize] == Some(joint);
    let mut triangles = Vec::new();
    let mut area = 0.0;
    for &v in own {
        for pair in parts.mesh.corners.row(v as usize).chunks_exact(2) {
            // Each triangle is met at its three vertices: take it at the least.
            if v < pair[0] && v < pair[1] && inside(pair[0]) && inside(pair[1]) {
                let corners = [v, pair[0], pair[1]].map(&at);
                let [a, b, c] = corners.map(|p| p.position);
                let normal = (b - a).cross(c - a);
                area += 0.5 * normal.length();
                triangles.push((area, corners, normal.normalize_or_zero()));
            }
        }
    }
    (0..ON_TRIANGLES)
        .filter_map(|i| {
            let x = (i as f64 + 0.5) / ON_TRIANGLES as f64 * area;
            let (_, corners, face) = triangles.get(triangles.partition_point(|t| t.0 < x))?;
            // Kronecker sequence of the plastic number, folded into the triangle.
            let (mut u, mut v) = (
                (0.754_877_666_246_69 * i as f64).fract(),
                (0.569_840_290_998_05 * i as f64).fract(),
            );
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let mix = |f: fn(&SurfacePoint) -> DVec3| {
                (1.0 - u - v) * f(&corners[0]) + u * f(&corners[1]) + v * f(&corners[2])
            };
            let smooth = mix(|p| p.normal);
            let smooth = if smooth.length() > 0.3 { smooth } else { *face };
            Some(SurfacePoint {
                position: mix(|p| p.position),
                normal: smooth.try_normalize()?,
            })
        })
        .collect()
}

/// A fixed permutation of 32-bit numbers (finaliser of MurmurHash3).
fn shuffle(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x85eb_ca6b);
    x = (x ^ (x >> 13)).wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}

/// About `target` of the points, no two on the same side of the surface nearer than the Poisson radius, which is found by bisection.
///
/// The two sides of a thin sheet are sampled apart from each other, or the one would push out the samples of the other.
pub(super) fn poisson(points: &[SurfacePoint], target: usize) -> Vec<SurfacePoint> {
    let (mut low, mut high) = (0.0, extent(points));
    let mut best = throw(points, high, 2 * target);
    for _ in 0..18 {
        let radius = 0.5 * (low + high);
        let thrown = throw(points, radius, 2 * target);
        if thrown.len() > target {
            low = radius;
        } else {
            high = radius;
        }
        if thrown.len().abs_diff(target) < best.len().abs_diff(target) {
            best = thrown;
        }
    }
    best
}

/// Dart throwing in the points' order, given up at `most`.
fn throw(points: &[SurfacePoint], radius: f64, most: usize) -> Vec<SurfacePoint> {
    let mut taken: Vec<SurfacePoint> = Vec::new();
    // Nearer centres with opposite normals make coefficients so large that single precision cannot add them up.
    let least = 0.35 * radius;
    for p in points {
        let free = taken.iter().all(|q| {
            let apart = p.position.distance_squared(q.position);
            let other_side = apart > least * least && p.normal.dot(q.normal) < 0.0;
            apart > 0.0 && (apart >= radius * radius || other_side)
        });
        if free {
            taken.push(*p);
        }
        if taken.len() >= most {
            break;
        }
    }
    taken
}

/// Diagonal of the points' bounding box.
fn extent(points: &[SurfacePoint]) -> f64 {
    let (low, high) = points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
            (low.min(p.position), high.max(p.position))
        });
    if points.is_empty() {
        0.0
    } else {
        low.distance(high)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn square(n: usize) -> Vec<SurfacePoint> {
        (0..n as u32)
            .map(|i| SurfacePoint {
                position: DVec3::new(
                    shuffle(2 * i) as f64 / u32::MAX as f64,
                    shuffle(2 * i + 1) as f64 / u32::MAX as f64,
                    0.0,
                ),
                normal: DVec3::Z,
            })
            .collect()
    }

    #[test]
    fn samples_hit_the_target_and_keep_apart() {
        let samples = poisson(&square(2000), 50);
        assert!((47..=53).contains(&samples.len()), "{}", samples.len());
        let nearest = |p: &SurfacePoint| {
            samples
                .iter()
                .map(|q| p.position.distance(q.position))
                .filter(|&d| d > 0.0)
                .fold(f64::INFINITY, f64::min)
        };
        let least = samples.iter().map(nearest).fold(f64::INFINITY, f64::min);
        // 50 disks in dart throwing's usual jamming density .55: radius of about .12.
        assert!(least > 0.1, "{least}");
    }

    #[test]
    fn both_sides_of_a_sheet_get_their_share() {
        let mut points = square(2000);
        for (i, p) in points.iter_mut().enumerate().filter(|(i, _)| i % 2 == 0) {
            p.position.z = 1e-3 * (i % 2) as f64 - 0.02;
            p.normal = -DVec3::Z;
        }
        let samples = poisson(&points, 50);
        let below = samples.iter().filter(|p| p.normal.z < 0.0).count();
        assert!((18..=32).contains(&below), "{below} of {}", samples.len());
    }

    #[test]
    fn few_points_are_all_taken() {
        assert_eq!(poisson(&square(9), 50).len(), 9);
        assert!(poisson(&[], 50).is_empty());
    }
}
