//! Twin of `shaders/moved.comp`.

use glam::Vec3;

use super::{
    Args,
    shared::{field::Boxes, list, motion::Motions, set},
};
use crate::{layout::state, pass::moved::Constants};

/// Settles the vertices that move as one with all fields around them, and enters the others.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let geometric = args.read::<[f32; 4]>(2);
    let iso = args.read::<f32>(3);
    let direction = args.read::<[f32; 4]>(4);
    let motions = Motions {
        joints: args.read(5),
        weights: args.read(6),
        palette: args.read(7),
        width: c.width,
    };
    let ranks = args.read::<u32>(8);
    let position = args.write::<[f32; 4]>(9);
    let status = args.write::<u32>(10);
    let live_set = args.write::<u32>(11);
    let boxes = Boxes::new(args, 12);
    for &seed in listed {
        let v = seed as usize;
        let x = Vec3::from_slice(&geometric[v]);
        // A vertex to be projected has at least one field around it at rest.
        if boxes.moved_as(motions.of(v)[1], x) == direction[v][3] as u32 {
            position[v] = x.extend(iso[v]).to_array();
            status[v] = state::ON_ISO;
        } else {
            set::enter(live_set, ranks[v]);
        }
    }
}
