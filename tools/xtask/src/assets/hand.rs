//! `hand.glb`: a right hand, fingers up, palm towards +z; sixteen joints.

use dermis::asset::Model;
use glam::DVec3;

use super::{
    body::Body,
    motion::{Bones, Pose, clip, ease, turn},
    shape::{Limb, Part, Shape},
};
use crate::Result;

/// A finger: name, first knuckle, tilt towards the thumb in degrees, lengths of its bones, radii at their ends.
struct Finger {
    name: &'static str,
    knuckle: [f64; 3],
    tilt: f64,
    lengths: [f64; 3],
    radii: [f64; 4],
}

const FINGERS: [Finger; 4] = [
    Finger {
        name: "index",
        knuckle: [0.0315, 0.0930, 0.0],
        tilt: 7.0,
        lengths: [0.042, 0.025, 0.018],
        radii: [0.0098, 0.0088, 0.0080, 0.0068],
    },
    Finger {
        name: "middle",
        knuckle: [0.0095, 0.0970, 0.0015],
        tilt: 1.0,
        lengths: [0.046, 0.029, 0.019],
        radii: [0.0098, 0.0089, 0.0082, 0.0070],
    },
    Finger {
        name: "ring",
        knuckle: [-0.0125, 0.0930, 0.0005],
        tilt: -5.5,
        lengths: [0.042, 0.027, 0.019],
        radii: [0.0094, 0.0085, 0.0078, 0.0067],
    },
    Finger {
        name: "little",
        knuckle: [-0.0330, 0.0840, -0.002],
        tilt: -13.0,
        lengths: [0.033, 0.020, 0.016],
        radii: [0.0084, 0.0075, 0.0069, 0.0060],
    },
];

const THUMB_ROOT: DVec3 = DVec3::new(0.021, 0.022, 0.008);
const THUMB_LENGTHS: [f64; 3] = [0.044, 0.033, 0.021];

/// The hand with its clips.
pub(crate) fn model() -> Result<Model> {
    let body = body();
    let mut model = body.model()?;
    let fist = |straight: Option<&str>| -> Vec<Pose> {
        let closed = closed(&body.bones, straight);
        let rest = Pose::rest(&body.bones);
        // Closes, holds, opens.
        let amount = |i: i32| (f64::from(20 - (i - 20).abs()) / 15.0).clamp(0.0, 1.0);
        (0..=40)
            .map(|i| rest.between(&closed, ease(amount(i))))
            .collect()
    };
    model.clips.push(clip("fist", 2.0, &fist(None)));
    model.clips.push(clip("point", 2.0, &fist(Some("index"))));
    Ok(model)
}

fn body() -> Body {
    let mut bones = Bones::default();
    let wrist = bones.add("wrist", None, DVec3::ZERO);
    let mut limbs: Vec<Limb> = FINGERS
        .iter()
        .map(|f| finger(&mut bones, wrist, f))
        .collect();
    limbs.push(thumb(&mut bones, wrist));
    Body {
        name: "hand",
        color: [0.72, 0.43, 0.31],
        shape: Shape {
            core: palm(wrist),
            limbs,
            web: 0.003,
        },
        bones,
        bounds: [
            DVec3::new(-0.07, -0.10, -0.04),
            DVec3::new(0.12, 0.21, 0.06),
        ],
        spacing: 0.0029,
        softness: 7,
    }
}

/// Forearm's end, one ray to each knuckle, and the two balls of the palm.
fn palm(wrist: usize) -> Limb {
    let part = |from: [f64; 3], to: [f64; 3], radius| {
        Part::new(wrist, DVec3::from(from), DVec3::from(to), radius)
    };
    let mut parts = vec![
        part([0.0, -0.055, -0.002], [0.0, 0.0, -0.002], [0.0215, 0.0185]).wide(DVec3::X, 1.35),
        part(
            [0.012, 0.022, 0.010],
            [0.028, 0.050, 0.008],
            [0.0155, 0.0125],
        ),
        part(
            [-0.022, 0.018, 0.006],
            [-0.027, 0.055, 0.003],
            [0.0140, 0.0120],
        ),
    ];
    for finger in &FINGERS {
        let [x, y, z] = finger.knuckle;
        let thick = finger.radii[0] + 0.0015;
        parts.push(part(
            [x * 0.55, 0.004, -0.001],
            [x * 0.97, y - 0.010, z - 0.001],
            [0.0145, thick],
        ));
    }
    Limb {
        parts,
        inner: 0.012,
        fillet: 0.0,
    }
}

fn finger(bones: &mut Bones, wrist: usize, finger: &Finger) -> Limb {
    let along = turn(DVec3::Z, -finger.tilt) * DVec3::Y;
    let joints = chain(
        bones,
        wrist,
        finger.name,
        DVec3::from(finger.knuckle),
        [along; 3],
        finger.lengths,
    );
    Limb {
        parts: cones(&joints, finger.radii),
        inner: 0.0025,
        fillet: 0.008,
    }
}

/// Up and outwards, a little towards the palm.
fn thumb_direction(bone: usize) -> DVec3 {
    let outwards = [52.0, 40.0, 32.0][bone];
    let across = turn(DVec3::Z, -outwards) * DVec3::Y;
    (across + DVec3::Z * 0.28).normalize()
}

fn thumb(bones: &mut Bones, wrist: usize) -> Limb {
    let along = [0, 1, 2].map(thumb_direction);
    let joints = chain(bones, wrist, "thumb", THUMB_ROOT, along, THUMB_LENGTHS);
    Limb {
        parts: cones(&joints, [0.0150, 0.0112, 0.0105, 0.0084]),
        inner: 0.004,
        fillet: 0.012,
    }
}

/// Three joints in a row; returns each with the ends of its bone.
fn chain(
    bones: &mut Bones,
    wrist: usize,
    name: &str,
    root: DVec3,
    along: [DVec3; 3],
    lengths: [f64; 3],
) -> [(usize, DVec3, DVec3); 3] {
    let (mut parent, mut at) = (wrist, root);
    [0, 1, 2].map(|i| {
        let joint = bones.add(format!("{name}_{}", i + 1), Some(parent), at);
        let from = at;
        at += along[i] * lengths[i];
        parent = joint;
        (joint, from, at)
    })
}

fn cones(joints: &[(usize, DVec3, DVec3); 3], radii: [f64; 4]) -> Vec<Part> {
    let cone = |(i, (joint, from, to)): (usize, &(usize, DVec3, DVec3))| {
        Part::new(*joint, *from, *to, [radii[i], radii[i + 1]])
    };
    joints.iter().enumerate().map(cone).collect()
}

/// A fist, but for one finger that may stay straight.
fn closed(bones: &Bones, straight: Option<&str>) -> Pose {
    let mut pose = Pose::rest(bones);
    for finger in FINGERS.iter().filter(|f| Some(f.name) != straight) {
        // Fingers that spread at rest close side by side.
        let first = bones.row(&format!("{}_1", finger.name));
        pose.turn(first, DVec3::Z, finger.tilt * 0.7);
        let across = turn(DVec3::Z, -finger.tilt) * DVec3::X;
        for (i, degrees) in [84.0, 102.0, 66.0].into_iter().enumerate() {
            pose.turn(
                bones.row(&format!("{}_{}", finger.name, i + 1)),
                across,
                degrees,
            );
        }
    }
    let across = thumb_direction(0)
        .cross(DVec3::new(-0.35, 0.1, 1.0))
        .normalize();
    let palm = thumb_direction(1)
        .cross(DVec3::new(-1.0, 0.25, 0.3))
        .normalize();
    pose.turn(bones.row("thumb_1"), across, 38.0);
    pose.turn(bones.row("thumb_2"), palm, 45.0);
    pose.turn(bones.row("thumb_3"), palm, 45.0);
    pose
}
