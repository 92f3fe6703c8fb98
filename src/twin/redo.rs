//! Twin of `shaders/redo.comp`.

use super::Args;
use crate::{layout::Dispatch, pass::redo::Constants};

/// Writes the head of the halves.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let faults = args.read::<u32>(0)[0];
    let at_rest = args.read::<Dispatch>(1)[c.redo as usize].count;
    let redo = &mut args.write::<Dispatch>(2)[c.redo as usize];
    let again = faults > at_rest + c.allowed;
    redo.count = if again { c.vertices } else { 0 };
    if again {
        redo.groups[0] = redo.groups[0].max(c.vertices.div_ceil(64));
    }
}
