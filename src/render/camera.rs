//! Where a picture is taken from.

use std::str::FromStr;

use glam::{
    Mat4, Quat, Vec3,
    camera::rh::{proj::vulkan, view::look_at_mat4},
};

use crate::{Error, Result};

/// Share of the picture's half-width or half-height that a framed box may fill.
const FILL: f32 = 0.92;

/// An axis-aligned box in model space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least coordinates.
    pub min: Vec3,
    /// Greatest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// Box of the finite `points`; the unit cube around the origin where there are none.
    pub fn of(points: &[Vec3]) -> Self {
        let finite = points.iter().filter(|p| p.is_finite());
        let boxes = finite.map(|&p| Self { min: p, max: p });
        boxes.reduce(Self::union).unwrap_or(Self {
            min: Vec3::splat(-0.5),
            max: Vec3::splat(0.5),
        })
    }

    /// Smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Smallest box with a square base that holds this one however it turns about the vertical axis through its
    /// centre; framed once, it is seen whole all along a turntable.
    pub fn turned(self) -> Self {
        let centre = (self.min + self.max) / 2.0;
        let half = (self.max - self.min) / 2.0;
        let radius = half.x.hypot(half.z);
        let half = Vec3::new(radius, half.y, radius);
        Self {
            min: centre - half,
            max: centre + half,
        }
    }

    fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            Vec3::new(
                if i & 1 == 0 { self.min.x } else { self.max.x },
                if i & 2 == 0 { self.min.y } else { self.max.y },
                if i & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }
}

/// A named direction of view. The vertical axis is y and the character looks along +z, as in glTF.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// From +z.
    Front,
    /// From +x, at the character's left.
    Side,
    /// From +y, the character's front at the bottom of the picture.
    Top,
    /// From the front, a third to its left and somewhat above.
    #[default]
    ThreeQuarter,
}

impl View {
    /// Names as [`FromStr`] takes them.
    pub const NAMES: [&str; 4] = ["front", "side", "top", "three-quarter"];

    /// Degrees about the vertical axis from +z towards +x, and above the horizon.
    fn angles(self) -> (f32, f32) {
        match self {
            Self::Front => (0.0, 0.0),
            Self::Side => (90.0, 0.0),
            Self::Top => (0.0, 90.0),
            Self::ThreeQuarter => (35.0, 14.0),
        }
    }
}

impl FromStr for View {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        match name {
            "front" => Ok(Self::Front),
            "side" => Ok(Self::Side),
            "top" => Ok(Self::Top),
            "three-quarter" => Ok(Self::ThreeQuarter),
            _ => Err(Error::argument(
                "view",
                format!("{name:?} is none of {}", Self::NAMES.join(", ")),
            )),
        }
    }
}

/// How depth foreshortens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A pinhole.
    Perspective {
        /// Vertical angle of view, degrees.
        degrees: f32,
    },
    /// Parallel rays.
    Orthographic {
        /// Model units from the picture's bottom to its top; set by [`Camera::framing`].
        height: f32,
    },
}

impl Default for Projection {
    /// A portrait lens: little foreshortening, depth still readable.
    fn default() -> Self {
        Self::Perspective { degrees: 28.0 }
    }
}

/// A camera in model space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands.
    pub eye: Vec3,
    /// Where it looks.
    pub target: Vec3,
    /// What is up in the picture; not along the direction of view.
    pub up: Vec3,
    /// How depth foreshortens.
    pub projection: Projection,
    /// Nearest and farthest visible distance, model units.
    pub depth: (f32, f32),
}

impl Camera {
    /// The camera that just sees all of `bounds` from `view`, in a picture of the given width over height.
    pub fn framing(bounds: &Bounds, view: View, projection: Projection, aspect: f32) -> Self {
        let (azimuth, elevation) = view.angles();
        let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
        let level = Vec3::new(azimuth.sin(), 0.0, azimuth.cos());
        let back = level * elevation.cos() + Vec3::Y * elevation.sin();
        let up = Vec3::Y * elevation.cos() - level * elevation.sin();
        let target = (bounds.min + bounds.max) / 2.0;
        let radius = ((bounds.max - bounds.min).length() / 2.0).max(1e-6);
        let right = up.cross(back);
        let seen = bounds
            .corners()
            .map(|c| c - target)
            .map(|c| Vec3::new(c.dot(right).abs() / aspect, c.dot(up).abs(), c.dot(back)));
        let (distance, projection) = fit(&seen, radius, projection);
        Self {
            eye: target + back * distance,
            target,
            up,
            projection,
            depth: (
                (distance - 8.0 * radius).max(distance * 0.02),
                distance + 8.0 * radius,
            ),
        }
    }

    /// This camera carried `degrees` around its target, about the vertical axis, from +z towards +x.
    pub fn orbit(self, degrees: f32) -> Self {
        let turn = Quat::from_rotation_y(degrees.to_radians());
        Self {
            eye: self.target + turn * (self.eye - self.target),
            up: turn * self.up,
            ..self
        }
    }

    /// Model space → Vulkan clip space (y down, depth 0 to 1) for a picture of the given width over height.
    pub fn clip_from_model(&self, aspect: f32) -> Mat4 {
        let view = look_at_mat4(self.eye, self.target, self.up);
        let (near, far) = self.depth;
        let projection = match self.projection {
            Projection::Perspective { degrees } => {
                vulkan::perspective(degrees.to_radians(), aspect, near, far)
            }
            Projection::Orthographic { height } => {
                let (x, y) = (height * aspect / 2.0, height / 2.0);
                vulkan::orthographic(-x, x, -y, y, near, far)
            }
        };
        projection * view
    }

    /// Unit vectors of the picture: right, up and towards the viewer.
    pub(super) fn axes(&self) -> [Vec3; 3] {
        let back = (self.eye - self.target).normalize_or(Vec3::Z);
        let right = self
            .up
            .cross(back)
            .normalize_or(back.any_orthonormal_vector());
        [right, back.cross(right), back]
    }
}

/// Distance, and the final projection, from which `seen` corners (right over aspect, up, towards the viewer) all fit.
fn fit(seen: &[Vec3; 8], radius: f32, projection: Projection) -> (f32, Projection) {
    let half = seen.iter().fold(0.0_f32, |m, c| m.max(c.x).max(c.y));
    match projection {
        Projection::Perspective { degrees } => {
            // A corner at depth z needs half-height (distance − z) tan(angle / 2).
            let slope = (degrees.to_radians() / 2.0).tan() * FILL;
            let needs = seen.iter().map(|c| c.z + c.x.max(c.y) / slope);
            (needs.fold(radius * 1e-3, f32::max), projection)
        }
        Projection::Orthographic { .. } => {
            let height = 2.0 * half.max(radius * 1e-3) / FILL;
            (4.0 * radius, Projection::Orthographic { height })
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const BOX: Bounds = Bounds {
        min: Vec3::new(-1.0, 0.0, -0.3),
        max: Vec3::new(1.5, 1.8, 0.4),
    };

    fn extent(camera: &Camera, aspect: f32) -> f32 {
        let clip = camera.clip_from_model(aspect);
        let corners = BOX.corners().map(|c| clip.project_point3(c));
        assert!(corners.iter().all(|c| (0.0..=1.0).contains(&c.z)));
        corners
            .iter()
            .fold(0.0, |m, c| m.max(c.x.abs()).max(c.y.abs()))
    }

    #[test]
    fn a_framed_box_fills_the_picture_and_no_more() {
        for view in View::NAMES.map(|name| View::from_str(name).unwrap()) {
            for projection in [
                Projection::default(),
                Projection::Orthographic { height: 0.0 },
            ] {
                for aspect in [0.5, 1.0, 1.7] {
                    let camera = Camera::framing(&BOX, view, projection, aspect);
                    let extent = extent(&camera, aspect);
                    assert!(
                        (FILL - 1e-3..FILL + 1e-3).contains(&extent),
                        "{view:?} {extent}"
                    );
                }
            }
        }
    }

    #[test]
    fn named_views_look_along_their_axes() {
        let right = |view, orbit| {
            let camera = Camera::framing(&BOX, view, Projection::default(), 1.0).orbit(orbit);
            let clip = camera.clip_from_model(1.0);
            let point = clip.project_point3(camera.target + Vec3::new(0.1, 0.2, -0.3));
            (point.x.signum(), point.y.signum())
        };
        assert_eq!(right(View::Front, 0.0), (1.0, -1.0));
        assert_eq!(right(View::Side, 0.0), (1.0, -1.0));
        assert_eq!(right(View::Top, 0.0), (1.0, -1.0));
        assert_eq!(right(View::Front, 180.0), (-1.0, -1.0));
    }

    #[test]
    fn a_turned_box_holds_every_orbit() {
        let camera = Camera::framing(&BOX.turned(), View::Front, Projection::default(), 1.0);
        for degrees in [0.0, 30.0, 45.0, 117.0] {
            let extent = extent(&camera.orbit(degrees), 1.0);
            assert!((0.6..=FILL).contains(&extent), "{degrees} {extent}");
        }
    }

    #[test]
    fn points_that_are_not_finite_have_no_bounds() {
        let unit = Bounds::of(&[Vec3::NAN]);
        assert_eq!((unit.min.x, unit.max.y), (-0.5, 0.5));
        assert_eq!(Bounds::of(&[Vec3::ONE, Vec3::INFINITY]).max, Vec3::ONE);
        assert!(View::from_str("below").is_err());
    }
}
