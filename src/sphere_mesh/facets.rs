//! Solids as small triangles on their surfaces: caps of spheres, sides of cones, faces of slabs.

use glam::DVec3;

use super::shape::{Ball, Shape, gradient};

/// A triangle in space, counter-clockwise seen from outside.
pub(super) type Facet = [DVec3; 3];

/// Surfaces of all solids of a shape, each whole, in pieces no longer than about `size`; `chord` is the greatest distance
/// of a facet's side to the round surface that it stands for, twice that of its middle.
pub(super) fn facets(shape: &Shape, size: f64, chord: f64) -> Vec<Facet> {
    let mut out = Vec::new();
    for ball in &shape.balls {
        cap(ball, size, chord, &mut out);
    }
    let ball = |k: u32| &shape.balls[k as usize];
    let mut sides: Vec<[u32; 2]> = shape.edges.clone();
    for &[a, b, c] in &shape.triangles {
        face([a, b, c].map(|k| *ball(k)), size, &mut out);
        sides.extend([[a, b], [b, c], [a, c]]);
    }
    sides.sort_unstable();
    sides.dedup();
    for [a, b] in sides {
        side(ball(a), ball(b), size, chord, &mut out);
    }
    out
}

/// Pieces around a circle.
fn around(radius: f64, size: f64, chord: f64) -> usize {
    let step = (2.0 * (1.0 - (chord / radius).min(0.5)).acos()).min(size / radius);
    ((std::f64::consts::TAU / step).ceil() as usize).clamp(6, 512)
}

/// How many times finer rows are than pieces around a circle, whose middles are h² / 8 inside: the middle of a facet is at most
/// twice that.
const WIDE: f64 = 1.2;

fn cap(ball: &Ball, size: f64, chord: f64, out: &mut Vec<Facet>) {
    if ball.radius <= 0.0 {
        return;
    }
    let count = (WIDE * around(ball.radius, size, chord) as f64 / 4.0).ceil() as usize;
    for sign in 0..8 {
        let s = |bit: u32| if sign >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let (x, y, z) = (DVec3::X * s(0), DVec3::Y * s(1), DVec3::Z * s(2));
        let octant = if s(0) * s(1) * s(2) > 0.0 {
            [x, y, z]
        } else {
            [x, z, y]
        };
        rows(octant, count, &mut |t: Facet| {
            out.push(t.map(|v| ball.centre + ball.radius * v));
        });
    }
}

/// Cuts an octant of the unit sphere into rows of height h around `pole`, the i-th with i pieces, up to π/2 h wide. The middle of
/// such a piece is (1.5 (π/2)² + 2) / 18 h² = .32 h² inside. (A triangle's even pieces, put onto the sphere, are .44 h² inside.)
fn rows([pole, x, y]: Facet, count: usize, out: &mut impl FnMut(Facet)) {
    let right = std::f64::consts::FRAC_PI_2;
    let at = |row: usize, k: usize| {
        let down = right * row as f64 / count as f64;
        let turn = right * k as f64 / row.max(1) as f64;
        pole * down.cos() + (x * turn.cos() + y * turn.sin()) * down.sin()
    };
    for row in 0..count {
        for k in 0..=row {
            out([at(row, k), at(row + 1, k), at(row + 1, k + 1)]);
            if k < row {
                out([at(row, k), at(row + 1, k + 1), at(row, k + 1)]);
            }
        }
    }
}

/// Cuts a triangle into `count`² alike.
fn split([a, b, c]: Facet, count: usize, out: &mut impl FnMut(Facet)) {
    let step = 1.0 / count as f64;
    let at = |i: usize, j: usize| a + (b - a) * (i as f64 * step) + (c - a) * (j as f64 * step);
    for i in 0..count {
        for j in 0..count - i {
            out([at(i, j), at(i + 1, j), at(i, j + 1)]);
            if i + j + 1 < count {
                out([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
}

fn pieces(length: f64, size: f64) -> usize {
    ((length / size).ceil() as usize).clamp(1, 4096)
}

/// The two faces of a slab: c_i + r_i N with N = -g ± √(1 - g²) n; one where all radii are 0.
fn face(corners: [Ball; 3], size: f64, out: &mut Vec<Facet>) {
    let Some((gradient, normal)) = gradient(&corners) else {
        return;
    };
    let rise = normal * (1.0 - gradient.length_squared()).sqrt();
    let thin = corners.iter().all(|ball| ball.radius == 0.0);
    for up in [true, false] {
        if thin && !up {
            continue;
        }
        let outwards = if up {
            rise - gradient
        } else {
            -rise - gradient
        };
        let [a, b, c] = corners.map(|ball| ball.centre + ball.radius * outwards);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let whole = if up { [a, b, c] } else { [a, c, b] };
        split(whole, pieces(longest, size), &mut |t| out.push(t));
    }
}

fn side(a: &Ball, b: &Ball, size: f64, chord: f64, out: &mut Vec<Facet>) {
    let axis = b.centre - a.centre;
    let length = axis.length();
    let sin = (a.radius - b.radius) / length;
    if length == 0.0 || sin.abs() >= 1.0 {
        return;
    }
    let axis = axis / length;
    let (u, v) = axis.any_orthonormal_pair();
    let (u, v) = if u.cross(v).dot(axis) > 0.0 {
        (u, v)
    } else {
        (v, u)
    };
    let cos = (1.0 - sin * sin).sqrt();
    let steps = pieces(length, size);
    // A wire without thickness is a line: one triangle without area a piece.
    let wire = a.radius.max(b.radius) == 0.0;
    let turns = if wire {
        1
    } else {
        around(a.radius.max(b.radius), size, chord)
    };
    let at = |i: usize, k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / turns as f64;
        let normal = cos * (u * angle.cos() + v * angle.sin()) + sin * axis;
        let t = i as f64 / steps as f64;
        let radius = a.radius + t * (b.radius - a.radius);
        a.centre + axis * (length * t) + normal * radius
    };
    for i in 0..steps {
        for k in 0..turns {
            let [p, q, r, s] = [at(i, k), at(i, k + 1), at(i + 1, k), at(i + 1, k + 1)];
            out.push([p, q, r]);
            if !wire {
                out.push([q, s, r]);
            }
        }
    }
}
