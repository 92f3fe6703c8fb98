//! Twin of `shaders/relax.comp`.

use glam::Vec3;

use super::{Args, shared::list};
use crate::pass::relax::Constants;

/// Relaxes the listed vertices.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let (offsets, ring) = (args.read::<u32>(2), args.read::<u32>(3));
    let weights = args.read::<f32>(4);
    let position = args.read::<[f32; 4]>(5);
    let anchor = args.read::<[f32; 4]>(6);
    let gradient = args.read::<[f32; 4]>(7);
    let relaxed = args.write::<[f32; 4]>(8);
    for &v in listed {
        let at = list::range(offsets, v);
        let v = v as usize;
        let x = Vec3::from_slice(&position[v]);
        let (mut goal, mut sum) = (Vec3::ZERO, 0.0);
        for k in at {
            goal += weights[k] * Vec3::from_slice(&position[ring[k] as usize]);
            sum += weights[k];
        }
        let mut step = goal - sum * x;
        let g = Vec3::from_slice(&gradient[v]);
        step -= g * (g.dot(step) / g.dot(g).max(1e-20));
        let rest = anchor[v][3] - 1.0;
        let mu = (1.0 - rest * rest * rest * rest).max(0.0);
        relaxed[v] = (x + mu * step).extend(0.0).to_array();
    }
}
