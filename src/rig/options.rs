//! What the user may choose about a preparation.

use super::{Primitive, SpineChain};
use crate::compose::{Controller, OpeningCurve, Operator, Profile};

/// What the user may choose about a preparation.
#[derive(Clone, Debug)]
pub struct Options {
    /// Operator at a joint, between its part and its parent's; elsewhere the method's own: union, or contact in tracking.
    pub joints: Vec<(String, Operator)>,
    /// Opening curve at a joint, in place of the operator's own.
    pub openings: Vec<(String, OpeningCurve)>,
    /// Controller of the contact at a joint, in place of the operator's own (tracking).
    pub controllers: Vec<(String, Controller)>,
    /// What [`Operator::Profile`] is (tracking).
    pub profile: Option<Profile>,
    /// Joints whose parts are rigid, besides what the file paints so (tracking).
    pub rigid: Vec<String>,
    /// Magnitude of the bulge operator.
    pub magnitude: f32,
    /// Extra implicit primitives, such as muscles that swell with a joint's bend.
    pub primitives: Vec<Primitive>,
    /// Chains of joints that bend by fleshing: tails, trunks, necks, tentacles; in place of the file's own where both begin at the
    /// same joint.
    pub spines: Vec<SpineChain>,
    /// Joint row of each row of the (subdivided) file, in place of the joint of greatest weight.
    pub part: Option<Vec<u16>>,
    /// How often every triangle is cut into four.
    pub subdivide: u32,
    /// Compute weights by heat diffusion though the file has some.
    pub heat_weights: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            joints: Vec::new(),
            openings: Vec::new(),
            controllers: Vec::new(),
            profile: None,
            rigid: Vec::new(),
            primitives: Vec::new(),
            magnitude: 1.0,
            spines: Vec::new(),
            part: None,
            subdivide: 0,
            heat_weights: false,
        }
    }
}
