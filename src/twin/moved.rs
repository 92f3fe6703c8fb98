//! Twin of `shaders/moved.comp`.

use glam::Vec3;

use super::{
    Args,
    shared::{field::Boxes, list, set},
    skin_dqs::joint_at,
};
use crate::{
    layout::{JointPose, NO_MOTION, state},
    pass::moved::Constants,
};

/// Settles the vertices that move as one with all fields around them, and enters the others.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let geometric = args.read::<[f32; 4]>(2);
    let iso = args.read::<f32>(3);
    let direction = args.read::<[f32; 4]>(4);
    let (joints, weights) = (args.read::<u32>(5), args.read::<f32>(6));
    let palette = args.read::<JointPose>(7);
    let ranks = args.read::<u32>(8);
    let position = args.write::<[f32; 4]>(9);
    let status = args.write::<u32>(10);
    let live_set = args.write::<u32>(11);
    let boxes = Boxes::new(args, 12);
    for &seed in listed {
        let v = seed as usize;
        let x = Vec3::from_slice(&geometric[v]);
        let motion = motion_of(v, &c, joints, weights, palette);
        // A vertex to be projected has at least one field around it at rest.
        if boxes.moving_as(motion, x) == direction[v][3] as u32 {
            position[v] = x.extend(iso[v]).to_array();
            status[v] = state::ON_ISO;
        } else {
            set::enter(live_set, ranks[v]);
        }
    }
}

/// Number of the motion that all joints of a vertex have; [`NO_MOTION`] where they differ.
fn motion_of(
    v: usize,
    c: &Constants,
    joints: &[u32],
    weights: &[f32],
    palette: &[JointPose],
) -> u32 {
    let influences = v * c.width as usize..(v + 1) * c.width as usize;
    let motion = |at: usize| palette[joint_at(joints, at)].stretch0[3] as u32;
    let first = motion(influences.start);
    let same = influences
        .filter(|at| weights[*at] > 0.0)
        .all(|at| motion(at) == first);
    if same { first } else { NO_MOTION }
}
