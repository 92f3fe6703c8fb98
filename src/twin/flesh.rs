//! Twin of `shaders/flesh.comp`.

use glam::{DMat2, DQuat, DVec2, DVec3, DVec4, Vec4};

use super::Args;
use crate::{
    flesh::{BINORMAL_ROOM, Map},
    layout::{FleshRow, JointPose},
    pass::flesh::Constants,
};

/// Of the way to the limit that is left; with less, skin goes back to the method's.
const WHOLE_ROOM: f64 = 0.3;
/// Of what is left towards the centre of curvature, in a normal.
const LEAST_ROOM: f64 = 1e-3;

/// Bends the listed rows along their spines, in f64.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let rows = args.read::<FleshRow>(0);
    let weights = args.read::<[f32; 4]>(2);
    let points = args.read::<[f32; 4]>(3);
    let palette = args.read::<JointPose>(4);
    let position = args.write::<[f32; 4]>(5);
    let normal = args.write::<[f32; 4]>(6);
    for row in &rows[..c.count as usize] {
        let [to, ..] = row.rows.map(|word| word as usize);
        let (place, turned, left) = bend(row, weights, points, palette);
        let weight = f64::from(row.straight[2]) * smoothstep(left / WHOLE_ROOM);
        let skin = DVec3::from_slice(&position[to].map(f64::from));
        let old = DVec3::from_slice(&normal[to].map(f64::from));
        let place = skin.lerp(place, weight).as_vec3();
        position[to][..3].copy_from_slice(&place.to_array());
        let mixed = old.lerp(turned, weight).normalize_or_zero();
        let past = if left > 0.0 { 0.0 } else { 1.0 };
        normal[to] = mixed.as_vec3().extend(past).to_array();
    }
}

/// The curve and its first three derivatives.
fn jet(
    row: &FleshRow,
    weights: &[[f32; 4]],
    points: &[[f32; 4]],
    palette: &[JointPose],
) -> [DVec3; 4] {
    let [_, weight, point, count] = row.rows.map(|word| word as usize);
    let mut sum = [DVec3::ZERO; 4];
    for (w, p) in weights[weight..weight + count].iter().zip(&points[point..]) {
        let rows = palette[p[3] as usize]
            .rows
            .map(|r| Vec4::from_array(r).as_dvec4());
        let at = DVec4::new(p[0].into(), p[1].into(), p[2].into(), 1.0);
        let carried = DVec3::from_array(rows.map(|r| r.dot(at)));
        for (slot, w) in sum.iter_mut().zip(w) {
            *slot += f64::from(*w) * carried;
        }
    }
    sum
}

/// Cube root of a joint's volume.
fn scale(joint: &JointPose) -> f64 {
    let [a, b, c] = joint
        .rows
        .map(|r| Vec4::from_array(r).truncate().as_dvec3());
    a.dot(b.cross(c)).abs().cbrt()
}

/// Where a row's spine puts it, its unit normal there, and what is left of the way to the limit.
fn bend(
    row: &FleshRow,
    weights: &[[f32; 4]],
    points: &[[f32; 4]],
    palette: &[JointPose],
) -> (DVec3, DVec3, f64) {
    let [tangent, side, straight, covector, frame] =
        [row.tangent, row.side, row.straight, row.covector, row.frame].map(|v| v.map(f64::from));
    let [spot, first, second, third] = jet(row, weights, points, palette);
    let speed = first.length().max(1e-20);
    let stretch = speed / tangent[3];
    let t = first / speed;
    let along = second.dot(t);
    let across = second - along * t;
    let bend_vector = across / (speed * speed);
    let bend_rate = (third - 3.0 * along / speed * across) / speed.powi(3);

    let joints = [frame[0], frame[1]].map(|joint| &palette[joint as usize]);
    let [qa, mut qb] = joints.map(|joint| DQuat::from_array(joint.real.map(f64::from)));
    if qa.dot(qb) < 0.0 {
        qb = -qb;
    }
    let share = covector[3];
    let blended = qa * (1.0 - share) + qb * share;
    let length = blended.length().max(1e-20);
    let q = blended / length;
    let rate = (qb - qa) * frame[2];
    let rate = (rate - q * q.dot(rate)) / length;
    let spin = 2.0 * (rate * q.conjugate()).xyz();
    let carried = q * DVec3::from_slice(&tangent);
    let least = |v: DVec3| match carried.dot(t) < -0.9999 {
        true => v,
        false => DQuat::from_rotation_arc(carried.normalize(), t) * v,
    };
    let i = least(q * DVec3::from_slice(&side))
        .reject_from_normalized(t)
        .normalize();
    let j = t.cross(i);
    let (axis, first_side) = (DVec3::from_slice(&tangent), DVec3::from_slice(&side));
    let [u, v, ..] = row.turning.map(f64::from);
    let carried_rate = spin.cross(carried) + q * (u * first_side + v * axis.cross(first_side));
    let tangent_rate = across / speed;
    let swept = t.dot(carried.cross(carried_rate)) - carried.dot(t.cross(tangent_rate));
    let twist = (spin.dot(carried) + swept / (1.0 + carried.dot(t)).max(1e-4)) / speed;

    let plane = |v: DVec3| DVec2::new(v.dot(i), v.dot(j));
    let space = |v: DVec2| v.x * i + v.y * j;
    let curvature = plane(bend_vector);
    let rate = plane(bend_rate) - twist * curvature.perp();
    let scale = scale(joints[0]) * (1.0 - share) + scale(joints[1]) * share;
    let thin = scale * (scale / stretch.max(1e-20)).sqrt();
    let offset = thin * DVec2::from_slice(&straight);
    let map = [Map::Radial, Map::Normal, Map::Binormal][frame[3] as usize];
    let shift = map.bend(offset, curvature, rate);
    let place = spot + side[3] * stretch * t + space(shift.offset);

    let thinning = -0.5 * (along / speed - straight[3]) / speed;
    let room = (1.0 - curvature.dot(shift.offset)).max(LEAST_ROOM);
    let slide = shift.along + twist * shift.offset.perp() + thinning * (shift.by_offset * offset);
    let m = cofactor(shift.by_offset) * DVec2::new(covector[1], covector[2]) / thin;
    let m_along = covector[0] * shift.by_offset.determinant() / stretch - m.dot(slide);
    let normal = (m_along * t + room * space(m)).normalize_or_zero();
    // Eqs. 9, 13, 17.
    let limit = match map {
        Map::Radial => 1.0 / 3f64.sqrt(),
        Map::Normal => 0.5,
        Map::Binormal => 1.0 - BINORMAL_ROOM,
    };
    (place, normal, 1.0 - curvature.dot(offset) / limit)
}

fn smoothstep(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Determinant times the inverse's transpose.
fn cofactor(m: DMat2) -> DMat2 {
    let (a, b) = (m.x_axis, m.y_axis);
    DMat2::from_cols(DVec2::new(b.y, -b.x), DVec2::new(-a.y, a.x))
}
