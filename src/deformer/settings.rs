//! What a user chooses: method and numbers of the papers.

use serde::{Deserialize, Serialize};

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
}

impl Method {
    /// The name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lbs => "lbs",
            Self::Dqs => "dqs",
            Self::Implicit => "implicit",
        }
    }
}

/// Settings of a deformer; the defaults are the paper's, or what measured best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Method.
    pub method: Method,
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
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::Implicit,
            sigma: 0.7,
            tolerance: 1e-4,
            contact_degrees: 55.0,
            steps: 2,
            rounds: 6,
            diffusions: 6,
            smoothings: 7,
            settling_steps: 24,
        }
    }
}

impl Settings {
    /// # Errors
    /// [`Error::Argument`] naming the setting that is out of range.
    pub(super) fn check(&self) -> Result<()> {
        let good = [
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
        ];
        match good.iter().find(|(_, good)| !good) {
            Some((name, _)) => Err(Error::argument(*name, "out of range")),
            None => Ok(()),
        }
    }
}
