//! What a user chooses: method and numbers of the papers.

use serde::{Deserialize, Serialize};

use super::plan::ROUND;
use crate::{Error, Result};

/// How the skin follows the pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Linear blend skinning.
    Lbs,
    /// Dual-quaternion skinning (Kavan et al. 2008).
    Dqs,
    /// Implicit skinning (Vaillant et al. 2013), from dual quaternions.
    #[default]
    Implicit,
    /// Iso-surface tracking (Vaillant et al. 2014), from the skin of the pose before.
    Tracking,
}

impl Method {
    /// The name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lbs => "lbs",
            Self::Dqs => "dqs",
            Self::Implicit => "implicit",
            Self::Tracking => "tracking",
        }
    }

    /// The skin follows implicit fields.
    pub fn has_fields(self) -> bool {
        matches!(self, Self::Implicit | Self::Tracking)
    }
}

/// Settings of a deformer; the defaults are the paper's, or what measured best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Method.
    pub method: Method,
    /// Instances of the rig, 1 to 65,535. They share fields, operators and mesh, have a pose each, and are deformed in one set
    /// of dispatches: the same bits as by deformers of their own.
    pub instances: u32,
    /// σ of Eq. 4: share of the distance to the iso-value that a Newton step goes. The paper has 0.35; with steps clamped
    /// to a tenth of the radius, 0.7 ends on the same surface with half the evaluations.
    pub sigma: f32,
    /// |f − iso| that counts as settled.
    pub tolerance: f32,
    /// Angle between successive gradients that counts as a contact, degrees (section 5).
    pub contact_degrees: f32,
    /// Newton steps before each relaxation.
    pub steps: u32,
    /// Rounds of Newton steps, compaction and relaxation; the last has [`Settings::settling_steps`] and no relaxation.
    pub rounds: u32,
    /// Steps of the diffusion of β.
    pub diffusions: u32,
    /// Laplacian smoothing steps at contacts; odd.
    pub smoothings: u32,
    /// Newton steps of the last round, and after the smoothing.
    pub settling_steps: u32,
    /// Tracking: iterations of a sub-step in which a joint turns by [`Settings::full_turn_degrees`] or more; less far, it has
    /// proportionally fewer. Rounded up to rounds of 6, of which every third evaluates the field.
    pub iterations: u32,
    /// Tracking: least iterations of a sub-step.
    pub least_iterations: u32,
    /// Tracking: turn of a joint that takes all iterations, degrees.
    pub full_turn_degrees: f32,
    /// Tracking: movement in an iteration that counts as rest, over the radius of the vertex's part.
    pub stillness: f32,
    /// Tracking: share of a vertex's goal that is where its joints carry it, not where its neighbours draw it. The paper has
    /// none; this little is not seen, and ends the slow drift of a skin as a whole.
    pub tie: f32,
    /// Tracking: the same for components with open borders and shells on a single part, which nothing holds on the surface
    /// they lie on.
    pub loose_tie: f32,
    /// Tracking: spectral radius of the Jacobi iteration that Chebyshev's semi-iteration assumes; 0 for plain Jacobi.
    pub spectral_radius: f32,
    /// Tracking: most degrees that a joint turns in a sub-step, at any bend; sharply bent joints get a third of their bend
    /// where that is less (section 5.2).
    pub substep_degrees: f32,
    /// Tracking: bends below this count as this, degrees: a third of nothing is nothing.
    pub least_bend_degrees: f32,
    /// Tracking: most sub-steps a frame.
    pub max_substeps: u32,
    /// Tracking: sub-steps in which a joint turns further than this are looked over for faults, inverted triangles outside
    /// contacts, and done again in two halves where they left any; degrees.
    pub halving_degrees: f32,
    /// Tracking: faults more than at rest that do not matter.
    pub allowed_faults: u32,
}

/// Workgroups along y that every device has.
const MAX_INSTANCES: u32 = 65_535;

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::Implicit,
            instances: 1,
            sigma: 0.7,
            tolerance: 1e-4,
            contact_degrees: 55.0,
            steps: 2,
            rounds: 6,
            diffusions: 6,
            smoothings: 7,
            settling_steps: 24,
            iterations: 36,
            least_iterations: 12,
            full_turn_degrees: 9.0,
            stillness: 2e-5,
            tie: 1e-4,
            loose_tie: 0.03,
            spectral_radius: 0.9985,
            substep_degrees: 15.0,
            least_bend_degrees: 30.0,
            max_substeps: 32,
            halving_degrees: 6.0,
            allowed_faults: 2,
        }
    }
}

impl Settings {
    /// Most slices of poses of a frame: in tracking those of sub-steps and of their halves.
    pub(super) fn max_slices(&self) -> u32 {
        match self.method {
            Method::Tracking => 3 * self.max_substeps,
            Method::Lbs | Method::Dqs | Method::Implicit => 1,
        }
    }

    /// Most rounds of a frame of tracking.
    pub(super) fn max_rounds(&self) -> u32 {
        self.max_slices() * self.iterations.div_ceil(ROUND)
    }

    /// Most runs of steps in a row: of a slice its begin, its rounds and its end, of the frame its begin and its end.
    pub(super) fn max_runs(&self) -> usize {
        let rounds = match self.method {
            Method::Tracking => self.max_rounds(),
            Method::Lbs | Method::Dqs | Method::Implicit => 0,
        };
        (2 + 2 * self.max_slices() + rounds) as usize
    }

    /// # Errors
    /// [`Error::Argument`] naming the setting that is out of range.
    pub(super) fn check(&self) -> Result<()> {
        let good = [
            ("instances", (1..=MAX_INSTANCES).contains(&self.instances)),
            ("sigma", self.sigma > 0.0 && self.sigma <= 1.0),
            ("tolerance", self.tolerance > 0.0 && self.tolerance < 0.1),
            (
                "contact angle",
                self.contact_degrees > 0.0 && self.contact_degrees < 180.0,
            ),
            ("steps", (1..=64).contains(&self.steps)),
            ("rounds", (1..=256).contains(&self.rounds)),
            ("diffusions", (1..=64).contains(&self.diffusions)),
            (
                "smoothings",
                self.smoothings % 2 == 1 && self.smoothings < 64,
            ),
            ("settling steps", (1..=250).contains(&self.settling_steps)),
            (
                "iterations",
                (self.least_iterations..=600).contains(&self.iterations),
            ),
            ("least iterations", self.least_iterations >= 1),
            (
                "full turn",
                self.full_turn_degrees > 0.0 && self.full_turn_degrees <= 180.0,
            ),
            ("stillness", self.stillness >= 0.0 && self.stillness < 0.1),
            ("tie", (0.0..=1.0).contains(&self.tie)),
            ("loose tie", (0.0..=1.0).contains(&self.loose_tie)),
            (
                "spectral radius",
                (0.0..1.0).contains(&self.spectral_radius),
            ),
            (
                "degrees of a sub-step",
                self.substep_degrees > 0.0 && self.substep_degrees <= 180.0,
            ),
            (
                "least bend",
                self.least_bend_degrees > 0.0 && self.least_bend_degrees <= 180.0,
            ),
            ("halving degrees", self.halving_degrees >= 0.0),
            ("sub-steps", (1..=64).contains(&self.max_substeps)),
        ];
        match good.iter().find(|(_, good)| !good) {
            Some((name, _)) => Err(Error::argument(*name, "out of range")),
            None => Ok(()),
        }
    }
}
