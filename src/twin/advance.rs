//! Twin of `shaders/advance.comp`.

use glam::Vec3;

use super::{
    Args,
    shared::{carry::carry, field::Boxes, motion::Motions, relaxation::at, set},
};
use crate::{
    layout::{Dispatch, JointPose, Vertex},
    pass::advance::{Constants, NO_ROW},
};

/// Carries every vertex on and enters those that are awake.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let tracked = args.read::<[f32; 4]>(0);
    let (tracked_before, tracked_slopes) = (args.read(1), args.read(2));
    let geometric = args.read(3);
    let vertices = args.read::<Vertex>(4);
    let bodies = args.read::<[f32; 4]>(5);
    let palette = args.read::<JointPose>(8);
    let motions = Motions {
        joints: args.read(6),
        weights: args.read(7),
        palette,
        width: c.width,
    };
    let directions = args.read::<[f32; 4]>(9);
    let [track_a, track_b, track_c] = [10, 11, 12].map(|i| args.write::<[f32; 4]>(i));
    let [slopes_a, slopes_b] = [13, 14].map(|i| args.write::<[f32; 4]>(i));
    let around = args.write::<u32>(15);
    let stirs = args.write::<f32>(16);
    let live_set = args.write::<u32>(17);
    let heads = args.read::<Dispatch>(18);
    let boxes = Boxes::new(args, 19);
    let carried_on = match c.redo {
        NO_ROW => boxes.is_carried(),
        row => heads[row as usize].count > 0,
    };
    if !carried_on {
        return;
    }
    for v in 0..c.vertices as usize {
        let row = v as u32;
        let [_, radius, freedom, rank] = bodies[v];
        let joint = &palette[vertices[v].part as usize];
        let moved = tracked[v][3];
        let carried = if freedom > 0.0 {
            carry(&joint.change, at(tracked, row).extend(1.0))
        } else {
            carry(&joint.rows, Vec3::from(vertices[v].position).extend(1.0))
        };
        let home = at(geometric, row);
        let [motion, since_rest] = motions.of(v);
        let at_home = boxes.moved_as(since_rest, home) == directions[v][3] as u32;
        let x = if at_home || rank < 0.0 { home } else { carried };
        let count = boxes.moving_as(motion, x);
        let still = count != 0 && count == around[v] && moved <= c.stillness;
        let before = if at_home {
            x
        } else {
            x - carried + carry(&joint.change, at(tracked_before, row).extend(1.0))
        };
        let slope = carry(&joint.change, at(tracked_slopes, row).extend(0.0));
        around[v] = count;
        let settled = at_home || rank < 0.0;
        let stir = match count {
            _ if settled => 1.0,
            0 => {
                let radius = radius * boxes.scale();
                let moved = |joint: u32| {
                    carry(
                        &palette[joint as usize].change,
                        at(tracked, row).extend(1.0),
                    )
                };
                boxes.stir(x, radius, moved) / radius
            }
            _ => 0.0,
        };
        stirs[2 * v] = stir;
        stirs[2 * v + 1] += stir;
        track_a[v] = x.extend(moved).to_array();
        track_b[v] = track_a[v];
        track_c[v] = before.extend(0.0).to_array();
        slopes_a[v] = slope.extend(0.0).to_array();
        slopes_b[v] = slopes_a[v];
        if rank >= 0.0 && !at_home && !still {
            set::enter(live_set, rank as u32);
        }
    }
}
