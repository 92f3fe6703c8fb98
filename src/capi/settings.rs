//! Settings of a deformer.

use super::{
    guard::{Fault, Outcome, dm_result, guard},
    pointer::{self, structs},
};
use crate::deformer::{Method, Settings};

/// Method: linear blend skinning.
pub const DM_LBS: u32 = 0;
/// Method: dual-quaternion skinning.
pub const DM_DQS: u32 = 1;
/// Method: implicit skinning (Vaillant et al. 2013), the default.
pub const DM_IMPLICIT: u32 = 2;
/// Method: iso-surface tracking (Vaillant et al. 2014), from the skin of the pose before.
pub const DM_TRACKING: u32 = 3;

/// How a deformer works. Fill it by dm_settings_default and change what is to differ: zeros are no defaults.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_settings {
    /// sizeof(dm_settings).
    pub size: u32,
    /// DM_LBS, DM_DQS, DM_IMPLICIT or DM_TRACKING.
    pub method: u32,
    /// Share of the distance to the iso-value that a Newton step goes, above 0 to 1.
    pub sigma: f32,
    /// Distance to the iso-value that counts as settled, in field values.
    pub tolerance: f32,
    /// Angle between successive gradients that counts as a contact, degrees.
    pub contact_degrees: f32,
    /// Newton steps before each relaxation, 1 to 64.
    pub steps: u32,
    /// Rounds of Newton steps and relaxation, 1 to 256.
    pub rounds: u32,
    /// Steps of the diffusion of contacts, 1 to 64.
    pub diffusions: u32,
    /// Smoothing steps at contacts, odd, less than 64.
    pub smoothings: u32,
    /// Newton steps of the last round and after the smoothing, 1 to 250.
    pub settling_steps: u32,
    /// Tracking: iterations of a sub-step in which a joint turns by full_turn_degrees, least_iterations to 600.
    pub iterations: u32,
    /// Tracking: least iterations of a sub-step, 1 or more.
    pub least_iterations: u32,
    /// Tracking: turn of a joint that takes all iterations, degrees.
    pub full_turn_degrees: f32,
    /// Tracking: movement in an iteration that counts as rest, over the radius of the vertex's part.
    pub stillness: f32,
    /// Tracking: share of a vertex's goal that is where its joints carry it, 0 to 1.
    pub tie: f32,
    /// Tracking: the same for open components and shells on a single part, 0 to 1.
    pub loose_tie: f32,
    /// Tracking: spectral radius that Chebyshev's semi-iteration assumes, 0 (plain Jacobi) to less than 1.
    pub spectral_radius: f32,
    /// Tracking: most degrees that a joint turns in a sub-step.
    pub substep_degrees: f32,
    /// Tracking: bends below this count as this, degrees.
    pub least_bend_degrees: f32,
    /// Tracking: most sub-steps a frame, 1 to 64.
    pub max_substeps: u32,
    /// Tracking: sub-steps that turn further are looked over for faults and halved where they have any, degrees.
    pub halving_degrees: f32,
    /// Tracking: faults more than at rest that do not matter.
    pub allowed_faults: u32,
    /// Instances of the rig, 1 (or 0) to 65535: they share its fields, have a pose each, and are deformed together.
    pub instances: u32,
}

structs!(dm_settings since instances);

const METHODS: [(u32, Method); 4] = [
    (DM_LBS, Method::Lbs),
    (DM_DQS, Method::Dqs),
    (DM_IMPLICIT, Method::Implicit),
    (DM_TRACKING, Method::Tracking),
];

impl dm_settings {
    fn new(s: &Settings) -> Self {
        let method = METHODS.iter().find(|(_, method)| *method == s.method);
        Self {
            size: size_of::<Self>() as u32,
            method: method.map_or(DM_IMPLICIT, |(number, _)| *number),
            sigma: s.sigma,
            tolerance: s.tolerance,
            contact_degrees: s.contact_degrees,
            steps: s.steps,
            rounds: s.rounds,
            diffusions: s.diffusions,
            smoothings: s.smoothings,
            settling_steps: s.settling_steps,
            iterations: s.iterations,
            least_iterations: s.least_iterations,
            full_turn_degrees: s.full_turn_degrees,
            stillness: s.stillness,
            tie: s.tie,
            loose_tie: s.loose_tie,
            spectral_radius: s.spectral_radius,
            substep_degrees: s.substep_degrees,
            least_bend_degrees: s.least_bend_degrees,
            max_substeps: s.max_substeps,
            halving_degrees: s.halving_degrees,
            allowed_faults: s.allowed_faults,
            instances: s.instances,
        }
    }

    /// The same in Rust; ranges are checked where a deformer is made.
    fn settings(&self) -> Outcome<Settings> {
        let method = METHODS.iter().find(|(number, _)| *number == self.method);
        let Some((_, method)) = method else {
            let reason = format!("{} is unknown", self.method);
            return Err(Fault::argument("settings.method", reason));
        };
        Ok(Settings {
            method: *method,
            instances: self.instances.max(1),
            sigma: self.sigma,
            tolerance: self.tolerance,
            contact_degrees: self.contact_degrees,
            steps: self.steps,
            rounds: self.rounds,
            diffusions: self.diffusions,
            smoothings: self.smoothings,
            settling_steps: self.settling_steps,
            iterations: self.iterations,
            least_iterations: self.least_iterations,
            full_turn_degrees: self.full_turn_degrees,
            stillness: self.stillness,
            tie: self.tie,
            loose_tie: self.loose_tie,
            spectral_radius: self.spectral_radius,
            substep_degrees: self.substep_degrees,
            least_bend_degrees: self.least_bend_degrees,
            max_substeps: self.max_substeps,
            halving_degrees: self.halving_degrees,
            allowed_faults: self.allowed_faults,
        })
    }

    /// Settings of the caller, the defaults for NULL.
    ///
    /// # Safety
    /// `pointer` is NULL or valid.
    pub(super) unsafe fn read(pointer: *const Self) -> Outcome<Settings> {
        if pointer.is_null() {
            return Ok(Settings::default());
        }
        // SAFETY: the caller's promise.
        unsafe { pointer::read(pointer, "settings") }?.settings()
    }
}

/// Fills settings with the defaults, those that NULL in their place has: the papers', or what measured best.
///
/// out: size set by the caller, the rest is filled.
///
/// Threads: any. Returns DM_OK, DM_ERROR_NULL or DM_ERROR_STRUCT_SIZE.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_settings_default(out: *mut dm_settings) -> dm_result {
    guard("dm_settings_default", || {
        // SAFETY: the caller's promise.
        unsafe { pointer::fill(out, &dm_settings::new(&Settings::default()), "out") }
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn settings_go_to_c_and_back() {
        for (_, method) in METHODS {
            let settings = Settings {
                method,
                ..Settings::default()
            };
            assert_eq!(dm_settings::new(&settings).settings().unwrap(), settings);
        }
        let mut several = dm_settings::new(&Settings::default());
        several.instances = 7;
        assert_eq!(several.settings().unwrap().instances, 7);
        let mut unknown = dm_settings::new(&Settings::default());
        unknown.method = 4;
        assert!(unknown.settings().is_err());
    }

    #[test]
    fn settings_of_a_version_without_instances_are_read_and_filled_as_far_as_they_go() {
        let size = std::mem::offset_of!(dm_settings, instances);
        let mut settings = dm_settings::new(&Settings::default());
        settings.size = size as u32;
        (settings.sigma, settings.instances) = (0.5, 7);
        // SAFETY: it is longer than it says.
        let read = unsafe { dm_settings::read(&settings) }.ok().unwrap();
        assert_eq!((read.sigma, read.instances), (0.5, 1));
        // SAFETY: as above.
        let filled = unsafe { dm_settings_default(&mut settings) };
        assert_eq!(filled, dm_result::DM_OK);
        let default = Settings::default();
        assert_eq!(
            (settings.sigma, settings.allowed_faults),
            (default.sigma, default.allowed_faults)
        );
        assert_eq!((settings.size, settings.instances), (size as u32, 7));
    }
}
