//! Twin of `shaders/compact.comp`.

use super::{Args, shared::set};
use crate::{layout::Dispatch, pass::compact::Constants};

/// Lists a set's vertices in the order of the seeds and writes the list's head.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let (seeds, members) = (args.read::<u32>(0), args.read::<u32>(1));
    let heads = args.write::<Dispatch>(2);
    let listed = args.write::<u32>(3);
    let mut count = 0;
    for seed in set::members(members) {
        listed[count] = seeds[seed as usize];
        count += 1;
    }
    heads[c.result as usize] = Dispatch::of(count);
}
