//! Where a straight line meets the surface of a solid that is thickened by the radius of what moves (2016, appendix B).
//!
//! A solid is the convex hull of its spheres. Its surface is made of patches of these spheres, of cones that touch two of
//! them and of planes that touch three. Every piece that is tried lies within the solid, so that the first meeting of a line
//! with any of them is where it enters, the last where it leaves.

use glam::DVec3;

use super::super::shape::{Ball, Solid, gradient};
use crate::layout::particles;

/// A straight line and what moves along it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) origin: DVec3,
    /// Of length 1.
    pub(super) direction: DVec3,
    pub(super) radius: f64,
}

/// The cone that touches two spheres: with the axis u from a to b and sin φ = (r_a - r_b) / |ab| its normals are
/// cos φ across and sin φ along u.
#[derive(Clone, Copy, Debug)]
struct Side {
    a: Ball,
    axis: DVec3,
    length: f64,
    sin: f64,
    /// cos² φ
    square: f64,
}

/// The plane that touches three spheres on one side of their centres: normal n with n·(c_j - c_0) = r_0 - r_j. The point
/// c + r n moves along (c_j - c_0) + (r_j - r_0) n with c, whatever is added to all radii.
#[derive(Clone, Copy, Debug)]
struct Face {
    a: Ball,
    normal: DVec3,
    /// Coordinates along the two sides from a: of a point p of the plane relative to c_0 + r_0 n.
    u: DVec3,
    v: DVec3,
    /// How much these grow with p at most.
    spread: f64,
}

/// A solid with all that does not depend on the line.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    pub(super) solid: Solid,
    /// A sphere around it.
    pub(super) bound: Ball,
    /// The cone from each sphere to the next.
    sides: [Option<Side>; 3],
    faces: Option<[Face; 2]>,
}

/// Room at the borders of a plane, in its coordinates: two planes that share a border must not let anything through.
const BORDER: f64 = 1e-12;

impl Pieces {
    pub(super) fn new(solid: Solid) -> Self {
        let (sides, faces) = match &solid {
            Solid::Ball(_) => ([None; 3], None),
            Solid::Cone([a, b]) => ([Side::new(a, b), None, None], None),
            Solid::Slab(corners) => {
                let [a, b, c] = corners;
                let sides = [Side::new(a, b), Side::new(b, c), Side::new(c, a)];
                (sides, Face::both(corners))
            }
        };
        Self {
            bound: around(solid.balls()),
            solid,
            sides,
            faces,
        }
    }

    /// Axes with lengths, sines and cos² φ of the cones in single precision; zeros for those that are not there.
    pub(super) fn sides_of_f32(&self) -> ([[f32; 4]; 3], [f32; 4], [f32; 4]) {
        let (mut sides, mut sines, mut squares) = ([[0.0; 4]; 3], [0.0; 4], [0.0; 4]);
        for (k, side) in self.sides.iter().enumerate() {
            if let Some(side) = side {
                sides[k] = side.axis.as_vec3().extend(side.length as f32).to_array();
                (sines[k], squares[k]) = (side.sin as f32, side.square as f32);
            }
        }
        (sides, sines, squares)
    }

    /// The planes in single precision; zeros for those that are not there.
    pub(super) fn faces_of_f32(&self) -> [particles::Face; 2] {
        let face = |face: Face| particles::Face {
            normal: face.normal.as_vec3().extend(1.0).to_array(),
            u: face.u.as_vec3().extend(face.spread as f32).to_array(),
            v: face.v.as_vec3().extend(0.0).to_array(),
        };
        self.faces
            .map_or_else(Default::default, |faces| faces.map(face))
    }

    /// Where the line enters the solid, by its arc length; infinite where it passes by.
    pub(super) fn enter(&self, line: &Line) -> f64 {
        // A plane that is met from its front is where the line enters; else it may be any of the others.
        for face in self.faces.iter().flatten() {
            if face.normal.dot(line.direction) < 0.0
                && let Some(at) = face.meet(line)
            {
                return at;
            }
        }
        let mut first = f64::INFINITY;
        self.meet_round(line, |at, _| first = first.min(at));
        first
    }

    /// Where the line leaves the solid, by its arc length; negatively infinite where it passes by.
    pub(super) fn leave(&self, line: &Line) -> f64 {
        let mut last = f64::NEG_INFINITY;
        self.meet_round(line, |at, _| last = last.max(at));
        let faces = self.faces.iter().flatten().filter_map(|f| f.meet(line));
        faces.fold(last, f64::max)
    }

    /// The outward normal at `end`, where the line enters or leaves.
    pub(super) fn normal(&self, line: &Line, end: f64, entering: bool) -> DVec3 {
        let back = if entering {
            -line.direction
        } else {
            line.direction
        };
        // Planes first: on their borders, without thickness, a sphere has no normal.
        let slack = 4.0 * f64::EPSILON * end.abs() + 1e-12 * self.bound.radius;
        for face in self.faces.iter().flatten() {
            if face.normal.dot(back) > 0.0
                && face.meet(line).is_some_and(|at| (at - end).abs() <= slack)
            {
                return face.normal;
            }
        }
        let (mut best, mut about) = (f64::INFINITY, line.origin);
        self.meet_round(line, |at, centre| {
            if (at - end).abs() < best {
                (best, about) = ((at - end).abs(), centre);
            }
        });
        let out = line.origin + line.direction * end - about;
        // A point that meets a point or a wire: it is thrown back.
        out.try_normalize().unwrap_or(back)
    }

    /// The direction in which the surface is nearest, from inside.
    pub(super) fn way_out(&self, p: DVec3) -> DVec3 {
        let out = p - self.solid.nearest(p).centre;
        if out.length() > 1e-9 * self.bound.radius
            && let Some(out) = out.try_normalize()
        {
            return out;
        }
        // On the axis all normals of the cone are as good; in the middle of a slab both sides are.
        if let Some([face, _]) = self.faces {
            return face.normal;
        }
        let side = self.sides.iter().flatten().next();
        side.map_or(DVec3::X, |side| {
            let across = side.axis.any_orthonormal_vector();
            across * side.square.sqrt() + side.axis * side.sin
        })
    }

    /// Spheres and cones: where each is met, and the centre of the sphere that touches there.
    fn meet_round(&self, line: &Line, mut visit: impl FnMut(f64, DVec3)) {
        for (ball, side) in self.solid.balls().iter().zip(&self.sides) {
            let beside = beside(ball.centre, line);
            meet_ball(ball, line, beside, &mut visit);
            if let Some(side) = side {
                side.meet(line, beside, &mut visit);
            }
        }
    }
}

/// A centre's place along a line, and the line's point beside it relative to the centre: what is large is gone before
/// anything is squared.
fn beside(centre: DVec3, line: &Line) -> (f64, DVec3) {
    let from = line.origin - centre;
    let along = -from.dot(line.direction);
    (along, from + line.direction * along)
}

/// Eq. 14.
fn meet_ball(
    ball: &Ball,
    line: &Line,
    (middle, from): (f64, DVec3),
    visit: &mut impl FnMut(f64, DVec3),
) {
    let reach = ball.radius + line.radius;
    let square = reach * reach - from.length_squared();
    if square >= 0.0 {
        let half = square.sqrt();
        visit(middle - half, ball.centre);
        visit(middle + half, ball.centre);
    }
}

impl Side {
    fn new(a: &Ball, b: &Ball) -> Option<Self> {
        let axis = b.centre - a.centre;
        let length = axis.length();
        let sin = (a.radius - b.radius) / length;
        let square = (1.0 - sin) * (1.0 + sin);
        // Else one end holds the other, or all but a sliver of rounding errors.
        (length > 0.0 && square > 1e-14).then(|| Self {
            a: *a,
            axis: axis / length,
            length,
            sin,
            square,
        })
    }

    /// Eq. 15 with μ and θ eliminated. Beside the axis at x and along it at y, both from c_a, the cone is
    /// x cos φ + y sin φ = R for R = r_a + r; squared, cos² φ (|p|² - R²) = w² with w = y - R sin φ, and the centre of the
    /// sphere that touches there is at w / cos² φ along the axis. Between the ends R - y sin φ is not negative.
    fn meet(&self, line: &Line, (middle, from): (f64, DVec3), visit: &mut impl FnMut(f64, DVec3)) {
        let reach = self.a.radius + line.radius;
        let along = line.direction.dot(self.axis);
        let w = from.dot(self.axis) - reach * self.sin;
        let a = self.square - along * along;
        let b = -along * w;
        let c = self.square * (from.length_squared() - reach * reach) - w * w;
        let square = b * b - a * c;
        if square < 0.0 {
            return;
        }
        let q = -(b + square.sqrt().copysign(b));
        // A root at infinity, or none, is in no interval.
        for at in [q / a, c / q] {
            let w = w + along * at;
            if w >= 0.0 && w <= self.length * self.square {
                let centre = self.a.centre + self.axis * (w / self.square);
                visit(middle + at, centre);
            }
        }
    }
}

impl Face {
    /// `None` where the centres are collinear or no plane touches all spheres: the cones are the surface then.
    fn both(corners: &[Ball; 3]) -> Option<[Self; 2]> {
        let (gradient, across) = gradient(corners)?;
        let [a, b, c] = *corners;
        let height = (1.0 - gradient.length_squared()).sqrt();
        let face = |side: f64| {
            let normal = across * (side * height) - gradient;
            let e = b.centre - a.centre + normal * (b.radius - a.radius);
            let f = c.centre - a.centre + normal * (c.radius - a.radius);
            let area = e.cross(f);
            let share = 1.0 / area.length_squared();
            let (u, v) = (f.cross(area) * share, area.cross(e) * share);
            Self {
                a,
                normal,
                u,
                v,
                spread: u.length() + v.length(),
            }
        };
        let faces = [face(1.0), face(-1.0)];
        let finite = |f: &Face| f.normal.is_finite() && f.u.is_finite() && f.v.is_finite();
        faces.iter().all(finite).then_some(faces)
    }

    fn meet(&self, line: &Line) -> Option<f64> {
        let from = line.origin - self.a.centre - self.normal * (self.a.radius + line.radius);
        let at = -from.dot(self.normal) / line.direction.dot(self.normal);
        let p = from + line.direction * at;
        let (u, v) = (p.dot(self.u), p.dot(self.v));
        let border = BORDER + 4.0 * f64::EPSILON * self.spread * at.abs();
        (u >= -border && v >= -border && u + v <= 1.0 + border).then_some(at)
    }
}

/// A small sphere around spheres: around two of them, or about the mean of all.
fn around(balls: &[Ball]) -> Ball {
    let about = |centre: DVec3| Ball {
        centre,
        radius: balls
            .iter()
            .map(|b| b.centre.distance(centre) + b.radius)
            .fold(0.0, f64::max),
    };
    let mean = balls.iter().map(|b| b.centre).sum::<DVec3>() / balls.len() as f64;
    let mut best = about(mean);
    for a in balls {
        for b in balls {
            let axis = b.centre - a.centre;
            let along = axis.length() + b.radius - a.radius;
            let centre = a.centre + axis.normalize_or_zero() * (0.5 * along.max(0.0));
            let other = about(centre);
            if other.radius < best.radius {
                best = other;
            }
        }
    }
    best
}
