//! Twin of `shaders/flesh.comp`.

use glam::{DMat2, DQuat, DVec2, DVec3, DVec4, Vec4};

use super::Args;
use crate::{
    flesh::Map,
    layout::{FleshRow, JointPose},
    pass::flesh::Constants,
};

/// Of the way to the limit that is left; with less, skin goes back to the method's.
const WHOLE_ROOM: f64 = 0.3;
/// Of what is left towards the centre of curvature, in a normal.
const LEAST_ROOM: f64 = 1e-3;

/// What all rows share.
struct Spines<'a> {
    weights: &'a [[f32; 4]],
    points: &'a [[f32; 4]],
    palette: &'a [JointPose],
}

/// The posed curve at a row's parameter.
struct Curve {
    spot: DVec3,
    tangent: DVec3,
    /// Derivative of the tangent by the parameter.
    tangent_rate: DVec3,
    /// Length a unit of the parameter, and the derivative of its logarithm.
    speed: f64,
    quicken: f64,
    /// Curvature vector and its derivative by length.
    bend: DVec3,
    bend_rate: DVec3,
}

/// The posed frame there.
struct Frame {
    side: DVec3,
    lift: DVec3,
    /// Turn about the tangent, a unit of length.
    twist: f64,
    /// Model units a rest unit.
    scale: f64,
}

/// Bends the listed rows along their spines, in f64.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let rows = args.read::<FleshRow>(0);
    let spines = Spines {
        weights: args.read(2),
        points: args.read(3),
        palette: args.read(4),
    };
    let position = args.write::<[f32; 4]>(5);
    let normal = args.write::<[f32; 4]>(6);
    for row in &rows[..c.count as usize] {
        let to = row.rows[0] as usize;
        let (place, turned, left) = bend(row, &spines);
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

impl Curve {
    fn new(row: &FleshRow, spines: &Spines<'_>) -> Self {
        let [_, weight, point, count] = row.rows.map(|word| word as usize);
        let weights = &spines.weights[weight..weight + count];
        let mut sum = [DVec3::ZERO; 4];
        for (w, p) in weights.iter().zip(&spines.points[point..]) {
            let rows = spines.palette[p[3] as usize].rows;
            let rows = rows.map(|r| Vec4::from_array(r).as_dvec4());
            let at = DVec4::new(p[0].into(), p[1].into(), p[2].into(), 1.0);
            let carried = DVec3::from_array(rows.map(|r| r.dot(at)));
            for (slot, w) in sum.iter_mut().zip(w) {
                *slot += f64::from(*w) * carried;
            }
        }
        let [spot, first, second, third] = sum;
        let speed = first.length().max(1e-20);
        let tangent = first / speed;
        let quicken = second.dot(tangent) / speed;
        let across = second - quicken * first;
        Self {
            spot,
            tangent,
            tangent_rate: across / speed,
            speed,
            quicken,
            bend: across / (speed * speed),
            bend_rate: (third - 3.0 * quicken * across) / speed.powi(3),
        }
    }
}

impl Frame {
    /// The rest frame, turned by the joints' rotations, then by the least rotation onto the tangent.
    fn new(row: &FleshRow, curve: &Curve, palette: &[JointPose]) -> Self {
        let [tangent, side, covector, frame, turning] =
            [row.tangent, row.side, row.covector, row.frame, row.turning].map(|v| v.map(f64::from));
        let joints = [frame[0], frame[1]].map(|joint| &palette[joint as usize]);
        let (q, spin) = blend(joints, covector[3], frame[2]);
        let (tangent, side) = (DVec3::from_slice(&tangent), DVec3::from_slice(&side));
        let rest_rate = turning[0] * side + turning[1] * tangent.cross(side);
        let (carried, t) = (q * tangent, curve.tangent);
        let carried_rate = spin.cross(carried) + q * rest_rate;
        let turned = match carried.dot(t) < -0.9999 {
            true => q * side,
            false => DQuat::from_rotation_arc(carried.normalize(), t) * (q * side),
        };
        let side = turned.reject_from_normalized(t).normalize();
        let swept = t.dot(carried.cross(carried_rate)) - carried.dot(t.cross(curve.tangent_rate));
        let sweep = swept / (1.0 + carried.dot(t)).max(1e-4);
        let [a, b] = joints.map(scale);
        Self {
            side,
            lift: t.cross(side),
            twist: (spin.dot(carried) + sweep) / curve.speed,
            scale: a + covector[3] * (b - a),
        }
    }

    fn plane(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.side), v.dot(self.lift))
    }

    fn space(&self, v: DVec2) -> DVec3 {
        v.x * self.side + v.y * self.lift
    }
}

/// The rotation between two joints', and how it turns a unit of the parameter.
fn blend(joints: [&JointPose; 2], share: f64, share_rate: f64) -> (DQuat, DVec3) {
    let [a, mut b] = joints.map(|joint| DQuat::from_array(joint.real.map(f64::from)));
    if a.dot(b) < 0.0 {
        b = -b;
    }
    let blended = a * (1.0 - share) + b * share;
    let length = blended.length().max(1e-20);
    let q = blended / length;
    let rate = (b - a) * share_rate;
    let rate = (rate - q * q.dot(rate)) / length;
    (q, 2.0 * (rate * q.conjugate()).xyz())
}

/// Cube root of a joint's volume.
fn scale(joint: &JointPose) -> f64 {
    let rows = joint
        .rows
        .map(|r| Vec4::from_array(r).truncate().as_dvec3());
    rows[0].dot(rows[1].cross(rows[2])).abs().cbrt()
}

/// Where a row's spine puts it, its unit normal there, and what is left of the way to the limit.
fn bend(row: &FleshRow, spines: &Spines<'_>) -> (DVec3, DVec3, f64) {
    let curve = Curve::new(row, spines);
    let frame = Frame::new(row, &curve, spines.palette);
    let [straight, covector] = [row.straight, row.covector].map(|v| v.map(f64::from));
    let stretch = curve.speed / f64::from(row.tangent[3]);
    let curvature = frame.plane(curve.bend);
    let rate = frame.plane(curve.bend_rate) - frame.twist * curvature.perp();
    let thin = frame.scale * (frame.scale / stretch.max(1e-20)).sqrt();
    let offset = thin * DVec2::from_slice(&straight);
    let map = [Map::Radial, Map::Normal, Map::Binormal][row.frame[3] as usize];
    let shift = map.bend(offset, curvature, rate);
    let past = f64::from(row.side[3]) * stretch * curve.tangent;
    let place = curve.spot + past + frame.space(shift.offset);

    let thinning = -0.5 * (curve.quicken - straight[3]) / curve.speed;
    let room = (1.0 - curvature.dot(shift.offset)).max(LEAST_ROOM);
    let slide =
        shift.along + frame.twist * shift.offset.perp() + thinning * (shift.by_offset * offset);
    let m = cofactor(shift.by_offset) * DVec2::new(covector[1], covector[2]) / thin;
    let m_along = covector[0] * shift.by_offset.determinant() / stretch - m.dot(slide);
    let normal = (m_along * curve.tangent + room * frame.space(m)).normalize_or_zero();
    (
        place,
        normal,
        1.0 - curvature.dot(offset) / map.straight_limit(),
    )
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
