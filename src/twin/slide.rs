//! Twin of `shaders/slide.comp`.

use super::{
    Args,
    shared::{
        list,
        relaxation::{Relaxation, at, normal},
    },
};
use crate::{layout::FieldsHead, pass::slide::Constants};

/// Relaxes the listed vertices.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let bodies = args.read::<[f32; 4]>(5);
    let slopes = args.read::<[f32; 4]>(9);
    let scale = args.read::<FieldsHead>(10)[0].box_scale[3];
    let relaxation = Relaxation {
        offsets: args.read(2),
        rings: args.read(3),
        weights: args.read(4),
        goals: args.read(6),
        starts: args.read(7),
        befores: args.read(8),
    };
    let tracks = args.write::<[f32; 4]>(11);
    for &v in listed {
        let [_, radius, freedom, _] = bodies[v as usize];
        let radius = radius * scale;
        let y = relaxation.relaxed(v, normal(at(slopes, v)), freedom, c.omega, radius);
        let moved = (y - relaxation.start(v)).length() / radius;
        tracks[v as usize] = y.extend(moved).to_array();
    }
}
