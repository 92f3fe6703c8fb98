//! Composition of fields: operators, opening curves and the program that the shaders follow; operators by profile and their controllers.

mod biharmonic;
mod condition;
mod controller;
mod evaluate;
mod fold;
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
pub use fold::{Fold, Leaf};
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
    /// Contact g_dc of the 2014 method.
    Contact,
    /// The operator of the user's profile, in the 2014 method.
    Profile,
}

impl Operator {
    /// The opening curve that the paper's figure 7 gives to this operator; a union has no use for one.
    pub fn default_opening(self) -> OpeningCurve {
        match self {
            Self::Bulge => OpeningCurve::finger(),
            _ => OpeningCurve::elbow(),
        }
    }

    /// The controller of this operator in tracking; a union never touches.
    pub fn default_controller(self) -> Controller {
        match self {
            Self::Union => Controller::never(),
            Self::Bulge | Self::Profile => Controller::finger(),
            _ => Controller::fold(),
        }
    }

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Union => "union",
            Self::Blend => "blend",
            Self::Bulge => "bulge",
            Self::Contact => "contact",
            Self::Profile => "profile",
        }
    }
}

/// For each field (a row each), how it meets its parent's field.
#[derive(Clone, Debug, Default)]
pub struct Composition {
    /// Field of the nearest ancestor joint that has one, or `u32::MAX`; of a primitive, the one of its joint.
    pub parent: Vec<u32>,
    /// The last so many fields are extra primitives.
    pub primitives: usize,
    /// Operator at the joint between the two; none where the method's own is meant.
    pub operator: Vec<Option<Operator>>,
    /// How far the operator opens with the angle between the two gradients; none for the operator's own.
    pub opening: Vec<Option<OpeningCurve>>,
    /// How deep a contact goes with that angle (2014); none for the operator's own.
    pub controller: Vec<Option<Controller>>,
    /// What [`Operator::Profile`] is.
    pub profile: Option<Profile>,
    /// Magnitude of the bulge operator, 1 as the authors have it; at most [`MAX_MAGNITUDE`].
    pub magnitude: f32,
}

impl Composition {
    /// A field is an extra primitive.
    pub fn is_primitive(&self, field: u32) -> bool {
        field as usize >= self.parent.len() - self.primitives
    }

    /// Adds a primitive, which melts into its parent's field by a union in every method.
    pub fn add_primitive(&mut self, parent: u32) {
        self.primitives += 1;
        self.parent.push(parent);
        self.operator.push(Some(Operator::Union));
        self.opening.push(None);
        self.controller.push(Some(Controller::never()));
    }
}
