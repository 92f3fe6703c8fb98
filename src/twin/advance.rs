//! Twin of `shaders/advance.comp`.

use glam::{Vec3, Vec4};

use super::{
    Args,
    shared::{field::Boxes, motion::Motions, relaxation::at, set},
};
use crate::{
    layout::{JointPose, Vertex},
    pass::advance::Constants,
};

/// Carries every vertex on and enters those that are awake.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let tracked = args.read::<[f32; 4]>(0);
    let (tracked_before, tracked_slopes) = (args.read(1), args.read(2));
    let geometric = args.read::<[f32; 4]>(3);
    let vertices = args.read::<Vertex>(4);
    let bodies = args.read::<[f32; 4]>(5);
    let palette = args.read::<JointPose>(8);
    let motions = Motions {
        joints: args.read(6),
        weights: args.read(7),
        palette,
        width: c.width,
    };
    let [track_a, track_b, track_c] = [9, 10, 11].map(|i| args.write::<[f32; 4]>(i));
    let [slopes_a, slopes_b] = [12, 13].map(|i| args.write::<[f32; 4]>(i));
    let around = args.write::<u32>(14);
    let live_set = args.write::<u32>(15);
    let boxes = Boxes::new(args, 16);
    for v in 0..c.vertices as usize {
        let [_, _, freedom, rank] = bodies[v];
        let joint = &palette[vertices[v].part as usize];
        let x = if rank < 0.0 {
            Vec3::from_slice(&geometric[v])
        } else if freedom > 0.0 {
            carry(&joint.change, at(tracked, v as u32).extend(1.0))
        } else {
            carry(&joint.rows, Vec3::from(vertices[v].position).extend(1.0))
        };
        let moved = tracked[v][3];
        let count = boxes.moving_as(motions.of(v), x);
        let asleep = count != 0 && count == around[v] && moved <= c.stillness;
        around[v] = count;
        track_a[v] = x.extend(moved).to_array();
        track_b[v] = track_a[v];
        let before = carry(&joint.change, at(tracked_before, v as u32).extend(1.0));
        track_c[v] = before.extend(0.0).to_array();
        let slope = carry(&joint.change, at(tracked_slopes, v as u32).extend(0.0));
        slopes_a[v] = slope.extend(0.0).to_array();
        slopes_b[v] = slopes_a[v];
        if rank >= 0.0 && !asleep {
            set::enter(live_set, rank as u32);
        }
    }
}

/// A point (w = 1) or a direction (w = 0) carried by three rows of a matrix.
fn carry(rows: &[[f32; 4]; 3], x: Vec4) -> Vec3 {
    Vec3::from_array(rows.map(|r| Vec4::from_array(r).dot(x)))
}
