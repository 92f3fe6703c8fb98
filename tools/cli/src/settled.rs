//! How well a frame's vertices ended: on their iso-values, in contact, or not.

use std::ops::AddAssign;

use dermis::deformer::Skin;
use serde::Serialize;

/// Largest |f − iso| of a vertex that counts as settled.
const TOLERANCE: f32 = 1e-3;

/// Vertex counts of a frame, or of many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Settled {
    /// All rows of the file.
    pub(crate) vertices: usize,
    /// Rows that lie inside some field.
    pub(crate) inside: usize,
    /// Of those, rows with |f − iso| ≤ 1e-3 or in contact.
    pub(crate) settled: usize,
    /// Rows that stopped in contact.
    pub(crate) contact: usize,
    /// Rows that ran into the iteration limit or, in tracking, are on their way.
    pub(crate) iteration_limit: usize,
    /// Rows past the limit of their spine's map.
    pub(crate) past_limit: usize,
}

impl Settled {
    pub(crate) fn of(skin: &Skin) -> Self {
        let mut all = Self {
            vertices: skin.positions.len(),
            ..Self::default()
        };
        for ((&state, &field), &iso) in skin.state.iter().zip(&skin.field).zip(&skin.iso) {
            let contact = state == state::CONTACT;
            if ![state::OUTSIDE, state::UNTOUCHED, state::PAST_LIMIT].contains(&state) {
                all.inside += 1;
                all.settled += usize::from(contact || (field - iso).abs() <= TOLERANCE);
            }
            all.contact += usize::from(contact);
            all.iteration_limit += usize::from(state == state::ITERATION_LIMIT);
            all.past_limit += usize::from(state == state::PAST_LIMIT);
        }
        all
    }

    /// Settled share of the rows inside a field; `None` where no row is.
    pub(crate) fn share(&self) -> Option<f64> {
        (self.inside > 0).then(|| self.settled as f64 / self.inside as f64)
    }
}

/// The values of `state` in a baked file.
mod state {
    pub(super) const UNTOUCHED: u8 = 0;
    pub(super) const CONTACT: u8 = 2;
    pub(super) const OUTSIDE: u8 = 3;
    pub(super) const ITERATION_LIMIT: u8 = 4;
    pub(super) const PAST_LIMIT: u8 = 5;
}

impl AddAssign for Settled {
    fn add_assign(&mut self, other: Self) {
        self.vertices += other.vertices;
        self.inside += other.inside;
        self.settled += other.settled;
        self.contact += other.contact;
        self.iteration_limit += other.iteration_limit;
        self.past_limit += other.past_limit;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contact_and_small_errors_settle_and_vertices_outside_do_not_count() {
        let skin = Skin {
            positions: vec![glam::Vec3::ZERO; 6],
            field: vec![0.5, 0.5, 0.9, 0.0, 0.6, 0.0],
            iso: vec![0.5, 0.5005, 0.5, 0.5, 0.5, 0.0],
            state: vec![0, 1, 2, 3, 4, 5],
            ..Skin::default()
        };
        let settled = Settled::of(&skin);
        let expected = Settled {
            vertices: 6,
            inside: 3,
            settled: 2,
            contact: 1,
            iteration_limit: 1,
            past_limit: 1,
        };
        assert_eq!(settled, expected);
        assert_eq!(settled.share(), Some(2.0 / 3.0));
        assert_eq!(Settled::default().share(), None);
    }
}
