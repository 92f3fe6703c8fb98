//! Twin of `shaders/diffuse.comp`.

use super::{Args, shared::list};
use crate::{layout::state, pass::diffuse::Constants};

/// One diffusion step over the listed vertices.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let (offsets, ring) = (args.read::<u32>(2), args.read::<u32>(3));
    let status = args.read::<u32>(4);
    let beta = args.read::<f32>(5);
    let diffused = args.write::<f32>(6);
    let beta_of = |v: u32| {
        let v = v as usize;
        if c.first != 0 {
            f32::from(u8::from(state::of(status[v]) == state::CONTACT))
        } else {
            beta[v]
        }
    };
    for &v in listed {
        let row = list::row(offsets, ring, v);
        let sum = row.iter().fold(beta_of(v), |sum, &n| sum + beta_of(n));
        diffused[v as usize] = sum / (row.len() + 1) as f32;
    }
}
