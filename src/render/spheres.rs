//! Sphere-meshes as they are drawn: spheres, cones between two of them, slabs between three.

use std::collections::BTreeSet;

use glam::{DVec3, Vec3, Vec4};

use super::{Bounds, Camera, Projection};
use crate::{
    Error, Result,
    sphere_mesh::{Ball, Shape},
};

/// Colour of a skeleton's wires and sheets, linear.
const WIRE: Vec3 = Vec3::new(0.05, 0.055, 0.065);
/// Opacity of a skeleton's sheets.
const FAINT: f32 = 0.3;
/// A wire is this much thinner than a skeleton's spheres.
const THIN: f64 = 0.3;

/// Spheres and what is interpolated between them, with a colour a sphere; drawn exactly by
/// [`Renderer::draw_with`](super::Renderer::draw_with), not as triangles.
///
/// Any number of shapes and loose spheres go into one picture. Where two spheres are joined, each point has the colour of
/// the one that is nearer along the axis; a slab is divided in three alike. Spheres and wires of radius 0 are too thin to be
/// seen, sheets are not.
#[derive(Clone, Debug, Default)]
pub struct Spheres {
    /// Centres and radii.
    pub(super) balls: Vec<Vec4>,
    /// Linear RGB and opacity of each.
    pub(super) colours: Vec<Vec4>,
    /// Rows of one to three balls, and their number.
    pub(super) primitives: Vec<[u32; 4]>,
}

impl Spheres {
    /// Adds a shape's surface, with the linear RGB of each of its spheres.
    ///
    /// # Errors
    /// [`Error::Argument`] naming a sphere that is not finite or has a negative radius, an edge or triangle with a sphere that
    /// is not there, or colours that are not finite or not as many as spheres.
    pub fn surface(&mut self, shape: &Shape, colours: &[Vec3]) -> Result<()> {
        check(shape)?;
        let first = self.add(&shape.balls, colours, 1.0)?;
        self.wires(shape, first);
        self.sheets(shape, first);
        Ok(())
    }

    /// Adds a shape's skeleton: its spheres with this radius, in their colours, wires along its edges and faint sheets in its
    /// triangles.
    ///
    /// # Errors
    /// As [`Spheres::surface`].
    pub fn skeleton(&mut self, shape: &Shape, colours: &[Vec3], radius: f64) -> Result<()> {
        check(shape)?;
        let resized = |radius: f64| -> Vec<Ball> {
            let centres = shape.balls.iter().map(|b| b.centre);
            centres.map(|centre| Ball { centre, radius }).collect()
        };
        let plain = vec![WIRE; shape.balls.len()];
        self.loose(&resized(radius), colours)?;
        let first = self.add(&resized(THIN * radius), &plain, 1.0)?;
        self.wires(shape, first);
        let first = self.add(&resized(0.0), colours, FAINT)?;
        self.sheets(shape, first);
        Ok(())
    }

    /// Adds spheres that nothing joins, such as particles.
    ///
    /// # Errors
    /// As [`Spheres::surface`].
    pub fn loose(&mut self, balls: &[Ball], colours: &[Vec3]) -> Result<()> {
        self.add(balls, colours, 1.0).map(drop)
    }

    /// How far all of them reach.
    pub fn bounds(&self) -> Bounds {
        Bounds::of_balls(self.balls.iter().map(|b| (b.truncate(), b.w)))
    }

    /// Adds spheres, those that are seen as primitives, and returns the row of the first.
    fn add(&mut self, balls: &[Ball], colours: &[Vec3], opacity: f32) -> Result<u32> {
        if colours.len() != balls.len() {
            let reason = format!("{} rows for {} spheres", colours.len(), balls.len());
            return Err(Error::argument("colours", reason));
        }
        if let Some(row) = colours.iter().position(|c| !c.is_finite()) {
            let reason = format!("row {row} is {}", colours[row]);
            return Err(Error::argument("colours", reason));
        }
        balls.iter().enumerate().try_for_each(check_ball)?;
        let first = self.balls.len() as u32;
        for (row, ball) in (first..).zip(balls) {
            if ball.radius > 0.0 {
                self.primitives.push([row, row, row, 1]);
            }
        }
        let packed = balls.iter().map(pack);
        self.balls.extend(packed);
        self.colours
            .extend(colours.iter().map(|c| c.extend(opacity)));
        Ok(first)
    }

    /// The cones of all edges, those of triangles among them.
    fn wires(&mut self, shape: &Shape, first: u32) {
        let sides = shape.triangles.iter();
        let sides = sides.flat_map(|&[a, b, c]| [[a, b], [b, c], [a, c]]);
        let edges = shape.edges.iter().copied().chain(sides);
        let edges: BTreeSet<[u32; 2]> = edges.map(|[a, b]| [a.min(b), a.max(b)]).collect();
        let cones = edges.iter().map(|e| e.map(|row| row + first));
        let seen = cones.filter(|e| e.iter().any(|&row| self.balls[row as usize].w > 0.0));
        let seen = seen.map(|[a, b]| [a, b, a, 2]).collect::<Vec<_>>();
        self.primitives.extend(seen);
    }

    fn sheets(&mut self, shape: &Shape, first: u32) {
        let slab = |t: &[u32; 3]| [t[0] + first, t[1] + first, t[2] + first, 3];
        self.primitives.extend(shape.triangles.iter().map(slab));
    }

    /// The primitives in the order in which they are drawn: what can be seen through last, from far to near.
    pub(super) fn ordered(&self, camera: &Camera) -> Vec<[u32; 4]> {
        let through = |p: &[u32; 4]| self.colours[p[0] as usize].w < 1.0;
        let [_, _, back] = camera.axes();
        let nearness = |p: &[u32; 4]| {
            let corners = p[..3].iter().map(|&row| self.balls[row as usize]);
            let middle = corners.map(Vec4::truncate).sum::<Vec3>() / 3.0;
            match camera.projection {
                Projection::Perspective { .. } => -middle.distance(camera.eye),
                Projection::Orthographic { .. } => middle.dot(back),
            }
        };
        let (mut last, mut all): (Vec<_>, Vec<_>) =
            self.primitives.iter().partition(|p| through(p));
        last.sort_by(|a, b| nearness(a).total_cmp(&nearness(b)));
        all.append(&mut last);
        all
    }
}

fn pack(ball: &Ball) -> Vec4 {
    ball.centre.as_vec3().extend(ball.radius as f32)
}

fn check_ball((row, ball): (usize, &Ball)) -> Result<()> {
    let finite = pack(ball).is_finite();
    if finite && ball.radius >= 0.0 {
        return Ok(());
    }
    let DVec3 { x, y, z } = ball.centre;
    let reason = format!("radius {} at {x}, {y}, {z}", ball.radius);
    Err(Error::argument(format!("sphere {row}"), reason))
}

/// Spheres are such, and edges and triangles name those that there are.
fn check(shape: &Shape) -> Result<()> {
    shape.balls.iter().enumerate().try_for_each(check_ball)?;
    shape.check_rows()
}
