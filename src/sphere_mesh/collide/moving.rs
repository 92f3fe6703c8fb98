//! A sphere-mesh on its way from pose to pose, in single precision: what particles on a device collide with.

use super::{
    super::shape::{Ball, Shape, Solid},
    check_balls,
    pieces::Pieces,
};
use crate::{Error, Result, layout::particles::Primitive};

/// A shape whose spheres move while its edges and triangles stay.
#[derive(Clone, Debug)]
pub struct Moving {
    /// Spheres of each primitive, the last one repeated, and how many.
    rows: Vec<([u32; 3], usize)>,
    before: Vec<Ball>,
    balls: Vec<Ball>,
    primitives: Vec<Primitive>,
    size: f64,
    moves: bool,
}

impl Moving {
    /// The shape at rest.
    ///
    /// # Errors
    /// As [`Collider::new`](super::Collider::new); [`Error::Argument`] for spheres that single precision cannot hold.
    pub fn new(shape: &Shape) -> Result<Self> {
        shape.check_rows()?;
        let mut moving = Self {
            rows: shape.rows(),
            before: shape.balls.clone(),
            balls: shape.balls.clone(),
            primitives: Vec::new(),
            size: 0.0,
            moves: false,
        };
        moving.primitives.reserve_exact(moving.rows.len());
        moving.go_to(&shape.balls)?;
        Ok(moving)
    }

    /// The same shape with its spheres elsewhere, on its way there from where it was. Radii may differ by their rounding only:
    /// those of the new spheres count.
    ///
    /// # Errors
    /// [`Error::Argument`] for another number of spheres, and as [`Moving::new`]; nothing has changed then.
    pub fn go_to(&mut self, balls: &[Ball]) -> Result<()> {
        if balls.len() != self.balls.len() {
            let reason = format!("{}, but the shape has {}", balls.len(), self.balls.len());
            return Err(Error::argument("spheres", reason));
        }
        check_balls(balls)?;
        let large = |b: &Ball| b.centre.abs().max_element().max(b.radius) > GREATEST;
        if let Some(row) = balls.iter().position(large) {
            let reason = "single precision cannot hold it";
            return Err(Error::argument(format!("sphere {row}"), reason));
        }
        self.before.copy_from_slice(&self.balls);
        self.balls.copy_from_slice(balls);
        self.primitives.clear();
        for &(row, count) in &self.rows {
            let [now, before] = [&self.balls, &self.before].map(|b| row.map(|k| b[k as usize]));
            self.primitives.push(primitive(now, before, count));
        }
        self.moves = self.before != self.balls;
        self.size = super::size(balls);
        Ok(())
    }

    /// It did not get there: the next way begins where this one began.
    pub(crate) fn turn_back(&mut self) {
        self.balls.copy_from_slice(&self.before);
    }

    /// Its primitives with their way since the pose before.
    pub fn primitives(&self) -> &[Primitive] {
        &self.primitives
    }

    /// Its spheres in the pose that it goes to.
    pub fn balls(&self) -> &[Ball] {
        &self.balls
    }

    /// Diagonal of the box around all of them.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// It is not where it was.
    pub fn moves(&self) -> bool {
        self.moves
    }
}

/// Greatest coordinate or radius, so that squares of squares are finite in single precision.
const GREATEST: f64 = 1e8;

fn primitive(now: [Ball; 3], before: [Ball; 3], count: usize) -> Primitive {
    let [a, b, _] = now;
    let pieces = Pieces::new(match count {
        1 => Solid::Ball(a),
        2 => Solid::Cone([a, b]),
        _ => Solid::Slab(now),
    });
    let ball = |b: Ball| b.centre.as_vec3().extend(b.radius as f32).to_array();
    let way = |k: usize| (now[k].centre - before[k].centre).as_vec3();
    let longest = [0, 1, 2].map(|k| way(k).length());
    let mut bound = ball(pieces.bound);
    // No point comes further than the spheres, and what is rounded stays around all.
    bound[3] += longest.into_iter().fold(0.0, f32::max);
    bound[3] += 4.0 * f32::EPSILON * (bound[3] + pieces.bound.centre.abs().max_element() as f32);
    let (sides, sines, squares) = pieces.sides_of_f32();
    Primitive {
        bound,
        balls: now.map(ball),
        moves: [0, 1, 2].map(|k| way(k).extend(0.0).to_array()),
        sides,
        sines,
        squares,
        faces: pieces.faces_of_f32(),
    }
}
