//! The clip `extreme`: joints bent as far as people bend them, and further.

use dermis::asset::Clip;
use glam::DVec3;

use super::{
    gait::lowest,
    mannequin::arm_direction,
    motion::{Bones, Pose, add_way, clip, ease},
};

/// Keys from one pose to the next.
const KEYS: usize = 10;
/// Seconds from one pose to the next.
const SECONDS: f64 = 1.0;

/// Rest, curl, squat, kick, twist and back to rest.
pub(crate) fn extreme(bones: &Bones) -> Clip {
    let rest = Pose::rest(bones);
    let stages = [
        rest.clone(),
        curl(bones),
        squat(bones),
        kick(bones),
        twist(bones),
        rest,
    ];
    let mut poses = vec![stages[0].clone()];
    for pair in stages.windows(2) {
        poses.extend((1..=KEYS).map(|i| {
            let mut pose = pair[0].between(&pair[1], ease(i as f64 / KEYS as f64));
            pose.shift.y = -lowest(bones, &pose);
            pose
        }));
    }
    let mut extreme = clip("extreme", SECONDS * (stages.len() - 1) as f64, &poses);
    add_way(&mut extreme, bones.0[0].at, &poses);
    extreme
}

/// Both sides with their sign and name.
const SIDES: [(f64, &str); 2] = [(1.0, "left"), (-1.0, "right")];

/// Lifts an arm sideways by `raise`, swings it forward by `forward`, bends the elbow by `flex`.
fn arm(
    pose: &mut Pose,
    bones: &Bones,
    (side, name): (f64, &str),
    [raise, forward, flex]: [f64; 3],
) {
    let row = |part: &str| bones.row(&format!("{name}_{part}"));
    // A fifth of the lift comes from the shoulder girdle.
    pose.turn(row("clavicle"), DVec3::Z, side * raise * 0.2);
    pose.turn(row("upper_arm"), DVec3::Y, side * -forward);
    pose.turn(row("upper_arm"), DVec3::Z, side * raise * 0.8);
    let axis = arm_direction(side).cross(DVec3::Z).normalize();
    pose.turn(row("forearm"), axis, flex);
}

/// Flexes hip, knee and ankle; spreads the leg outwards.
fn leg(
    pose: &mut Pose,
    bones: &Bones,
    (side, name): (f64, &str),
    [spread, hip, knee, ankle]: [f64; 4],
) {
    let row = |part: &str| bones.row(&format!("{name}_{part}"));
    pose.turn(row("thigh"), DVec3::Y, side * spread);
    pose.turn(row("thigh"), DVec3::X, -hip);
    pose.turn(row("shin"), DVec3::X, knee);
    pose.turn(row("foot"), DVec3::X, -ankle);
}

/// Bends the trunk forward.
fn bow(pose: &mut Pose, bones: &Bones, degrees: [f64; 3]) {
    for (name, degrees) in ["hips", "spine", "chest"].into_iter().zip(degrees) {
        pose.turn(bones.row(name), DVec3::X, degrees);
    }
}

/// Elbows at 145 degrees.
fn curl(bones: &Bones) -> Pose {
    let mut pose = Pose::rest(bones);
    for side in SIDES {
        arm(&mut pose, bones, side, [20.0, 15.0, 145.0]);
    }
    pose
}

/// Hips at 115, knees at 140 degrees, arms stretched forward.
fn squat(bones: &Bones) -> Pose {
    let mut pose = Pose::rest(bones);
    bow(&mut pose, bones, [28.0, 12.0, 8.0]);
    for side in SIDES {
        leg(&mut pose, bones, side, [22.0, 132.0, 140.0, 34.0]);
        arm(&mut pose, bones, side, [38.0, 70.0, 20.0]);
    }
    pose
}

/// One heel to the seat, the other leg lifted with the knee at 130 degrees.
fn kick(bones: &Bones) -> Pose {
    let mut pose = Pose::rest(bones);
    bow(&mut pose, bones, [0.0, 6.0, 6.0]);
    leg(&mut pose, bones, SIDES[0], [0.0, -8.0, 0.0, 8.0]);
    leg(&mut pose, bones, SIDES[1], [6.0, 120.0, 130.0, 0.0]);
    arm(&mut pose, bones, SIDES[0], [30.0, 60.0, 125.0]);
    arm(&mut pose, bones, SIDES[1], [60.0, -10.0, 90.0]);
    pose
}

/// The trunk wrung, one arm overhead.
fn twist(bones: &Bones) -> Pose {
    let mut pose = Pose::rest(bones);
    for (name, degrees) in [
        ("spine", 30.0),
        ("chest", 28.0),
        ("neck", 25.0),
        ("head", 30.0),
    ] {
        pose.turn(bones.row(name), DVec3::Y, degrees);
    }
    pose.turn(bones.row("spine"), DVec3::Z, 18.0);
    pose.turn(bones.row("chest"), DVec3::Z, 14.0);
    arm(&mut pose, bones, SIDES[0], [118.0, 10.0, 30.0]);
    arm(&mut pose, bones, SIDES[1], [-14.0, 30.0, 135.0]);
    leg(&mut pose, bones, SIDES[0], [8.0, 10.0, 12.0, 2.0]);
    leg(&mut pose, bones, SIDES[1], [8.0, 10.0, 12.0, 2.0]);
    pose
}
