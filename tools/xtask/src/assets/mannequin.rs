//! `mannequin.glb`: a person of 1.75 m, arms held away from the body, facing +z; 21 joints.

use dermis::asset::Model;
use glam::DVec3;

use super::{
    body::Body,
    gait,
    motion::{Bones, turn},
    shape::{Limb, Part, Shape},
    stunts,
};
use crate::Result;

/// How far the arms hang below the horizontal at rest, degrees.
pub(crate) const ARM_DROP: f64 = 48.0;
const UPPER_ARM: f64 = 0.285;
const FOREARM: f64 = 0.25;
const PALM: f64 = 0.085;

/// The mannequin with its clips.
pub(crate) fn model() -> Result<Model> {
    let body = body();
    let mut model = body.model()?;
    model.clips.push(gait::walk(&body.bones));
    model.clips.push(stunts::extreme(&body.bones));
    Ok(model)
}

/// Direction of an arm at rest; `side` is +1 for the left.
pub(crate) fn arm_direction(side: f64) -> DVec3 {
    let along = turn(DVec3::Z, -ARM_DROP) * DVec3::X;
    DVec3::new(side * along.x, along.y, along.z)
}

pub(crate) fn body() -> Body {
    let mut bones = Bones::default();
    let core = trunk(&mut bones);
    let mut limbs = vec![head(&bones)];
    for (side, name) in [(1.0, "left"), (-1.0, "right")] {
        limbs.push(arm(&mut bones, side, name));
    }
    for (side, name) in [(1.0, "left"), (-1.0, "right")] {
        limbs.push(leg(&mut bones, side, name));
    }
    Body {
        name: "mannequin",
        color: [0.66, 0.45, 0.27],
        shape: Shape {
            core,
            limbs,
            web: 0.02,
        },
        bones,
        bounds: [
            DVec3::new(-0.85, -0.02, -0.25),
            DVec3::new(0.85, 1.80, 0.30),
        ],
        spacing: 0.0130,
        softness: 11,
    }
}

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn trunk(bones: &mut Bones) -> Limb {
    let hips = bones.add("hips", None, v(0.0, 0.96, 0.0));
    let spine = bones.add("spine", Some(hips), v(0.0, 1.08, -0.005));
    let chest = bones.add("chest", Some(spine), v(0.0, 1.23, -0.015));
    let neck = bones.add("neck", Some(chest), v(0.0, 1.455, -0.02));
    bones.add("head", Some(neck), v(0.0, 1.555, 0.0));
    let mut parts = vec![
        Part::new(
            hips,
            v(-0.055, 0.955, 0.0),
            v(0.055, 0.955, 0.0),
            [0.098; 2],
        ),
        Part::new(
            spine,
            v(0.0, 1.07, 0.005),
            v(0.0, 1.15, 0.0),
            [0.094, 0.098],
        )
        .wide(DVec3::X, 1.22),
        Part::new(
            chest,
            v(0.0, 1.23, 0.0),
            v(0.0, 1.33, -0.01),
            [0.102, 0.100],
        )
        .wide(DVec3::X, 1.38),
        Part::new(
            chest,
            v(0.0, 1.36, -0.02),
            v(0.0, 1.42, -0.022),
            [0.075, 0.055],
        )
        .wide(DVec3::X, 1.55),
        Part::new(
            neck,
            v(0.0, 1.43, -0.02),
            v(0.0, 1.56, -0.008),
            [0.052, 0.045],
        ),
    ];
    for side in [1.0, -1.0] {
        parts.push(Part::ball(chest, v(side * 0.066, 1.320, 0.034), 0.066).wide(DVec3::X, 1.15));
        parts.push(Part::ball(hips, v(side * 0.066, 0.930, -0.042), 0.080));
    }
    Limb {
        parts,
        inner: 0.035,
        fillet: 0.0,
    }
}

/// The egg of an artist's lay figure.
fn head(bones: &Bones) -> Limb {
    let head = bones.row("head");
    let skull = Part::new(
        head,
        v(0.0, 1.648, -0.014),
        v(0.0, 1.648, 0.012),
        [0.078; 2],
    );
    let chin = Part::ball(head, v(0.0, 1.588, 0.042), 0.045);
    Limb {
        parts: vec![skull.wide(DVec3::Y, 1.28), chin],
        inner: 0.04,
        fillet: 0.025,
    }
}

fn arm(bones: &mut Bones, side: f64, name: &str) -> Limb {
    let along = arm_direction(side);
    let shoulder = v(side * 0.180, 1.405, -0.018);
    let elbow = shoulder + along * UPPER_ARM;
    let wrist = elbow + along * FOREARM;
    let collar = v(side * 0.025, 1.425, -0.012);
    let chest = bones.row("chest");
    let clavicle = bones.add(format!("{name}_clavicle"), Some(chest), collar);
    let upper = bones.add(format!("{name}_upper_arm"), Some(clavicle), shoulder);
    let lower = bones.add(format!("{name}_forearm"), Some(upper), elbow);
    let hand = bones.add(format!("{name}_hand"), Some(lower), wrist);
    // The palm faces the thigh: the hand is broad from front to back.
    let palm = wrist + along * PALM;
    let tip = palm + along * 0.075 + v(0.0, -0.004, 0.004);
    let thumb = wrist + along * 0.022 + DVec3::Z * 0.022;
    let parts = vec![
        Part::new(
            clavicle,
            v(side * 0.06, 1.415, -0.02),
            shoulder - v(side * 0.025, 0.004, 0.0),
            [0.047, 0.056],
        ),
        Part::ball(upper, shoulder + along * 0.02, 0.058),
        Part::new(upper, shoulder, shoulder + along * 0.14, [0.054, 0.046]),
        Part::new(upper, shoulder + along * 0.14, elbow, [0.046, 0.038]),
        Part::new(lower, elbow, elbow + along * 0.08, [0.038, 0.041]),
        Part::new(lower, elbow + along * 0.08, wrist, [0.041, 0.026]),
        Part::new(hand, wrist, palm, [0.0225, 0.0235]).wide(DVec3::Z, 1.6),
        Part::new(hand, palm, tip, [0.0205, 0.0145]).wide(DVec3::Z, 1.75),
        Part::new(
            hand,
            thumb,
            thumb + along * 0.055 + DVec3::Z * 0.030,
            [0.0165, 0.0125],
        ),
    ];
    Limb {
        parts,
        inner: 0.010,
        fillet: 0.035,
    }
}

fn leg(bones: &mut Bones, side: f64, name: &str) -> Limb {
    let x = |x: f64| side * x;
    let hip = v(x(0.094), 0.915, -0.005);
    let knee = v(x(0.106), 0.500, 0.008);
    let ankle = v(x(0.112), 0.088, -0.030);
    let ball = v(x(0.122), 0.0357, 0.090);
    let toe = v(x(0.126), 0.0295, 0.150);
    let hips = bones.row("hips");
    let thigh = bones.add(format!("{name}_thigh"), Some(hips), hip);
    let shin = bones.add(format!("{name}_shin"), Some(thigh), knee);
    let foot = bones.add(format!("{name}_foot"), Some(shin), ankle);
    let toes = bones.add(format!("{name}_toes"), Some(foot), ball);
    let parts = vec![
        Part::new(thigh, hip, v(x(0.100), 0.70, 0.004), [0.083, 0.073]),
        Part::new(thigh, v(x(0.100), 0.70, 0.004), knee, [0.073, 0.054]),
        Part::new(shin, knee, v(x(0.109), 0.33, -0.016), [0.053, 0.049]),
        Part::new(shin, v(x(0.109), 0.33, -0.016), ankle, [0.049, 0.034]),
        Part::new(
            shin,
            v(x(0.106), 0.39, -0.034),
            v(x(0.108), 0.29, -0.030),
            [0.042, 0.034],
        ),
        Part::new(foot, v(x(0.113), 0.0395, -0.048), ball, [0.036, 0.033]),
        Part::new(foot, ankle, v(x(0.119), 0.048, 0.055), [0.034, 0.032]),
        Part::new(toes, ball, toe, [0.032, 0.025]).wide(DVec3::X, 1.28),
    ];
    Limb {
        parts,
        inner: 0.014,
        fillet: 0.035,
    }
}
