//! A level in one frame as solids: spheres interpolated along edges (cones with round ends) and triangles (slabs).

use glam::DVec3;

use super::{hierarchy::Hierarchy, level::Level, tree::Bounds};
use crate::{Error, Result};

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre.
    pub centre: DVec3,
    /// Radius, 0 or more.
    pub radius: f64,
}

/// A level in one frame, in the sequence's units.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// Spheres, by the rows of the level.
    pub balls: Vec<Ball>,
    /// Edges that no triangle has.
    pub edges: Vec<[u32; 2]>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
}

/// What a shape is the union of.
#[derive(Clone, Copy, Debug)]
pub(super) enum Solid {
    /// A sphere that nothing joins.
    Ball(Ball),
    Cone([Ball; 2]),
    Slab([Ball; 3]),
}

impl Shape {
    /// The level in frame `frame`.
    pub fn new(hierarchy: &Hierarchy, level: &Level, frame: usize) -> Self {
        let ball = |&node: &u32| Ball {
            centre: hierarchy.centre(node as usize, frame).as_dvec3(),
            radius: f64::from(hierarchy.radius(node as usize)),
        };
        Self {
            balls: level.nodes.iter().map(ball).collect(),
            edges: level.edges.clone(),
            triangles: level.triangles.clone(),
        }
    }

    /// The level at a time in frames: between two of them centres go straight, before the first and behind the last they stay.
    pub fn at(hierarchy: &Hierarchy, level: &Level, time: f64) -> Self {
        let mut shape = Self::new(hierarchy, level, 0);
        shape.go_to(hierarchy, level, time);
        shape
    }

    /// Moves a shape of the level to a time in frames, as [`Shape::at`]; allocates nothing.
    pub fn go_to(&mut self, hierarchy: &Hierarchy, level: &Level, time: f64) {
        let time = time.max(0.0).min((hierarchy.frames - 1) as f64);
        let (frame, part) = (time.floor() as usize, time.fract());
        let next = (frame + 1).min(hierarchy.frames - 1);
        for (ball, &node) in self.balls.iter_mut().zip(&level.nodes) {
            let at = |frame| hierarchy.centre(node as usize, frame).as_dvec3();
            ball.centre = at(frame).lerp(at(next), part);
        }
    }

    /// # Errors
    /// [`Error::Argument`] naming an edge or triangle with a sphere that is not there.
    pub(crate) fn check_rows(&self) -> Result<()> {
        let count = self.balls.len();
        let outside = |rows: &[u32]| rows.iter().any(|&row| row as usize >= count);
        let edge = self.edges.iter().position(|e| outside(e));
        let triangle = self.triangles.iter().position(|t| outside(t));
        let (name, rows): (_, &[u32]) = match (edge, triangle) {
            (Some(i), _) => (format!("edge {i}"), &self.edges[i]),
            (None, Some(i)) => (format!("triangle {i}"), &self.triangles[i]),
            (None, None) => return Ok(()),
        };
        let reason = format!("{rows:?} of {count} spheres");
        Err(Error::argument(name, reason))
    }

    /// Spheres of each solid, the last one repeated, and how many; lone spheres are among them, all others are the ends of some
    /// solid.
    pub(super) fn rows(&self) -> Vec<([u32; 3], usize)> {
        let mut joined = vec![false; self.balls.len()];
        let ends = self
            .edges
            .iter()
            .flatten()
            .chain(self.triangles.iter().flatten());
        ends.for_each(|&k| joined[k as usize] = true);
        let alone = (0..self.balls.len()).filter(|&k| !joined[k]);
        let lone = alone.map(|k| ([k as u32; 3], 1));
        let cones = self.edges.iter().map(|&[a, b]| ([a, b, b], 2));
        let slabs = self.triangles.iter().map(|&t| (t, 3));
        lone.chain(cones).chain(slabs).collect()
    }

    /// The solids of the shape.
    pub(super) fn solids(&self) -> Vec<Solid> {
        let solid = |(row, count): ([u32; 3], usize)| {
            let [a, b, c] = row.map(|k| self.balls[k as usize]);
            match count {
                1 => Solid::Ball(a),
                2 => Solid::Cone([a, b]),
                _ => Solid::Slab([a, b, c]),
            }
        };
        self.rows().into_iter().map(solid).collect()
    }
}

impl Solid {
    pub(super) fn balls(&self) -> &[Ball] {
        match self {
            Solid::Ball(ball) => std::slice::from_ref(ball),
            Solid::Cone(ends) => ends,
            Solid::Slab(corners) => corners,
        }
    }

    pub(super) fn bounds(&self) -> Bounds {
        let ends = self.balls().iter();
        Bounds::of(ends.flat_map(|b| [b.centre - b.radius, b.centre + b.radius]))
    }

    /// Signed distance to the surface, exact: negative inside.
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        self.nearest(p).distance(p)
    }

    /// The interpolated sphere whose surface is nearest, or that holds the point deepest.
    pub(super) fn nearest(&self, p: DVec3) -> Ball {
        match self {
            Solid::Ball(ball) => *ball,
            Solid::Cone([a, b]) => cone(p, a, b),
            Solid::Slab(corners) => slab(p, corners),
        }
    }
}

impl Ball {
    /// Signed distance to the surface.
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        p.distance(self.centre) - self.radius
    }

    fn nearer(self, other: Self, p: DVec3) -> Self {
        if other.distance(p) < self.distance(p) {
            other
        } else {
            self
        }
    }
}

/// The least of |p - c(s)| - r(s), which is convex: its free minimum, clamped.
///
/// With sin φ = (r_a - r_b) / |ab| the normal of the cone is cos φ outwards and sin φ along, so that a point at y along the
/// axis and x beside it belongs to s = y - x tan φ. Without a cone (|ab| <= |r_a - r_b|) one end holds the other.
fn cone(p: DVec3, a: &Ball, b: &Ball) -> Ball {
    let axis = b.centre - a.centre;
    let length = axis.length();
    let sin = (a.radius - b.radius) / length;
    if length == 0.0 || sin.abs() >= 1.0 {
        return a.nearer(*b, p);
    }
    let axis = axis / length;
    let from = p - a.centre;
    let y = from.dot(axis);
    let x = (from.length_squared() - y * y).max(0.0).sqrt();
    let s = (y - x * sin / (1.0 - sin * sin).sqrt()).clamp(0.0, length);
    Ball {
        centre: a.centre + axis * s,
        radius: a.radius - sin * s,
    }
}

/// In-plane gradient of the radius over a triangle, the plane's unit normal; `None` where the centres are collinear or the
/// radius changes so fast that no plane touches the three spheres.
pub(super) fn gradient([a, b, c]: &[Ball; 3]) -> Option<(DVec3, DVec3)> {
    let (ab, ac) = (b.centre - a.centre, c.centre - a.centre);
    let normal = ab.cross(ac);
    let square = normal.length_squared();
    if square <= 1e-16 * ab.length_squared() * ac.length_squared() {
        return None;
    }
    let (rb, rc) = (b.radius - a.radius, c.radius - a.radius);
    let gradient = (ac.cross(normal) * rb + normal.cross(ab) * rc) / square;
    let fits = gradient.length_squared() < 1.0;
    fits.then(|| (gradient, normal / square.sqrt()))
}

/// As for a cone: the free minimum over the plane, and where that is outside of the triangle, the sides.
///
/// At the minimum the centre is at x = foot + g |h| / √(1 - g²) for a point at height h and the gradient g of the radius.
fn slab(p: DVec3, corners: &[Ball; 3]) -> Ball {
    let [a, b, c] = corners;
    if let Some((gradient, normal)) = gradient(corners) {
        let height = (p - a.centre).dot(normal);
        let slope = (1.0 - gradient.length_squared()).sqrt();
        let x = p - normal * height + gradient * (height.abs() / slope);
        let inside = |p: DVec3, q: DVec3| (q - p).cross(x - p).dot(normal) >= 0.0;
        if inside(a.centre, b.centre) && inside(b.centre, c.centre) && inside(c.centre, a.centre) {
            return Ball {
                centre: x,
                radius: a.radius + gradient.dot(x - a.centre),
            };
        }
    }
    cone(p, a, b)
        .nearer(cone(p, b, c), p)
        .nearer(cone(p, c, a), p)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Least of the distances to many interpolated spheres.
    fn dense(p: DVec3, balls: &[Ball; 3]) -> f64 {
        const N: usize = 300;
        let mut best = f64::INFINITY;
        for i in 0..=N {
            for j in 0..=N - i {
                let (u, v) = (i as f64 / N as f64, j as f64 / N as f64);
                let [a, b, c] = balls;
                let mix = |a: f64, b: f64, c: f64| a + u * (b - a) + v * (c - a);
                let centre = a.centre + u * (b.centre - a.centre) + v * (c.centre - a.centre);
                best = best.min(p.distance(centre) - mix(a.radius, b.radius, c.radius));
            }
        }
        best
    }

    #[test]
    fn distances_agree_with_dense_spheres() {
        let ball = |x: f64, y: f64, z: f64, radius: f64| Ball {
            centre: DVec3::new(x, y, z),
            radius,
        };
        let (a, b, c) = (
            ball(0., 0., 0., 0.3),
            ball(1., 0.2, 0.1, 0.1),
            ball(0.2, 1.1, -0.2, 0.0),
        );
        let inner = ball(0.1, 0.1, 0.0, 0.05);
        let line = ball(0.5, 0.1, 0.05, 0.4);
        let steep = ball(0.1, 0.35, 0.0, 0.0);
        for corners in [
            [a, b, c],
            [a, b, inner],
            [a, b, line],
            [b, a, steep],
            [a, a, b],
            [c, c, c],
        ] {
            for i in 0..125 {
                let p =
                    DVec3::new((i % 5) as f64, (i / 5 % 5) as f64, (i / 25) as f64) * 0.45 - 0.5;
                let (exact, near) = (Solid::Slab(corners).distance(p), dense(p, &corners));
                assert!(
                    exact <= near + 1e-9 && near - exact < 0.006,
                    "{corners:?} {p} {exact} {near}"
                );
                let edge = [corners[0], corners[1], corners[1]];
                let (exact, near) = (Solid::Cone([edge[0], edge[1]]).distance(p), dense(p, &edge));
                assert!(
                    exact <= near + 1e-9 && near - exact < 0.006,
                    "{edge:?} {p} {exact} {near}"
                );
            }
        }
    }
}
