//! Twin of `shaders/goals.comp`.

use glam::{Vec3, Vec4};

use super::{
    Args,
    shared::{
        list,
        pace::pace_of,
        rotation::{half_way, rotate},
    },
};
use crate::{
    layout::{FieldsHead, Vertex},
    pass::goals::Constants,
};

/// Sums the turned edges at rest of every vertex.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let offsets = args.read::<u32>(0);
    let (rings, weights) = (args.read::<u32>(1), args.read::<f32>(2));
    let vertices = args.read::<Vertex>(3);
    let rotations = args.read::<[f32; 4]>(4);
    let scale = args.read::<FieldsHead>(5)[0].box_scale[3];
    let geometric = args.read::<[f32; 4]>(6);
    let stirs = args.read::<f32>(7);
    let goals = args.write::<[f32; 4]>(8);
    let rest = |v: usize| Vec3::from(vertices[v].position);
    let turn = |v: usize| Vec4::from_array(rotations[v]);
    for (v, to) in goals.iter_mut().enumerate().take(c.vertices as usize) {
        let (mut goal, mut tie) = (Vec3::ZERO, 1.0);
        for k in list::range(offsets, v as u32) {
            let j = rings[k] as usize;
            let edge = rest(v) - rest(j);
            tie -= weights[k];
            goal += weights[k] * rotate(half_way(turn(v), turn(j)), edge);
        }
        let tied = tie * Vec3::from_slice(&geometric[v]);
        *to = (scale * goal + tied)
            .extend(pace_of(stirs[2 * v]))
            .to_array();
    }
}
