//! Twin of `shaders/track.comp`.

use rayon::prelude::*;

use super::{
    Args,
    shared::{
        field::{Composite, IN_CONTACT},
        list,
        newton::{LEAP, newton},
        relaxation::{Relaxation, at, normal},
        set,
    },
};
use crate::pass::track::Constants;

/// Share of the Newton step of a vertex that has crossed a contact sheet.
const RETURN: f32 = 2.0;

/// Iterates once on the listed vertices.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let bodies = args.read::<[f32; 4]>(5);
    let slopes = args.read::<[f32; 4]>(9);
    let relaxation = Relaxation {
        offsets: args.read(2),
        rings: args.read(3),
        weights: args.read(4),
        goals: args.read(6),
        starts: args.read(7),
        befores: args.read(8),
    };
    let field = Composite::new(args, 12);
    let (tracks, gradients) = (args.write::<[f32; 4]>(10), args.write::<[f32; 4]>(11));
    let live_set = args.write::<u32>(18);
    let step = |&v: &u32| {
        let [iso, radius, freedom, _] = bodies[v as usize];
        let radius = radius * field.scale();
        let y = relaxation.relaxed(v, normal(at(slopes, v)), freedom, c.omega, radius);
        let (sampled, sheet) = field.evaluate_sheet(y);
        let (f, g) = sampled;
        let crossed = sheet > IN_CONTACT && f > iso && at(slopes, v).dot(g) < 0.0;
        let sigma = if crossed { RETURN } else { c.sigma };
        let to = y + relaxation.pace(v) * newton(iso, sampled, sigma, radius, LEAP);
        let g = if crossed { -g } else { g };
        let moved = (to - relaxation.start(v)).length() / radius;
        (to.extend(moved).to_array(), g.extend(f).to_array())
    };
    let done: Vec<([f32; 4], [f32; 4])> = listed.par_iter().map(step).collect();
    for (&v, (track, gradient)) in listed.iter().zip(done) {
        tracks[v as usize] = track;
        gradients[v as usize] = gradient;
        if c.enter != 0 && track[3] > c.stillness {
            set::enter(live_set, bodies[v as usize][3] as u32);
            let ranks = relaxation.ring(v).iter().map(|j| bodies[*j as usize][3]);
            for rank in ranks.filter(|rank| *rank >= 0.0) {
                set::enter(live_set, rank as u32);
            }
        }
    }
}
