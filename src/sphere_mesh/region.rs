//! Regions of the mesh, which collapses unite.

use super::{extent::Extent, quadric::Quadric};

/// A region.
#[derive(Debug)]
pub(super) struct Region<'a> {
    pub(super) quadric: Quadric<'a>,
    /// Nothing for the classic quadric, whose radii are 0.
    pub(super) extent: Option<Extent<'a>>,
}

impl Region<'_> {
    /// Becomes the union of both.
    pub(super) fn merge(&mut self, other: &Self) {
        self.quadric.merge(&other.quadric);
        if let (Some(a), Some(b)) = (&mut self.extent, &other.extent) {
            a.merge(b);
        }
    }
}
