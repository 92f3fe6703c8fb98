//! Twin of `shaders/smooth.comp`.

use glam::Vec3;

use super::{Args, shared::list};
use crate::pass::smooth::Constants;

/// One smoothing step over the listed vertices.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let (offsets, ring) = (args.read::<u32>(2), args.read::<u32>(3));
    let beta = args.read::<f32>(4);
    let start = args.read::<[f32; 4]>(5);
    let smoothed = args.write::<[f32; 4]>(6);
    for &v in listed {
        let row = list::row(offsets, ring, v);
        let v = v as usize;
        let mut x = Vec3::from_slice(&start[v]);
        let sum: Vec3 = row
            .iter()
            .map(|&n| Vec3::from_slice(&start[n as usize]))
            .sum();
        if row.len() > 3 {
            x = x * (1.0 - beta[v]) + sum / row.len() as f32 * beta[v];
        }
        smoothed[v] = x.extend(start[v][3]).to_array();
    }
}
