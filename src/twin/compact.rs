//! Twin of `shaders/compact.comp`.

use super::{Args, shared::set};
use crate::{
    layout::{Dispatch, FieldsHead},
    pass::compact::Constants,
};

/// Lists a set's vertices in the order of the seeds, or nothing after the last round, and writes the list's head.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let (seeds, members) = (args.read::<u32>(0), args.read::<u32>(1));
    let heads = args.write::<Dispatch>(2);
    let listed = args.write::<u32>(3);
    let mut count = 0;
    let last_round = args.read::<FieldsHead>(4)[0].turn[0];
    let over = c.round as f32 > last_round;
    for seed in set::members(members).filter(|_| !over) {
        listed[count] = seeds[seed as usize];
        count += 1;
    }
    heads[c.result as usize] = Dispatch::of(count);
}
