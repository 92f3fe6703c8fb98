//! `tail.glb`: a tapering tail whose bones run along its back, as a spine does.

use dermis::asset::Model;
use glam::DVec3;

use super::{
    arm::{self, capsule},
    motion::{Bones, Pose, clip, sin_cos},
    shape::put_skin,
    surface::{check_closed, normals, split},
    weights::strongest,
};
use crate::Result;

/// Metres from the first joint to the last bone's end.
const LENGTH: f64 = 1.2;
/// Bones that bend, after the one that holds the tail.
const BONES: usize = 8;
/// Radius at the root and at the tip.
const RADIUS: [f64; 2] = [0.12, 0.025];
/// How far the bones are above the middle, in radii.
const BACK: f64 = 0.5;
/// Rings get closer towards the tip, as the tail gets thinner: the last by this, the first by 2 less this of the mean.
const EVEN: f64 = 0.35;
/// Degrees that each joint swings.
const SWING: f64 = 20.0;

/// The tail along +x.
pub(crate) fn model() -> Result<Model> {
    let mut bones = Bones::default();
    let step = LENGTH / (BONES + 1) as f64;
    let mut parent = bones.add("body", None, back(0.0));
    for bone in 1..=BONES {
        parent = bones.add(
            format!("tail_{bone}"),
            Some(parent),
            back(bone as f64 * step),
        );
    }
    let (even, faces) = capsule();
    let triangles: Vec<_> = faces.iter().flat_map(|face| split(&even, face)).collect();
    let positions: Vec<DVec3> = even.into_iter().map(tapered).collect();
    check_closed(&triangles, positions.len())?;
    let mut model = Model {
        path: "tail.glb".into(),
        ..Model::default()
    };
    let normals = normals(&positions, &triangles);
    let color = [0.33, 0.52, 0.36, 1.0];
    put_skin(&mut model, color, &positions, &normals, triangles);
    let influences = positions.iter().map(|p| {
        let at = (p.x / step).clamp(0.5, BONES as f64 + 0.5);
        strongest((0..=BONES).map(|bone| share(at - bone as f64 - 0.5)))
    });
    model.influences = influences.collect();
    bones.put(&mut model);
    model
        .clips
        .push(clip("swing", 2.0, &swing(&bones, DVec3::Y)));
    model
        .clips
        .push(clip("lift", 2.0, &swing(&bones, DVec3::Z)));
    Ok(model)
}

/// Radius at a place along.
fn radius(x: f64) -> f64 {
    let t = (x / LENGTH).clamp(0.0, 1.0);
    RADIUS[0] + t * (RADIUS[1] - RADIUS[0])
}

/// Where the bones run: straight, from the back of the root to the tip's.
fn back(x: f64) -> DVec3 {
    DVec3::new(x, BACK * radius(x), 0.0)
}

/// From the arm's capsule; its round ends get the tail's radii.
fn tapered(p: DVec3) -> DVec3 {
    let along = p.x.clamp(-arm::LENGTH, arm::LENGTH);
    let t = 0.5 * (along / arm::LENGTH + 1.0);
    let x = LENGTH * t * (EVEN + (1.0 - EVEN) * (2.0 - t));
    let scale = radius(x) / arm::RADIUS;
    DVec3::new(x + (p.x - along) * scale, p.y * scale, p.z * scale)
}

/// Quadratic B-spline: weights that change smoothly from bone to bone and add up to 1.
fn share(x: f64) -> f64 {
    let x = x.abs();
    if x <= 0.5 {
        0.75 - x * x
    } else if x <= 1.5 {
        0.5 * (1.5 - x) * (1.5 - x)
    } else {
        0.0
    }
}

/// All joints alike to one side and to the other.
fn swing(bones: &Bones, axis: DVec3) -> Vec<Pose> {
    let frame = |i: i32| {
        let mut pose = Pose::rest(bones);
        for bone in 1..=BONES {
            let [sin, _] = sin_cos(6.0 * f64::from(i));
            pose.turn(bone, axis, SWING * sin);
        }
        pose
    };
    (0..=60).map(frame).collect()
}
