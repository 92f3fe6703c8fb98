//! Twin of `shaders/compact.comp`.

use super::Args;
use crate::{layout::Dispatch, pass::compact::Constants};

/// Copies matching vertices in order and writes the new list's head, unless the list is empty.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let list = args.read::<u32>(0);
    let heads = args.write::<Dispatch>(1);
    let flags = args.read::<u32>(2);
    let kept = args.write::<u32>(4);
    let listed = &list[..heads[c.dispatch as usize].count as usize];
    let mut count = 0;
    for &v in listed
        .iter()
        .filter(|&&v| flags[v as usize] & 0xff == c.wanted)
    {
        kept[count] = v;
        count += 1;
    }
    if !listed.is_empty() {
        heads[c.result as usize] = Dispatch::of(count);
    }
}
