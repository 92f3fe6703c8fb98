//! Where a picture is taken from.

use std::{f32::consts::TAU, str::FromStr};

use glam::{
    Mat3, Mat4, Quat, Vec2, Vec3,
    camera::rh::{proj::vulkan, view::look_at_mat4},
};

use crate::{Error, Result};

/// Share of the picture's half-width or half-height that a framed cloud may fill.
const FILL: f32 = 0.92;

/// Between the 26 directions of [`Bounds`] a ball reaches beyond its extreme points by up to an eighth. Half of that is
/// added to its radius, the rest is less than what [`FILL`] leaves free.
const BETWEEN: f32 = 1.06;

/// Steps of a full turn at which a turntable's camera is fitted.
const TURNS: usize = 24;

/// How far a cloud of points reaches in model space: its extreme points in 26 directions, those of a cube's faces,
/// edges and corners. Frames a character more closely than its box, of which most corners are empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    points: Vec<Vec3>,
}

impl Bounds {
    /// Bounds of the finite `points`; of a small cube around the origin where there are none.
    pub fn of(points: &[Vec3]) -> Self {
        let extreme = |direction: Vec3| {
            let finite = points.iter().filter(|p| p.is_finite());
            finite.max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)))
        };
        let points: Option<Vec<_>> = directions().map(|d| extreme(d).copied()).collect();
        let points = points.unwrap_or_else(|| directions().map(|d| d * 0.5).collect());
        Self { points }
    }

    /// Bounds of spheres, each a centre and a radius.
    pub fn of_balls(balls: impl IntoIterator<Item = (Vec3, f32)>) -> Self {
        let ends = |(centre, radius): (Vec3, f32)| {
            directions().map(move |d| centre + d.normalize_or_zero() * (radius * BETWEEN))
        };
        let points: Vec<Vec3> = balls.into_iter().flat_map(ends).collect();
        Self::of(&points)
    }

    /// Bounds of both.
    pub fn union(&self, other: &Self) -> Self {
        Self::of(&[&self.points[..], &other.points].concat())
    }

    /// Bounds of this cloud turned all around the vertical axis through its centre; framed once, it is seen whole
    /// all along a turntable.
    pub fn turned(&self) -> Self {
        let centre = self.centre();
        let turn = |i: usize| Quat::from_rotation_y(i as f32 / TURNS as f32 * TAU);
        let turned = (0..TURNS).flat_map(|i| {
            let about = move |p: &Vec3| centre + turn(i) * (p - centre);
            self.points.iter().map(about)
        });
        Self {
            points: turned.collect(),
        }
    }

    /// Middle of the axis-aligned box.
    fn centre(&self) -> Vec3 {
        let low = self.points.iter().copied().reduce(Vec3::min);
        let high = self.points.iter().copied().reduce(Vec3::max);
        (low.unwrap_or_default() + high.unwrap_or_default()) / 2.0
    }

    /// Greatest distance from `centre`; for a single point what is still well above the rounding of its coordinates.
    fn radius(&self, centre: Vec3) -> f32 {
        let least = 1e-3 * centre.abs().max_element() + 1e-6;
        let distances = self.points.iter().map(|p| p.distance(centre));
        distances.fold(least, f32::max)
    }
}

fn directions() -> impl Iterator<Item = Vec3> {
    let axis = |i: i32, step: i32| (i / step % 3 - 1) as f32;
    let all = (0..27).map(move |i| Vec3::new(axis(i, 1), axis(i, 3), axis(i, 9)));
    all.filter(|d| *d != Vec3::ZERO)
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
        let axes = Mat3::from_cols(up.cross(back), up, back);
        let mut target = bounds.centre();
        let radius = bounds.radius(target);
        let mut fit = Fit::new(bounds, target, &axes, projection, aspect);
        // Perspective draws near things larger, so that the picture's middle is not the cloud's: a few steps find it.
        for _ in 0..6 {
            target += axes * fit.off_centre.extend(0.0);
            fit = Fit::new(bounds, target, &axes, projection, aspect);
        }
        let distance = fit.distance;
        Self {
            eye: target + back * distance,
            target,
            up,
            projection: fit.projection,
            depth: depth(distance, radius),
        }
    }

    /// A camera at `eye` that looks at `target`, with y up in the picture and the lens of [`Projection::default`]. It sees
    /// what is within `bounds`, in front of it.
    ///
    /// Fails where a point is not finite, or the two are one point or straight above each other.
    pub fn standing(eye: Vec3, target: Vec3, bounds: &Bounds) -> Result<Self> {
        let back = (eye - target).normalize_or_zero();
        if !eye.is_finite() || !target.is_finite() || back.cross(Vec3::Y).length() < 1e-3 {
            let reason = format!("from {eye} at {target} no picture is upright");
            return Err(Error::argument("camera", reason));
        }
        let centre = bounds.centre();
        let (distance, radius) = (eye.distance(centre), bounds.radius(centre));
        Ok(Self {
            eye,
            target,
            up: Vec3::Y,
            projection: Projection::default(),
            depth: depth(distance, radius),
        })
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

/// Nearest and farthest visible distance for a cloud of this radius at this distance: wide, for what orbits or sticks out.
fn depth(distance: f32, radius: f32) -> (f32, f32) {
    let nearest = (0.02 * distance).max(1e-3 * radius);
    (
        (distance - 8.0 * radius).max(nearest),
        distance + 8.0 * radius,
    )
}

/// How a camera that looks along fixed axes at a fixed target sees a cloud of points whole.
struct Fit {
    distance: f32,
    projection: Projection,
    /// From the target to the middle of what is seen: right and up, model units.
    off_centre: Vec2,
}

impl Fit {
    fn new(
        bounds: &Bounds,
        target: Vec3,
        axes: &Mat3,
        projection: Projection,
        aspect: f32,
    ) -> Self {
        let to_view = axes.transpose();
        let seen = || bounds.points.iter().map(|&p| to_view * (p - target));
        let radius = bounds.radius(target);
        let slope = match projection {
            // A point at depth z towards the viewer needs half a height of (distance − z) tan(angle / 2).
            Projection::Perspective { degrees } => (degrees.to_radians() / 2.0).tan() * FILL,
            Projection::Orthographic { .. } => 0.0,
        };
        let half = |c: Vec3| c.y.abs().max(c.x.abs() / aspect);
        let (distance, projection) = if slope > 0.0 {
            let needs = seen().map(|c| c.z + half(c) / slope);
            (needs.fold(radius, f32::max), projection)
        } else {
            let height = 2.0 / FILL * seen().map(half).fold(radius * 1e-3, f32::max);
            (4.0 * radius, Projection::Orthographic { height })
        };
        // What a point covers in the target's plane; without perspective, the point itself.
        let cover = |c: Vec3| match slope > 0.0 {
            true => c.truncate() * distance / (distance - c.z).max(radius * 1e-3),
            false => c.truncate(),
        };
        let low = seen().map(cover).fold(Vec2::INFINITY, Vec2::min);
        let high = seen().map(cover).fold(Vec2::NEG_INFINITY, Vec2::max);
        Self {
            distance,
            projection,
            off_centre: (low + high) / 2.0,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// An uneven cloud whose extreme points are far from its box's corners.
    fn cloud() -> Vec<Vec3> {
        vec![
            Vec3::new(-1.0, 1.4, 0.0),
            Vec3::new(1.5, 1.3, 0.1),
            Vec3::new(0.1, 1.8, 0.0),
            Vec3::new(-0.2, 0.0, 0.4),
            Vec3::new(0.3, 0.0, -0.3),
        ]
    }

    /// Greatest distance from the picture's middle, 1 at its border, to the right, left, top and bottom.
    fn reach(camera: &Camera, aspect: f32) -> [f32; 4] {
        let clip = camera.clip_from_model(aspect);
        let seen: Vec<_> = cloud().iter().map(|&p| clip.project_point3(p)).collect();
        assert!(seen.iter().all(|c| (0.0..=1.0).contains(&c.z)));
        let most = |f: fn(&Vec3) -> f32| seen.iter().map(f).fold(f32::MIN, f32::max);
        [most(|c| c.x), most(|c| -c.x), most(|c| -c.y), most(|c| c.y)]
    }

    #[test]
    fn a_framed_cloud_fills_the_picture_and_is_in_its_middle() {
        let bounds = Bounds::of(&cloud());
        for view in View::NAMES.map(|name| View::from_str(name).unwrap()) {
            for projection in [
                Projection::default(),
                Projection::Orthographic { height: 0.0 },
            ] {
                for aspect in [0.5, 1.0, 1.7] {
                    let camera = Camera::framing(&bounds, view, projection, aspect);
                    let [right, left, top, bottom] = reach(&camera, aspect);
                    let most = right.max(left).max(top).max(bottom);
                    let about = format!("{view:?} {aspect}: {right} {left} {top} {bottom}");
                    assert!((FILL - 0.01..FILL + 0.01).contains(&most), "{about}");
                    assert!((right - left).abs() < 0.02, "{about}");
                    assert!((top - bottom).abs() < 0.02, "{about}");
                }
            }
        }
    }

    #[test]
    fn named_views_look_along_their_axes() {
        let bounds = Bounds::of(&cloud());
        let side_of = |view, orbit| {
            let camera = Camera::framing(&bounds, view, Projection::default(), 1.0).orbit(orbit);
            let clip = camera.clip_from_model(1.0);
            let point = clip.project_point3(camera.target + Vec3::new(0.1, 0.2, -0.3));
            (point.x.signum(), point.y.signum())
        };
        // y of clip space points down.
        assert_eq!(side_of(View::Front, 0.0), (1.0, -1.0));
        assert_eq!(side_of(View::Side, 0.0), (1.0, -1.0));
        assert_eq!(side_of(View::Top, 0.0), (1.0, -1.0));
        assert_eq!(side_of(View::Front, 180.0), (-1.0, -1.0));
        assert_eq!(side_of(View::Top, 180.0), (-1.0, 1.0));
    }

    #[test]
    fn a_camera_stands_where_it_is_told_to() {
        let bounds = Bounds::of(&cloud());
        let framed = Camera::framing(&bounds, View::ThreeQuarter, Projection::default(), 1.5);
        let standing = Camera::standing(framed.eye, framed.target, &bounds).unwrap();
        let (a, b) = (framed.clip_from_model(1.5), standing.clip_from_model(1.5));
        for point in cloud() {
            let (a, b) = (a.project_point3(point), b.project_point3(point));
            assert!(a.truncate().distance(b.truncate()) < 1e-4, "{a} {b}");
            assert!((0.0..=1.0).contains(&b.z));
        }
        let inside = Camera::standing(bounds.centre(), Vec3::ZERO, &bounds).unwrap();
        assert!(inside.clip_from_model(1.0).is_finite());
        for (eye, target) in [
            (Vec3::Y, Vec3::ZERO),
            (Vec3::X, Vec3::X),
            (Vec3::NAN, Vec3::X),
        ] {
            assert!(Camera::standing(eye, target, &bounds).is_err());
        }
    }

    #[test]
    fn a_turned_cloud_holds_every_orbit() {
        let turned = Bounds::of(&cloud()).turned();
        for view in [View::Front, View::ThreeQuarter, View::Top] {
            let camera = Camera::framing(&turned, view, Projection::default(), 1.0);
            for degrees in [0.0, 30.0, 47.0, 117.0, 290.0] {
                let most = reach(&camera.orbit(degrees), 1.0);
                let most = most.into_iter().fold(0.0, f32::max);
                assert!((0.5..1.0).contains(&most), "{view:?} {degrees}: {most}");
            }
        }
    }

    #[test]
    fn points_that_are_not_finite_are_left_out() {
        assert_eq!(Bounds::of(&[Vec3::NAN]), Bounds::of(&[]));
        let one = Bounds::of(&[Vec3::ONE, Vec3::INFINITY]);
        assert_eq!(one.centre(), Vec3::ONE);
        let two = one.union(&Bounds::of(&[Vec3::ZERO]));
        assert_eq!(two.centre(), Vec3::splat(0.5));
        let camera = Camera::framing(&one, View::Top, Projection::default(), 1.0);
        assert!(camera.eye.is_finite() && camera.clip_from_model(1.0).is_finite());
        assert!(View::from_str("below").is_err());
    }
}
