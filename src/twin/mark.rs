//! Twin of `shaders/mark.comp`.

use super::{
    Args,
    shared::{list, set},
};
use crate::{layout::NO_SEED, pass::mark::Constants};

/// Enters the seeds in the neighbourhood of every listed vertex.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let (offsets, neighbourhood) = (args.read::<u32>(2), args.read::<u32>(3));
    let ranks = args.read::<u32>(4);
    let region_set = args.write::<u32>(5);
    for &v in listed {
        for &n in list::row(offsets, neighbourhood, v) {
            let seed = ranks[n as usize];
            if seed != NO_SEED {
                set::enter(region_set, seed);
            }
        }
    }
}
