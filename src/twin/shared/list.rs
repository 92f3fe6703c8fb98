//! Work lists and one-rings as the passes read them.

use crate::{layout::Dispatch, twin::Args};

/// The listed items of a pass whose first two bindings are list and heads.
pub fn items<'a>(args: &Args<'a>, dispatch: u32) -> &'a [u32] {
    let heads = args.read::<Dispatch>(1);
    &args.read::<u32>(0)[..heads[dispatch as usize].count as usize]
}

/// Row `v` of a CSR pair of buffers.
pub fn row<'a>(offsets: &[u32], items: &'a [u32], v: u32) -> &'a [u32] {
    &items[range(offsets, v)]
}

/// Range of row `v`.
pub fn range(offsets: &[u32], v: u32) -> std::ops::Range<usize> {
    offsets[v as usize] as usize..offsets[v as usize + 1] as usize
}
