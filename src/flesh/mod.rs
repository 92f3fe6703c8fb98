//! Fleshing (2013): bending along a spine that keeps the volume of every piece.
//!
//! A [`Spine`] is a smooth curve by arc length with a frame that does not turn. [`register`] finds for each point its place
//! along and across the rest spine and where it would be were that straight, once; [`bend`] puts it to a bent spine. Three
//! [`Map`]s make up for what bending takes or gives, each in its own direction; all keep the volume of any part of space
//! within their limits. The inverse is the same with the spines exchanged. All in f64, any units, right-handed.
//!
//! ```
//! use dermis::flesh::{BendOptions, Curve, Map, Round, Spine, SpineDesc, bend, register};
//! use glam::DVec3;
//!
//! # fn main() -> dermis::Result<()> {
//! let straight = Curve::Polyline(vec![DVec3::ZERO, 3.0 * DVec3::X]);
//! let rest = Spine::new(&SpineDesc::new(straight))?;
//! let arc = Curve::Arc(Round {
//!     start: DVec3::ZERO,
//!     tangent: DVec3::X,
//!     normal: DVec3::Y,
//!     radius: 2.0,
//!     length: 3.0,
//! });
//! let bent = Spine::like(&SpineDesc::new(arc), &rest)?;
//! let points = [DVec3::new(1.0, 0.5, 0.0), DVec3::new(2.0, -0.5, 0.1)];
//! let registered = register(&rest, Map::Radial, &points, &[])?;
//! let moved = bend(&registered, &bent, &BendOptions::default())?;
//! assert_eq!(moved.flags, [0, 0]); // within the limits
//! # Ok(())
//! # }
//! ```

mod bend;
mod curve;
mod file;
mod frame;
mod hermite;
mod layers;
mod length;
mod map;
mod measure;
mod register;
mod search;
mod spine;
#[cfg(test)]
mod spine_tests;
#[cfg(test)]
mod tests;
mod twist;

pub use bend::{BendOptions, Bent, Placement, bend, bend_again};
pub use curve::{Curve, Round};
pub use layers::{Layer, blend};
pub use map::{BINORMAL_ROOM, Map, Shift};
pub use measure::{LocalError, cube_error, surface_error, torn, volume};
pub use register::{
    AMBIGUOUS, Anchor, INVALID, PAST_BENT_LIMIT, PAST_END, PAST_REST_LIMIT, Registration, Tilt,
    register,
};
pub use search::Closest;
pub use spine::{Section, Spine, SpineCell, SpineDesc};
pub use twist::Twist;
