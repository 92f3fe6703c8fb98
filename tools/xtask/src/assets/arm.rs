//! `arm.glb`: a capsule with two bones, for experiments and figures.

use dermis::asset::Model;
use glam::DVec3;

use super::{
    motion::{Bones, Pose, clip, ease, sin_cos},
    shape::put_skin,
    surface::{check_closed, split},
    weights::strongest,
};
use crate::Result;

pub(super) const RADIUS: f64 = 0.05;
/// Each bone's length in metres.
pub(super) const LENGTH: f64 = 0.25;
/// Vertices around; a multiple of 4.
const AROUND: u32 = 64;
/// Steps along the straight part.
const ALONG: u32 = 102;
/// The weights change from one bone to the other over this length on both sides of the elbow.
const REACH: f64 = 0.05;

/// The arm along +x with the elbow at the origin.
pub(crate) fn model() -> Result<Model> {
    let mut bones = Bones::default();
    let upper = bones.add("upper", None, DVec3::X * -LENGTH);
    let lower = bones.add("lower", Some(upper), DVec3::ZERO);
    let (positions, faces) = capsule();
    let triangles: Vec<_> = faces
        .iter()
        .flat_map(|face| split(&positions, face))
        .collect();
    check_closed(&triangles, positions.len())?;
    let axis = |p: &DVec3| DVec3::X * p.x.clamp(-LENGTH, LENGTH);
    let normals: Vec<DVec3> = positions
        .iter()
        .map(|p| (*p - axis(p)).normalize())
        .collect();

    let mut model = Model {
        path: "arm.glb".into(),
        ..Model::default()
    };
    put_skin(
        &mut model,
        [0.76, 0.42, 0.28, 1.0],
        &positions,
        &normals,
        triangles,
    );
    model.influences = positions
        .iter()
        .map(|p| {
            let of_lower = ease(((p.x / REACH + 1.0) / 2.0).clamp(0.0, 1.0));
            strongest([1.0 - of_lower, of_lower].into_iter())
        })
        .collect();
    bones.put(&mut model);
    let frames = |axis: DVec3, degrees: f64| -> Vec<Pose> {
        (0..=60)
            .map(|i| {
                // There and back.
                let t = f64::from(30 - i32::abs(30 - i)) / 30.0;
                let mut pose = Pose::rest(&bones);
                pose.turn(lower, axis, degrees * ease(t));
                pose
            })
            .collect()
    };
    model
        .clips
        .push(clip("bend", 2.0, &frames(DVec3::Z, 120.0)));
    model
        .clips
        .push(clip("twist", 2.0, &frames(DVec3::X, 150.0)));
    Ok(model)
}

/// Rings around the x axis, closed by a disc of quads on either end.
pub(super) fn capsule() -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for ring in 0..=ALONG {
        let x = LENGTH * (2.0 * f64::from(ring) / f64::from(ALONG) - 1.0);
        positions.extend((0..AROUND).map(|i| around(x, i)));
    }
    for ring in 0..ALONG {
        for i in 0..AROUND {
            let (a, b) = (ring * AROUND + i, ring * AROUND + (i + 1) % AROUND);
            faces.push([a, b, b + AROUND, a + AROUND]);
        }
    }
    cap(&mut positions, &mut faces, 0, -1.0);
    cap(&mut positions, &mut faces, ALONG * AROUND, 1.0);
    (positions, faces)
}

fn around(x: f64, i: u32) -> DVec3 {
    let [sin, cos] = sin_cos(360.0 * f64::from(i) / f64::from(AROUND));
    DVec3::new(x, RADIUS * cos, RADIUS * sin)
}

/// A hemisphere of quads: a square of AROUND/4 cells a side, bent so that its border is the ring that starts at `ring`.
fn cap(positions: &mut Vec<DVec3>, faces: &mut Vec<[u32; 4]>, ring: u32, side: f64) {
    let half = AROUND as i32 / 8;
    let mut rows = std::collections::BTreeMap::new();
    for u in -half..=half {
        for v in -half..=half {
            let radius = u.abs().max(v.abs());
            let step = step_around(u, v);
            let row = if radius == half {
                ring + step as u32
            } else {
                let degrees = if radius == 0 {
                    0.0
                } else {
                    45.0 * f64::from(step) / f64::from(radius)
                };
                let ([sin, cos], [out, along]) = (
                    sin_cos(degrees),
                    sin_cos(90.0 * f64::from(radius) / f64::from(half)),
                );
                let (disc, x) = (DVec3::new(0.0, cos, sin) * out, DVec3::X * side * along);
                positions.push((disc + x) * RADIUS + DVec3::X * side * LENGTH);
                positions.len() as u32 - 1
            };
            rows.insert((u, v), row);
        }
    }
    for u in -half..half {
        for v in -half..half {
            let [a, b, c, d] = [(u, v), (u + 1, v), (u + 1, v + 1), (u, v + 1)].map(|at| rows[&at]);
            faces.push(if side > 0.0 {
                [a, b, c, d]
            } else {
                [d, c, b, a]
            });
        }
    }
}

/// How many cells a point of the square lies from (radius, 0), going around its own square counter-clockwise.
fn step_around(u: i32, v: i32) -> i32 {
    let r = u.abs().max(v.abs());
    let step = if u == r {
        v
    } else if v == r {
        2 * r - u
    } else if u == -r {
        4 * r - v
    } else {
        6 * r + u
    };
    step.rem_euclid(8 * r.max(1))
}
