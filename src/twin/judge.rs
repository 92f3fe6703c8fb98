//! Twin of `shaders/judge.comp`.

use super::{
    Args,
    shared::{carry::carry, list, relaxation::at},
};
use crate::{
    layout::{FieldsHead, JointPose, Vertex},
    pass::judge::Constants,
};

const ON: f32 = 5e-3;
const CLEAR: f32 = 0.3;
const INVERTED: f32 = 0.5;
const FAR: f32 = 0.5;

/// Counts the faults of the listed vertices.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let offsets = args.read::<u32>(2);
    let corners = args.read::<u32>(3);
    let bodies = args.read::<[f32; 4]>(4);
    let tracks = args.read::<[f32; 4]>(5);
    let slopes = args.read::<[f32; 4]>(6);
    let head = args.read::<FieldsHead>(7)[0];
    let tracked = args.read::<[f32; 4]>(8);
    let vertices = args.read::<Vertex>(9);
    let palette = args.read::<JointPose>(10);
    let faults = args.write::<u32>(11);
    if head.turn[2] == 0.0 {
        return;
    }
    let scale = head.box_scale[3];
    for &v in listed {
        let [iso, radius, ..] = bodies[v as usize];
        let (slope, x) = (at(slopes, v), at(tracks, v));
        let steep = slope.length();
        let inverted = corners[list::range(offsets, v)].chunks_exact(2).any(|c| {
            let n = (at(tracks, c[0]) - x).cross(at(tracks, c[1]) - x);
            n.dot(slope) > INVERTED * n.length() * steep
        });
        let on = (slopes[v as usize][3] - iso).abs() < ON;
        let radius = radius * scale;
        let joint = &palette[vertices[v as usize].part as usize];
        let carried = carry(&joint.change, at(tracked, v).extend(1.0));
        let far = x.distance(carried) > FAR * radius;
        if far || inverted && on && steep * radius > CLEAR {
            faults[0] += 1;
        }
    }
}
