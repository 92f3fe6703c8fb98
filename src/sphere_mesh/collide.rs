//! Moving spheres against a sphere-mesh (2016, section 6.1 and appendix B).

mod moving;
mod pieces;
#[cfg(test)]
mod tests;

use glam::DVec3;
use rayon::prelude::*;

pub use self::moving::Moving;
use self::pieces::{Line, Pieces};
use super::shape::{Ball, Shape};
use crate::{Error, Result};

/// A sphere that moves along a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Centre at time 0.
    pub from: DVec3,
    /// Centre at time 1.
    pub to: DVec3,
    /// Radius, 0 or more: at 0 a point moves.
    pub radius: f64,
}

/// Where a moving sphere first touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// 0 at the start of the segment, 1 at its end.
    pub time: f64,
    /// Centre of the moving sphere then: on its segment, or outside where it was pushed.
    pub position: DVec3,
    /// Outward normal of the sphere-mesh where they touch, of length 1.
    pub normal: DVec3,
    /// Whether it began inside and was pushed out; the time is 0 then.
    pub pushed: bool,
}

impl Hit {
    /// Where the sphere-mesh is touched, by a sphere of this radius.
    pub fn point(&self, radius: f64) -> DVec3 {
        self.position - self.normal * radius
    }
}

/// Greatest number, as a coordinate or radius: squares of squares must be finite.
const GREATEST: f64 = 1e60;

/// What counts as touching, against the size of the shape: less than that inside a sphere is on the surface.
const TOUCH: f64 = 1e-9;

/// A sphere-mesh in one frame, ready for collisions: spheres, capsules between two of them, thick triangles between three.
///
/// All of a sweep that is not already inside is tested exactly, however far and fast it goes; nothing tunnels through.
#[derive(Clone, Debug)]
pub struct Collider {
    pieces: Vec<Pieces>,
    /// The sphere around each, together in memory.
    bounds: Vec<Ball>,
    /// Diagonal of the box around all.
    size: f64,
}

impl Sweep {
    /// From a row of numbers, as files and C have them: where its centre begins, where it ends, its radius.
    pub fn of_row(&[a, b, c, d, e, f, radius]: &[f64; 7]) -> Self {
        Self {
            from: DVec3::new(a, b, c),
            to: DVec3::new(d, e, f),
            radius,
        }
    }

    /// What became of it as a row of numbers: the time, where its centre is then, the normal; infinity, the end of the segment and
    /// zeros where it touches nothing.
    pub fn row_of(&self, hit: Option<&Hit>) -> [f64; 7] {
        let (time, position, normal) = match hit {
            Some(hit) => (hit.time, hit.position, hit.normal),
            None => (f64::INFINITY, self.to, DVec3::ZERO),
        };
        let ([a, b, c], [d, e, f]) = (position.to_array(), normal.to_array());
        [time, a, b, c, d, e, f]
    }

    /// What is wrong with it.
    fn fault(&self) -> Option<&'static str> {
        let Self { from, to, radius } = self;
        let fits = |p: &DVec3| p.abs().max_element() <= GREATEST && !p.is_nan();
        if !fits(from) || !fits(to) {
            Some("a position is not finite or beyond 1e60")
        } else if !(*radius >= 0.0 && *radius <= GREATEST) {
            Some("the radius is negative, not finite or beyond 1e60")
        } else {
            None
        }
    }
}

impl Collider {
    /// Prepares a shape; one without spheres is never hit.
    ///
    /// # Errors
    /// [`Error::Argument`] naming a sphere that is not finite, is beyond 1e60 or has a negative radius, or an edge or triangle
    /// with a sphere that is not there.
    pub fn new(shape: &Shape) -> Result<Self> {
        check_balls(&shape.balls)?;
        shape.check_rows()?;
        let pieces: Vec<Pieces> = shape.solids().into_iter().map(Pieces::new).collect();
        Ok(Self {
            bounds: pieces.iter().map(|p| p.bound).collect(),
            pieces,
            size: size(&shape.balls),
        })
    }

    /// Spheres, capsules and thick triangles that every sweep is tested against: edges and triangles of the shape, and the
    /// spheres that neither has.
    pub fn primitives(&self) -> usize {
        self.pieces.len()
    }

    /// Where the sweep first touches; `None` where it does not, and for one that is not finite, is beyond 1e60 or has a
    /// negative radius.
    ///
    /// A sphere that begins inside of any primitive is pushed out along the normal of one of those that hold it, the one by
    /// which the way out of all is shortest. One that begins on the surface, to 1e-9 of the shape's size, touches at time 0 if
    /// it moves inwards and is free if it moves outwards: what has bounced goes on. A point on a sheet without thickness is free.
    pub fn first(&self, sweep: &Sweep) -> Option<Hit> {
        if sweep.fault().is_some() {
            return None;
        }
        let way = sweep.to - sweep.from;
        let direction = way.try_normalize().unwrap_or(DVec3::ZERO);
        let length = way.dot(direction);
        let line = Line {
            origin: sweep.from,
            direction,
            radius: sweep.radius,
        };
        let touch = self.touch(sweep);
        let (mut best, mut found) = (length, None);
        for (row, bound) in self.bounds.iter().enumerate() {
            let reach = bound.radius + sweep.radius + touch;
            let from = bound.centre - sweep.from;
            let along = from.dot(direction).max(0.0).min(best);
            if (from - direction * along).length_squared() > reach * reach {
                continue;
            }
            let pieces = &self.pieces[row];
            let enter = pieces.enter(&line);
            if enter > 0.0 && length > 0.0 {
                if enter <= best {
                    (best, found) = (enter, Some(row));
                }
            } else if from.length_squared() <= reach * reach {
                match pieces.start(&line, touch) {
                    Start::Inside => return self.push(sweep, touch),
                    Start::Entering => (best, found) = (0.0, Some(row)),
                    Start::Outside | Start::Leaving => {}
                }
            }
        }
        let pieces = &self.pieces[found?];
        let normal = if best == 0.0 {
            pieces.way_out(sweep.from)
        } else {
            pieces.normal(&line, best, true)
        };
        Some(Hit {
            time: if length > 0.0 { best / length } else { 0.0 },
            position: sweep.from + line.direction * best,
            normal,
            pushed: false,
        })
    }

    /// [`Collider::first`] of each, in parallel.
    ///
    /// # Errors
    /// [`Error::Argument`] naming the first row that is not finite, is beyond 1e60 or has a negative radius.
    pub fn first_of_each(&self, sweeps: &[Sweep]) -> Result<Vec<Option<Hit>>> {
        let fault = |(row, sweep): (usize, &Sweep)| Some((row, sweep.fault()?));
        if let Some((row, fault)) = sweeps.iter().enumerate().find_map(fault) {
            return Err(Error::argument(format!("row {row}"), fault));
        }
        let hits = sweeps.par_iter().with_min_len(256).map(|s| self.first(s));
        Ok(hits.collect())
    }

    /// Depth up to which a sweep is on the surface.
    fn touch(&self, sweep: &Sweep) -> f64 {
        let far = sweep.from.abs().max_element();
        TOUCH * (self.size + sweep.radius) + 4.0 * f64::EPSILON * far
    }

    /// Out of all primitives by the shortest of the ways along the normals of those that hold the start.
    fn push(&self, sweep: &Sweep, touch: f64) -> Option<Hit> {
        let holding = self.holding(sweep.from, sweep.radius, touch);
        let ways = holding.map(|row| self.leave(sweep, row, touch));
        let (_, hit) = ways.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(hit)
    }

    /// Primitives that a sphere is inside of.
    fn holding(&self, p: DVec3, radius: f64, touch: f64) -> impl Iterator<Item = usize> {
        let bounds = self.bounds.iter().enumerate();
        let holds = move |(row, bound): &(usize, &Ball)| {
            let reach = bound.radius + radius;
            p.distance_squared(bound.centre) <= reach * reach
                && self.pieces[*row].solid.distance(p) - radius < -touch
        };
        bounds.filter(holds).map(|(row, _)| row)
    }

    /// Out of all primitives along the normal of one, and how far that is. They are convex: none is left twice.
    fn leave(&self, sweep: &Sweep, first: usize, touch: f64) -> (f64, Hit) {
        let line = Line {
            origin: sweep.from,
            direction: self.pieces[first].way_out(sweep.from),
            radius: sweep.radius,
        };
        let (mut way, mut last) = (0.0, first);
        loop {
            let p = line.origin + line.direction * way;
            let holding = self.holding(p, sweep.radius, touch);
            let ends = holding.map(|row| (self.pieces[row].leave(&line), row));
            let Some(next) = ends.max_by(|a, b| a.0.total_cmp(&b.0)) else {
                break;
            };
            if next.0 <= way {
                break;
            }
            (way, last) = next;
        }
        let hit = Hit {
            time: 0.0,
            position: line.origin + line.direction * way,
            normal: self.pieces[last].normal(&line, way, false),
            pushed: true,
        };
        (way, hit)
    }
}

/// # Errors
/// [`Error::Argument`] naming a sphere that is not finite, is beyond 1e60 or has a negative radius.
fn check_balls(balls: &[Ball]) -> Result<()> {
    for (row, ball) in balls.iter().enumerate() {
        let sweep = Sweep {
            from: ball.centre,
            to: ball.centre,
            radius: ball.radius,
        };
        if let Some(fault) = sweep.fault() {
            return Err(Error::argument(format!("sphere {row}"), fault));
        }
    }
    Ok(())
}

/// Diagonal of the box around all; 0 for none.
fn size(balls: &[Ball]) -> f64 {
    let mut ends = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    for ball in balls {
        ends[0] = ends[0].min(ball.centre - ball.radius);
        ends[1] = ends[1].max(ball.centre + ball.radius);
    }
    (ends[1] - ends[0]).max(DVec3::ZERO).length()
}

/// How a sweep begins.
enum Start {
    Outside,
    Inside,
    /// On the surface, going in.
    Entering,
    /// On the surface, going out: convex, the solid is not met again.
    Leaving,
}

impl Pieces {
    fn start(&self, line: &Line, touch: f64) -> Start {
        let nearest = self.solid.nearest(line.origin);
        let depth = line.radius - nearest.distance(line.origin);
        if depth > touch {
            Start::Inside
        } else if depth < -touch {
            Start::Outside
        } else if nearest.radius + line.radius <= 2.0 * touch {
            // A point on a sheet or wire without thickness: neither side is inside.
            Start::Leaving
        } else if line.direction.dot(self.way_out(line.origin)) < 0.0 {
            Start::Entering
        } else {
            Start::Leaving
        }
    }
}
