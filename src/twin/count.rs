//! Twin of `shaders/count.comp`.

use super::{Args, shared::list};
use crate::pass::count::Constants;

/// Counts matches a workgroup of 64.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let flags = args.read::<u32>(2);
    let group_count = args.write::<u32>(3);
    for (group, chunk) in listed.chunks(64).enumerate() {
        let matches = chunk
            .iter()
            .filter(|&&v| flags[v as usize] & 0xff == c.wanted);
        group_count[group] = matches.count() as u32;
    }
}
