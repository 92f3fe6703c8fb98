//! Composition of fields: operators, opening curves and the program that the shaders follow; operators by profile and their controllers.

mod biharmonic;
mod condition;
mod controller;
mod evaluate;
mod opening;
mod operator;
mod pins;
mod profile;
mod profile_check;
mod profile_volume;
mod spline;
mod volume;

pub use controller::Controller;
pub use evaluate::{NULL_GRADIENT, Sample, evaluate, union};
pub use opening::{OpeningCurve, TABLE};
pub use operator::{MAX_MAGNITUDE, Partials, blend, bulge, check_magnitude};
pub use profile::{Form, Level, MAX_BULGE, Profile};
pub use profile_volume::profile_volume;
pub use volume::{EDGE, Volume, volume};

/// How a joint's part and its parent's part are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Operator {
    /// max(f1, f2): a crease.
    #[default]
    Union,
    /// Gradient-based blend (appendix A).
    Blend,
    /// Gradient-based bulge in contact.
    Bulge,
}

impl Operator {
    /// The opening curve that the paper's figure 7 gives to this operator; a union has no use for one.
    pub fn default_opening(self) -> OpeningCurve {
        match self {
            Self::Union | Self::Blend => OpeningCurve::elbow(),
            Self::Bulge => OpeningCurve::finger(),
        }
    }
}

/// For each field (a row each), how it meets its parent's field.
#[derive(Clone, Debug, Default)]
pub struct Composition {
    /// Field of the nearest ancestor joint that has one, or `u32::MAX`.
    pub parent: Vec<u32>,
    /// Operator at the joint between the two.
    pub operator: Vec<Operator>,
    /// How far the operator opens with the angle between the two gradients.
    pub opening: Vec<OpeningCurve>,
    /// Magnitude of the bulge operator, 1 as the authors have it; at most [`MAX_MAGNITUDE`].
    pub magnitude: f32,
}
