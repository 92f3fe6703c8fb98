//! Twin of `shaders/project.comp`.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::{
    Args,
    shared::{
        field::Composite,
        list,
        newton::{FLAT, LEAP, PIT, shorten},
        rotation::rotate,
        set,
    },
};
use crate::{
    layout::{Vertex, state},
    pass::project::{Constants, FRESH, HOLD},
};

const SIDEWAYS: f32 = 0.35;
const DEEP: f32 = 0.02;
const RELAXED_PIT: f32 = 0.02;

/// What the pass knows of one vertex.
#[derive(Clone, Copy)]
struct March {
    x: Vec3,
    anchor: Vec4,
    gradient: Vec4,
    status: u32,
    expected: Vec3,
}

/// Projects the listed vertices.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let start = args.read::<[f32; 4]>(2);
    let geometric = args.read::<[f32; 4]>(3);
    let vertices = args.read::<Vertex>(4);
    let iso = args.read::<f32>(5);
    let position = args.write::<[f32; 4]>(6);
    let anchor = args.write::<[f32; 4]>(7);
    let gradient = args.write::<[f32; 4]>(8);
    let status = args.write::<u32>(9);
    let live_set = args.write::<u32>(10);
    let direction = args.read::<[f32; 4]>(11);
    let rotation = args.read::<[f32; 4]>(12);
    let contact_set = args.write::<u32>(13);
    let ranks = args.read::<u32>(14);
    let field = Composite::new(args, 15);
    let done: Vec<March> = listed
        .par_iter()
        .map(|&v| {
            let v = v as usize;
            let begin = March {
                x: Vec3::from_slice(&start[v]),
                anchor: Vec4::from_array(anchor[v]),
                gradient: Vec4::from_array(gradient[v]),
                status: status[v],
                expected: rotate(
                    Vec4::from_array(rotation[v]),
                    Vec3::from_slice(&direction[v]),
                ),
            };
            let radius = vertices[v].radius * field.scale();
            march(
                begin,
                iso[v],
                radius,
                Vec3::from_slice(&geometric[v]),
                &c,
                &field,
            )
        })
        .collect();
    for (&v, m) in listed.iter().zip(&done) {
        let v = v as usize;
        position[v] = m.x.extend(m.gradient.w).to_array();
        anchor[v] = m.anchor.to_array();
        gradient[v] = m.gradient.to_array();
        status[v] = m.status;
        match state::of(m.status) {
            state::LIVE => set::enter(live_set, ranks[v]),
            state::CONTACT if c.flags & HOLD == 0 => set::enter(contact_set, ranks[v]),
            _ => {}
        }
    }
}

/// Newton steps of one vertex until it settles, meets a discontinuity or has used up this call's steps.
fn march(
    begin: March,
    iso: f32,
    radius: f32,
    home: Vec3,
    c: &Constants,
    field: &Composite<'_>,
) -> March {
    let mut m = begin;
    let mut evaluations = state::evaluations(m.status);
    let mut fetches = state::fetches(m.status);
    let mut strayed = m.status & state::STRAYED != 0;
    let mut known = c.flags & FRESH == 0;
    let hold = c.flags & HOLD != 0;
    let held = hold && state::of(m.status) == state::CONTACT;
    let mut allowed = if known { RELAXED_PIT } else { PIT };
    let mut now = state::LIVE;
    for s in 0..c.evaluations {
        let (f, g) = field.evaluate(m.x, &mut fetches);
        evaluations += 1;
        let off = (f - iso).abs();
        let steep = g.length();
        let before = m.gradient.truncate();
        let turned = g.dot(before) < c.cos_contact * steep * before.length();
        if known && (turned || off > m.anchor.w + allowed) {
            now = state::CONTACT;
            m.x = if hold { m.anchor.truncate() } else { m.x };
            break;
        }
        m.anchor = m.x.extend(off);
        m.gradient = g.extend(f);
        known = true;
        allowed = PIT;
        strayed |= off > DEEP && g.dot(m.expected).abs() < SIDEWAYS * steep;
        if held {
            now = state::CONTACT;
        } else if off < c.tolerance && (strayed || g.dot(m.expected) < 0.0) {
            now = state::CONTACT;
            m.x = if hold { begin.x } else { home };
            m.anchor = m.x.extend(m.anchor.w);
        } else if off < c.tolerance {
            now = state::ON_ISO;
        } else if steep * radius < FLAT {
            now = state::OUTSIDE;
        } else if s < c.steps {
            m.x += shorten(c.sigma * (iso - f) / (steep * steep) * g, LEAP * radius);
            m.x = home + shorten(m.x - home, radius);
        } else {
            now = state::LIMIT;
        }
        if now != state::LIVE {
            break;
        }
    }
    m.status = now | evaluations.min(255) << 8 | fetches.min(0x7fff) << 16;
    m.status |= if strayed { state::STRAYED } else { 0 };
    m
}
