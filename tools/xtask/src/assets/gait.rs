//! A walking cycle from the joint angles of human gait.

use dermis::asset::Clip;
use glam::DVec3;

use super::{
    mannequin::{ARM_DROP, arm_direction},
    motion::{Bones, Pose, add_way, clip},
};

/// Joint angles in degrees at every tenth of the cycle, which starts when the heel strikes. After the textbook curves of
/// level walking (D. A. Winter, Biomechanics and Motor Control of Human Movement).
const HIP: [f64; 10] = [26.0, 22.0, 14.0, 4.0, -6.0, -13.0, -7.0, 11.0, 24.0, 29.0];
const KNEE: [f64; 10] = [4.0, 16.0, 17.0, 9.0, 4.0, 9.0, 34.0, 61.0, 53.0, 19.0];
const ANKLE: [f64; 10] = [1.0, -5.0, 4.0, 8.0, 11.0, 8.0, -13.0, -10.0, 0.0, 3.0];
const TOES: [f64; 10] = [8.0, 0.0, 0.0, 0.0, 6.0, 22.0, 16.0, 2.0, 4.0, 10.0];

/// Seconds for two steps.
const SECONDS: f64 = 1.1;
/// Keys of the cycle, the last like the first.
const KEYS: usize = 33;

/// The clip `walk`, on the spot; it loops.
pub(crate) fn walk(bones: &Bones) -> Clip {
    let poses: Vec<Pose> = (0..KEYS)
        .map(|i| stride(bones, (i % (KEYS - 1)) as f64 / (KEYS - 1) as f64))
        .collect();
    let mut walk = clip("walk", SECONDS, &poses);
    add_way(&mut walk, bones.0[0].at, &poses);
    walk
}

/// The pose at a phase of the left leg's cycle, from 0 to 1.
fn stride(bones: &Bones, phase: f64) -> Pose {
    let mut pose = Pose::rest(bones);
    let wave = |curve: &[f64; 10]| [periodic(curve, phase), periodic(curve, phase + 0.5)];
    let [hip, knee, ankle, toes] = [wave(&HIP), wave(&KNEE), wave(&ANKLE), wave(&TOES)];
    // Pelvis and chest turn against each other with the legs.
    let swing = (hip[0] - hip[1]) / 2.0;
    pose.turn(bones.row("hips"), DVec3::Y, -0.22 * swing);
    pose.turn(bones.row("hips"), DVec3::X, 2.0);
    pose.turn(bones.row("spine"), DVec3::Y, 0.25 * swing);
    pose.turn(bones.row("chest"), DVec3::Y, 0.25 * swing);
    pose.turn(bones.row("head"), DVec3::Y, -0.28 * swing);
    for (i, (side, name)) in [(1.0, "left"), (-1.0, "right")].into_iter().enumerate() {
        let row = |part: &str| bones.row(&format!("{name}_{part}"));
        // Positive angles flex: the thigh forward, the shin back, the foot up.
        pose.turn(row("thigh"), DVec3::Z, side * -2.0);
        pose.turn(row("thigh"), DVec3::X, -hip[i]);
        pose.turn(row("shin"), DVec3::X, knee[i]);
        pose.turn(row("foot"), DVec3::X, -ankle[i]);
        pose.turn(row("toes"), DVec3::X, -toes[i]);
        swing_arm(&mut pose, bones, side, name, -side * swing);
    }
    pose.shift.y = -lowest(bones, &pose);
    pose
}

/// Lets an arm hang and swing by `degrees` forward, the elbow bent a little more in front.
fn swing_arm(pose: &mut Pose, bones: &Bones, side: f64, name: &str, degrees: f64) {
    let (upper, lower) = (
        bones.row(&format!("{name}_upper_arm")),
        bones.row(&format!("{name}_forearm")),
    );
    let clavicle = bones.row(&format!("{name}_clavicle"));
    pose.turn(clavicle, DVec3::Z, side * -6.0);
    pose.turn(upper, DVec3::X, -degrees);
    pose.turn(upper, DVec3::Z, side * -(90.0 - ARM_DROP - 12.0));
    let flex = arm_direction(side).cross(DVec3::Z).normalize();
    pose.turn(lower, flex, 22.0 + 0.5 * degrees);
}

/// Catmull-Rom spline through ten values of a cycle.
fn periodic(values: &[f64; 10], phase: f64) -> f64 {
    let at = phase.rem_euclid(1.0) * 10.0;
    let (i, t) = (at as usize % 10, at.fract());
    let value = |k: usize| values[(i + 9 + k) % 10];
    let [a, b, c, d] = [0, 1, 2, 3].map(value);
    b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
}

/// Height of the lowest point of the feet; the shift that puts it on the ground makes the hips rise and fall.
pub(crate) fn lowest(bones: &Bones, pose: &Pose) -> f64 {
    let height = |side: f64, name: &str| {
        let point = |part: &str, x: f64, z: f64| {
            let joint = bones.row(&format!("{name}_{part}"));
            bones.posed(joint, DVec3::new(side * x, 0.0, z), pose).y
        };
        let [heel, ball, tip] = [
            ("foot", 0.113, -0.05),
            ("foot", 0.122, 0.09),
            ("toes", 0.126, 0.15),
        ]
        .map(|(part, x, z)| point(part, x, z));
        heel.min(ball).min(tip)
    };
    height(1.0, "left").min(height(-1.0, "right"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::mannequin::body;

    #[test]
    fn the_walk_loops_and_keeps_a_foot_on_the_ground() {
        let bones = body().bones;
        let (first, last) = (stride(&bones, 0.0), stride(&bones, 1.0));
        assert!(
            first
                .turns
                .iter()
                .zip(&last.turns)
                .all(|(a, b)| a.dot(*b) > 1.0 - 1e-12)
        );
        for i in 0..20 {
            let pose = stride(&bones, f64::from(i) / 20.0);
            assert!(lowest(&bones, &pose).abs() < 1e-9);
            assert!(
                pose.shift.y.abs() < 0.06,
                "the hips stay near their height: {}",
                pose.shift.y
            );
        }
    }

    #[test]
    fn the_spline_passes_through_its_values() {
        for (i, value) in KNEE.iter().enumerate() {
            assert!((periodic(&KNEE, i as f64 / 10.0) - value).abs() < 1e-9);
        }
    }
}
