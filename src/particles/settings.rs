//! How particles fly and bounce.

use glam::Vec3;

use crate::{Error, Result};

/// Settings of particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Acceleration of all particles, units a second squared.
    pub gravity: Vec3,
    /// Share of the normal speed that a bounce leaves, 0 to 1.
    pub restitution: f32,
    /// Coulomb's coefficient of friction, 0 to 1e8.
    pub friction: f32,
    /// Contacts of a particle in a frame, 1 to 64; after the last it stays with the surface that it touches until the frame ends.
    pub contacts: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            gravity: Vec3::new(0.0, -9.81, 0.0),
            restitution: 0.5,
            friction: 0.2,
            contacts: 4,
        }
    }
}

impl Settings {
    /// # Errors
    /// [`Error::Argument`] naming the setting that is out of range.
    pub(super) fn check(&self) -> Result<()> {
        let gravity = self.gravity.abs().max_element();
        let good = [
            (
                "gravity",
                gravity <= super::GREATEST && !self.gravity.is_nan(),
                format!("{}, not finite or beyond 1e8", self.gravity),
            ),
            (
                "restitution",
                (0.0..=1.0).contains(&self.restitution),
                format!("{}, not from 0 to 1", self.restitution),
            ),
            (
                "friction",
                (0.0..=super::GREATEST).contains(&self.friction),
                format!("{}, not from 0 to 1e8", self.friction),
            ),
            (
                "contacts",
                (1..=64).contains(&self.contacts),
                format!("{}, not from 1 to 64", self.contacts),
            ),
        ];
        match good.into_iter().find(|(_, good, _)| !good) {
            Some((name, _, reason)) => Err(Error::argument(name, reason)),
            None => Ok(()),
        }
    }
}
