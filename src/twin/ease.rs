//! Twin of `shaders/ease.comp`.

use glam::Vec4;

use super::{
    Args,
    shared::{
        field::{Composite, IN_CONTACT},
        list,
        newton::newton,
        pace::easing_of,
        relaxation::at,
        rotation::rotate,
    },
};
use crate::{
    layout::{JointPose, Vertex, state},
    pass::ease::Constants,
};

/// Way over the radius on which the field does not change to speak of.
const NEAR: f32 = 5e-4;
/// Longest step back to the iso-value, over the radius.
const NUDGE: f32 = 7e-3;

/// Eases the listed vertices to where they settled.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let tracked = args.read::<[f32; 4]>(2);
    let stirs = args.read::<f32>(3);
    let bodies = args.read::<[f32; 4]>(4);
    let vertices = args.read::<Vertex>(5);
    let palette = args.read::<JointPose>(6);
    let corrections = args.write::<[f32; 4]>(7);
    let position = args.write::<[f32; 4]>(8);
    let status = args.write::<u32>(9);
    let field = Composite::new(args, 10);
    for &row in listed {
        let v = row as usize;
        let [iso, radius, ..] = bodies[v];
        let radius = radius * field.scale();
        let turn = Vec4::from_array(palette[vertices[v].part as usize].real);
        let start = at(tracked, row);
        let end = at(position, row);
        let (wanted, last) = (end - start, rotate(turn, at(corrections, row)));
        let easing = easing_of(stirs[2 * v + 1], field.turn());
        let eased = easing < 1.0;
        let correction = if eased {
            last.lerp(wanted, easing)
        } else {
            wanted
        };
        let back = (-turn.truncate()).extend(turn.w);
        corrections[v] = rotate(back, correction).extend(0.0).to_array();
        let mut place = if eased { start + correction } else { end };
        let mut open = correction.distance(wanted) > NEAR * radius;
        let (onto, mut nudged) = (state::of(status[v]) == state::ON_ISO, false);
        while open {
            let (sampled, sheet) = field.evaluate_sheet(place);
            position[v][3] = sampled.0;
            let off = (sampled.0 - iso).abs() > c.tolerance;
            open = onto && off && !nudged;
            if open {
                place += newton(iso, sampled, 1.0, radius, NUDGE);
            } else if nudged && off {
                let left = if sheet > IN_CONTACT {
                    state::CONTACT
                } else {
                    state::LIMIT
                };
                status[v] = status[v] - state::ON_ISO + left;
            }
            nudged = open;
        }
        position[v][..3].copy_from_slice(&place.to_array());
    }
}
