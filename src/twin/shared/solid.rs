//! Twin of `shaders/shared/solid.glsl`.

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

use crate::layout::particles::Primitive;

/// Further than anything.
pub(crate) const FAR: f32 = 1e30;
const BORDER: f32 = 1e-6;
const ROUNDING: f32 = 2.4e-7;

/// How far a sphere goes until it touches, [`FAR`] for never; negative for what lies behind.
pub(crate) fn enter(solid: &Primitive, origin: Vec3, direction: Vec3, radius: f32) -> f32 {
    let mut first = FAR;
    for k in 0..3 {
        let (ball, side) = (Vec4::from(solid.balls[k]), Vec4::from(solid.sides[k]));
        let (sine, square) = (solid.sines[k], solid.squares[k]);
        let mut from = origin - ball.xyz();
        let (middle, reach) = (-from.dot(direction), ball.w + radius);
        from += direction * middle;
        let apart = from.dot(from) - reach * reach;
        if apart <= 0.0 {
            first = first.min(middle - (-apart).sqrt());
        }
        let (along, w) = (
            direction.dot(side.xyz()),
            from.dot(side.xyz()) - reach * sine,
        );
        let (a, b, c) = (square - along * along, -along * w, square * apart - w * w);
        let root = b * b - a * c;
        if side.w > 0.0 && root >= 0.0 {
            let q = -(b + if b < 0.0 { -root.sqrt() } else { root.sqrt() });
            let end = side.w * square;
            for at in [q / a, c / q] {
                if w + along * at >= 0.0 && w + along * at <= end {
                    first = first.min(middle + at);
                }
            }
        }
    }
    let ball = Vec4::from(solid.balls[0]);
    for face in &solid.faces {
        let normal = Vec4::from(face.normal).xyz();
        let (u, v) = (Vec4::from(face.u), Vec4::from(face.v));
        let against = normal.dot(direction);
        let from = origin - ball.xyz() - normal * (ball.w + radius);
        let at = -from.dot(normal) / against;
        let p = from + direction * at;
        let share = Vec2::new(p.dot(u.xyz()), p.dot(v.xyz()));
        let border = BORDER + ROUNDING * u.w * at.abs();
        let within = share.x.min(share.y) >= -border && share.x + share.y <= 1.0 + border;
        if against < 0.0 && within {
            first = first.min(at);
        }
    }
    first
}

/// Shares of the three spheres in the interpolated sphere whose surface is nearest, or that holds the point deepest.
pub(crate) fn nearest(solid: &Primitive, p: Vec3) -> Vec3 {
    let (mut best, mut least) = (Vec3::X, FAR);
    for k in 0..3 {
        let (ball, side) = (Vec4::from(solid.balls[k]), Vec4::from(solid.sides[k]));
        let (sine, square) = (solid.sines[k], solid.squares[k]);
        let from = p - ball.xyz();
        let y = from.dot(side.xyz());
        let x = (from - side.xyz() * y).length();
        let s = if side.w > 0.0 {
            (y - x * sine / square.sqrt()).clamp(0.0, side.w)
        } else {
            0.0
        };
        let away = (from - side.xyz() * s).length() - ball.w + sine * s;
        if away < least {
            let t = if side.w > 0.0 { s / side.w } else { 0.0 };
            let mut share = Vec3::ZERO;
            share[k] = 1.0 - t;
            share[(k + 1) % 3] = t;
            (least, best) = (away, share);
        }
    }
    let from = p - Vec4::from(solid.balls[0]).xyz();
    let [front, back] = &solid.faces;
    let across = (Vec4::from(front.normal) - Vec4::from(back.normal)).xyz();
    let face = if from.dot(across) < 0.0 { back } else { front };
    let u = from.dot(Vec4::from(face.u).xyz());
    let v = from.dot(Vec4::from(face.v).xyz());
    if face.normal[3] > 0.0 && u.min(v) >= 0.0 && u + v <= 1.0 {
        best = Vec3::new(1.0 - u - v, u, v);
    }
    best
}

/// The sphere that has these shares: centre and radius.
pub(crate) fn ball_of(solid: &Primitive, share: Vec3) -> (Vec3, f32) {
    let ball = mix(&solid.balls, share);
    (ball.xyz(), ball.w)
}

/// Its way in the frame.
pub(crate) fn way_of(solid: &Primitive, share: Vec3) -> Vec3 {
    mix(&solid.moves, share).xyz()
}

fn mix(rows: &[[f32; 4]; 3], share: Vec3) -> Vec4 {
    let [a, b, c] = rows.map(Vec4::from);
    share.x * a + share.y * b + share.z * c
}

/// The direction in which the surface is nearest, from the nearest sphere's centre.
pub(crate) fn way_out(solid: &Primitive, from: Vec3) -> Vec3 {
    let away = from.length();
    if away > 1e-6 * solid.bound[3] {
        return from / away;
    }
    let normal = Vec4::from(solid.faces[0].normal);
    let axis = Vec4::from(solid.sides[0]).xyz();
    let across = if axis.x.abs() < 0.6 {
        Vec3::new(0.0, axis.z, -axis.y)
    } else {
        Vec3::new(-axis.z, 0.0, axis.x)
    };
    if normal.w > 0.0 {
        normal.xyz()
    } else if across.dot(across) > 0.0 {
        across / across.length()
    } else {
        Vec3::Y
    }
}
