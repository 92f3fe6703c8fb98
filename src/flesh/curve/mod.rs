//! Curves that a spine can follow, in their own parameter.

mod bspline;
mod neville;
mod polyline;
mod round;

use glam::DVec3;

use crate::{Error, Result};
use bspline::BSpline;
use neville::Polynomial;
use polyline::Polyline;
use round::Helix;

/// Fewest and most points of an interpolating polynomial: it swings between points that are many.
const POLYNOMIAL_POINTS: usize = 16;
/// Most points of all other curves.
const POINTS: usize = 100_000;
/// Lengths whose squares are numbers.
const LENGTHS: std::ops::Range<f64> = 1e-140..1e140;
/// Points of which the first is this near to the last, in shares of the length, make a ring.
const CLOSED: f64 = 1e-9;

/// Shape of a spine, in units of the mesh.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// The polynomial through 2 to 16 points, at parameters by their distances (Neville's algorithm).
    Polynomial(Vec<DVec3>),
    /// The quintic B-spline through the points, with knots by their distances; four times continuously differentiable. Fewer
    /// than six points: the polynomial. A last point that repeats the first closes it.
    BSpline(Vec<DVec3>),
    /// A smooth curve through densely given points: twice continuously differentiable, each stretch from the four points
    /// nearest to either end only. Repeated points count once. A last point that repeats the first closes it.
    Polyline(Vec<DVec3>),
    /// A circular arc; a full circle is closed.
    Arc(Round),
    /// A helix, right-handed for a positive pitch.
    Helix {
        /// Circle that it winds over.
        round: Round,
        /// Rise of a turn along the axis.
        pitch: f64,
    },
}

/// Circular arcs and helices: where they start and how they go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Round {
    /// First point.
    pub start: DVec3,
    /// Direction of the curve there, of any length.
    pub tangent: DVec3,
    /// From there to the centre or the axis, of any length; what it has along the tangent is left out.
    pub normal: DVec3,
    /// Distance to the centre or the axis.
    pub radius: f64,
    /// Length along the curve.
    pub length: f64,
}

/// Point and derivatives by the curve's own parameter.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Jet {
    pub(super) point: DVec3,
    pub(super) first: DVec3,
    pub(super) second: DVec3,
}

/// A curve in its own parameter.
pub(super) trait Path: Sync {
    /// Parameters between which the curve is smooth, ascending: ends and breaks.
    fn breaks(&self) -> Vec<f64>;
    /// At a parameter between the first and the last break.
    fn jet(&self, parameter: f64) -> Jet;
}

impl Curve {
    /// The curve, and whether it is closed.
    pub(super) fn path(&self) -> Result<(Box<dyn Path>, bool)> {
        match self {
            Self::Polynomial(points) => {
                check(points, POLYNOMIAL_POINTS, "; use a B-spline")?;
                Ok((Box::new(Polynomial::new(points)), false))
            }
            Self::BSpline(points) => {
                check(points, POINTS, "")?;
                let ring = ring(points);
                let spline = match ring {
                    Some(ring) => BSpline::closed(ring),
                    None => BSpline::open(points),
                };
                Ok((Box::new(spline), ring.is_some()))
            }
            Self::Polyline(points) => {
                finite(points)?;
                let points = distinct(points);
                check(&points, POINTS, "")?;
                let ring = ring(&points);
                let line = Polyline::new(ring.unwrap_or(&points), ring.is_some());
                Ok((Box::new(line), ring.is_some()))
            }
            Self::Arc(round) => {
                let arc = Helix::new(round, 0.0)?;
                Ok((Box::new(arc), round.closed()?))
            }
            Self::Helix { round, pitch } => {
                let helix = Helix::new(round, *pitch)?;
                Ok((Box::new(helix), *pitch == 0.0 && round.closed()?))
            }
        }
    }
}

/// Refuses points that no curve goes through.
fn check(points: &[DVec3], most: usize, advice: &str) -> Result<()> {
    if points.len() < 2 || points.len() > most {
        let reason = format!("{} given, it takes 2 to {most}{advice}", points.len());
        return Err(Error::argument("points", reason));
    }
    finite(points)?;
    if let Some(row) = points.windows(2).position(|p| p[0] == p[1]) {
        let reason = "is the same as the point before it";
        return Err(Error::argument(format!("points/{}", row + 1), reason));
    }
    let chords = chords(points);
    let length = chords[chords.len() - 1];
    if !LENGTHS.contains(&length) {
        let reason = format!("the curve is {length} long, which cannot be used");
        return Err(Error::argument("points", reason));
    }
    match chords.windows(2).position(|c| c[1] <= c[0]) {
        Some(row) => Err(Error::argument(
            format!("points/{}", row + 1),
            "is too close to the point before it",
        )),
        None => Ok(()),
    }
}

fn finite(points: &[DVec3]) -> Result<()> {
    match points.iter().position(|p| !p.is_finite()) {
        Some(row) => Err(Error::argument(format!("points/{row}"), "is not finite")),
        None => Ok(()),
    }
}

fn distinct(points: &[DVec3]) -> Vec<DVec3> {
    let mut points = points.to_vec();
    points.dedup();
    points
}

/// The points of a ring, each once; none where the ends are apart.
fn ring(points: &[DVec3]) -> Option<&[DVec3]> {
    let (first, last) = (points.first()?, points.last()?);
    let length = chords(points).last().copied()?;
    let met = first.distance(*last) <= CLOSED * length && points.len() >= 4;
    met.then(|| &points[..points.len() - 1])
}

/// Parameters of points by their distances, from 0.
fn chords(points: &[DVec3]) -> Vec<f64> {
    let mut sum = 0.0;
    let step = |pair: &[DVec3]| {
        sum += pair[0].distance(pair[1]);
        sum
    };
    std::iter::once(0.0)
        .chain(points.windows(2).map(step))
        .collect()
}
