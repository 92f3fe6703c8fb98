//! Twin of `shaders/mark.comp`.

use super::{Args, shared::list};
use crate::pass::mark::Constants;

/// Marks the neighbourhood of every listed vertex.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let (offsets, neighbourhood) = (args.read::<u32>(2), args.read::<u32>(3));
    let region = args.write::<u32>(4);
    for &v in listed {
        for &n in list::row(offsets, neighbourhood, v) {
            region[n as usize] |= 1;
        }
    }
}
