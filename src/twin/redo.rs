//! Twin of `shaders/redo.comp`.

use super::Args;
use crate::{layout::Dispatch, pass::redo::Constants};

/// Writes the head of the halves.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let faults = args.read::<u32>(0)[0];
    let redo = &mut args.write::<Dispatch>(1)[c.redo as usize];
    let again = faults > redo.count + c.allowed;
    redo.groups[0] = if again { c.vertices.div_ceil(64) } else { 0 };
}
