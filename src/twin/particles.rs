//! Twin of `shaders/particles.comp`.

use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

use super::{
    Args,
    shared::solid::{FAR, ball_of, enter, nearest, way_of, way_out},
};
use crate::{
    layout::particles::Primitive,
    pass::particles::{Constants, SLIDE, TOUCH},
};

/// Moves all particles by a frame.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let solids = &args.read::<Primitive>(0)[..c.solids as usize];
    let positions = args.write::<[f32; 4]>(1);
    let velocities = args.write::<[f32; 4]>(2);
    let world = World { c, solids };
    let rows = positions.par_iter_mut().zip(velocities);
    rows.take(c.count as usize)
        .for_each(|(position, velocity)| world.advance(position, velocity));
}

struct World<'a> {
    c: Constants,
    solids: &'a [Primitive],
}

struct Contact<'a> {
    solid: Option<&'a Primitive>,
    time: f32,
    carried: Vec3,
}

impl<'a> World<'a> {
    fn touch(&self, p: Vec3, radius: f32) -> f32 {
        TOUCH * (self.c.size + radius + p.abs().max_element())
    }

    /// A sphere may meet it between `p` and the share `best` of `flight`.
    fn near(solid: &Primitive, p: Vec3, flight: Vec3, radius: f32, best: f32) -> bool {
        let square = flight.dot(flight).max(1e-30);
        let bound = Vec4::from(solid.bound);
        let reach = bound.w + radius;
        let mut from = bound.xyz() - p;
        from -= flight * (from.dot(flight) / square).clamp(0.0, best);
        from.dot(from) <= reach * reach
    }

    fn meet(&self, p: Vec3, flight: Vec3, radius: f32, left: f32) -> Contact<'a> {
        let mut contact = Contact {
            solid: None,
            time: 1.0,
            carried: Vec3::ZERO,
        };
        let (slack, mut deepest) = (self.touch(p, radius), FAR);
        for solid in self.solids {
            if !Self::near(solid, p, flight, radius, contact.time) {
                continue;
            }
            let mut carried = Vec3::ZERO;
            for _ in 0..self.c.carries {
                carried = left * way_of(solid, nearest(solid, p + carried));
            }
            let (start, way) = (p + carried, flight - carried);
            let (centre, ball) = ball_of(solid, nearest(solid, start));
            let from = start - centre;
            let (away, far) = (from.length() - ball - radius, way.length());
            if away <= slack {
                let inwards = -way.dot(way_out(solid, from));
                let enters = inwards > (SLIDE * far).clamp(0.0, (slack + away).max(0.0));
                if enters && ball + radius > slack && away < deepest {
                    deepest = away;
                    contact = Contact {
                        solid: Some(solid),
                        time: 0.0,
                        carried,
                    };
                }
            } else if far > 0.0 {
                let time = enter(solid, start, way / far, radius) / far;
                if time >= 0.0 && time <= contact.time {
                    contact = Contact {
                        solid: Some(solid),
                        time,
                        carried,
                    };
                }
            }
        }
        contact
    }

    fn bounce(&self, normal: Vec3, seconds: f32, velocity: &mut Vec3, pull: &mut Vec3) {
        let (before, press) = (velocity.dot(normal), (-pull.dot(normal)).max(0.0));
        let slide = *velocity - before * normal;
        let mut after = -self.c.restitution * before.min(0.0);
        let mut given = after - before.min(0.0);
        if 2.0 * after <= press * seconds {
            given += press * seconds - after;
            after = 0.0;
            *pull += press * normal;
        }
        let slip = slide.length();
        let kept = if slip > 0.0 {
            (1.0 - self.c.friction * given / slip).max(0.0)
        } else {
            0.0
        };
        *velocity = slide * kept + after * normal;
    }

    fn holding(&self, p: Vec3, radius: f32) -> Option<&'a Primitive> {
        let mut deepest = -self.touch(p, radius);
        let mut found = None;
        for solid in self.solids {
            if !Self::near(solid, p, Vec3::ZERO, radius, 0.0) {
                continue;
            }
            let (centre, ball) = ball_of(solid, nearest(solid, p));
            let away = (p - centre).length() - ball - radius;
            if away < deepest {
                (deepest, found) = (away, Some(solid));
            }
        }
        found
    }

    fn advance(&self, position: &mut [f32; 4], velocity: &mut [f32; 4]) {
        let c = &self.c;
        let (mut p, radius) = (Vec4::from(*position).xyz(), position[3]);
        let (mut v, mut contacts) = (Vec4::from(*velocity).xyz(), velocity[3]);
        let (mut pull, mut left, mut resting) = (Vec3::from(c.gravity), 1.0, p);
        for _ in 0..c.contacts {
            if left <= 0.0 {
                break;
            }
            let seconds = left * c.seconds;
            let flight = (v + 0.5 * seconds * pull) * seconds;
            let contact = self.meet(p, flight, radius, left);
            v += contact.time * seconds * pull;
            let Some(solid) = contact.solid else {
                p += flight;
                left = 0.0;
                continue;
            };
            let spot = p + contact.carried + contact.time * (flight - contact.carried);
            let share = nearest(solid, spot);
            let (centre, ball) = ball_of(solid, share);
            let mut normal = way_out(solid, spot - centre);
            let thin = ball + radius <= self.touch(spot, radius);
            if thin && normal.dot(flight - contact.carried) > 0.0 {
                normal = -normal;
            }
            resting = centre + (ball + radius) * normal;
            p = resting - (1.0 - contact.time) * contact.carried;
            left *= 1.0 - contact.time;
            let surface = way_of(solid, share) / c.seconds;
            v -= surface;
            self.bounce(normal, left * c.seconds, &mut v, &mut pull);
            v += surface;
            contacts += 1.0;
        }
        if left > 0.0 {
            p = resting;
        }
        if let Some(held) = self.holding(p, radius) {
            self.push(held, radius, &mut p, &mut v);
            contacts += 1.0;
        }
        *position = p.extend(radius).to_array();
        *velocity = v.extend(contacts).to_array();
    }

    /// Out of everything along the normal of the solid that holds it deepest.
    fn push(&self, deepest: &'a Primitive, radius: f32, p: &mut Vec3, v: &mut Vec3) {
        let (centre, _) = ball_of(deepest, nearest(deepest, *p));
        let (direction, start) = (way_out(deepest, *p - centre), *p);
        let (mut held, mut last, mut way) = (Some(deepest), deepest, 0f32);
        for _ in 0..=self.solids.len() {
            let Some(solid) = held else { break };
            let bound = Vec4::from(solid.bound);
            let beyond = (bound.xyz() - start).dot(direction) + 2.0 * (bound.w + radius);
            let end = enter(solid, start + beyond * direction, -direction, radius);
            way = way.max(beyond - end);
            *p = start + way * direction;
            last = solid;
            held = self.holding(*p, radius);
        }
        let share = nearest(last, *p);
        let (centre, _) = ball_of(last, share);
        let normal = way_out(last, *p - centre);
        let surface = way_of(last, share) / self.c.seconds;
        let inwards = (*v - surface).dot(normal).min(0.0);
        *v -= (1.0 + self.c.restitution) * inwards * normal;
    }
}
