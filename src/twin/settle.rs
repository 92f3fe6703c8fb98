//! Twin of `shaders/settle.comp`.

use glam::Vec3;
use rayon::prelude::*;

use super::{
    Args,
    shared::{
        field::Composite,
        list,
        newton::{FLAT, LEAP, PIT, shorten},
        set,
    },
};
use crate::{layout::state, pass::settle::Constants};

const EMPTY: f32 = 1e-4;

/// Where a vertex ends: its place, the field there, its status word.
struct End {
    place: Vec3,
    field: f32,
    status: u32,
}

/// Settles the listed vertices.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let starts = args.read::<[f32; 4]>(2);
    let bodies = args.read::<[f32; 4]>(3);
    let ranks = args.read::<u32>(4);
    let position = args.write::<[f32; 4]>(5);
    let status = args.write::<u32>(6);
    let contact_set = args.write::<u32>(7);
    let field = Composite::new(args, 8);
    let settle_one = |&v: &u32| {
        let v = v as usize;
        let start = Vec3::from_slice(&starts[v]);
        settle(start, bodies[v], status[v], &c, &field)
    };
    let ends: Vec<End> = listed.par_iter().map(settle_one).collect();
    for (&v, end) in listed.iter().zip(ends) {
        let v = v as usize;
        position[v] = end.place.extend(end.field).to_array();
        status[v] = end.status;
        if state::of(end.status) == state::CONTACT && c.hold == 0 {
            set::enter(contact_set, ranks[v]);
        }
    }
}

/// Steps until the vertex is on its iso-value, in contact, outside, or out of steps.
fn settle(start: Vec3, body: [f32; 4], before: u32, c: &Constants, field: &Composite<'_>) -> End {
    let (iso, radius) = (body[0], body[1] * field.scale());
    let held = c.hold != 0 && state::of(before) == state::CONTACT;
    let mut evaluations = state::evaluations(before);
    let mut fetches = state::fetches(before);
    let mut x = start;
    let mut last = (start, f32::MAX, 0.0, Vec3::ZERO);
    let mut now = state::LIVE;
    let mut s = 0;
    while now == state::LIVE {
        let (f, g) = field.evaluate(x, &mut fetches);
        evaluations += 1;
        let (off, steep) = ((f - iso).abs(), g.length());
        let turned = g.dot(last.3) < c.cos_contact * steep * last.3.length();
        if s > 0 && (off > last.1 + PIT || turned) {
            now = state::CONTACT;
        } else {
            last = (x, off, f, g);
            if held {
                now = state::CONTACT;
            } else if off < c.tolerance {
                now = state::ON_ISO;
            } else if steep * radius < FLAT {
                now = if f < EMPTY {
                    state::OUTSIDE
                } else {
                    state::CONTACT
                };
            } else if s < c.steps {
                x += shorten(c.sigma * (iso - f) / (steep * steep) * g, LEAP * radius);
            } else {
                now = state::LIMIT;
            }
        }
        s += 1;
    }
    End {
        place: last.0,
        field: last.2,
        status: now | evaluations.min(255) << 8 | fetches.min(0x7fff) << 16,
    }
}
