//! What the tests of several modules share.

use glam::DVec3;

/// Numbers from 0 to 1, the same in every run.
pub(crate) struct Chance(pub(crate) u64);

impl Chance {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A point in the cube from -`size` to `size`.
    pub(crate) fn point(&mut self, size: f64) -> DVec3 {
        let mut at = || (2.0 * self.next() - 1.0) * size;
        DVec3::new(at(), at(), at())
    }
}
