//! Spines: curves by arc length with a frame that does not turn.

use glam::{DQuat, DVec2, DVec3};

use super::{
    curve::{Curve, Jet},
    frame,
    hermite::{Cubic, Quintic},
    length::{ArcLength, RunOut},
    search::Search,
    twist::Twist,
};
use crate::{Error, Result};

/// Fewest and most cells of a spine between its ends.
const CELLS: std::ops::RangeInclusive<usize> = 64..=8192;
/// Cells are halved until tangents in their middles are this exact.
const EXACT: f64 = 1e-10;
/// Curves whose tangents the finest cells but one miss by more turn too sharply.
const ROUGH: f64 = 1e-3;
/// Most that curvature may need past an end to ease to zero, in shares of the length.
const EASE: f64 = 0.125;

/// What a spine is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct SpineDesc {
    /// Its shape.
    pub curve: Curve,
    /// Where the first frame vector points at the start, as far as it is across the spine. Without it +z, or +y where the
    /// spine starts within 8 degrees of the z axis; [`Spine::like`] has another rule.
    pub up: Option<DVec3>,
    /// Turn of the frame about the spine.
    pub twist: Twist,
    /// How far past either end curvature takes to ease to zero, as a share of the length, up to 1/8; straight from there on.
    /// With 0 the spine is straight from its ends on: where it ends in a bend, the deformation has a step there.
    pub ease: f64,
}

impl SpineDesc {
    /// A spine of this shape, by default.
    pub fn new(curve: Curve) -> Self {
        Self {
            curve,
            up: None,
            twist: Twist::default(),
            ease: EASE,
        }
    }
}

/// A curve by arc length `s`, from 0 to its length, with a frame across it.
///
/// The curve is sampled at even steps of arc length, as fine as its tangents ask for, and is a quintic between samples that has
/// their points, tangents and curvature vectors: twice continuously differentiable, and by arc length to about 1e-12 (1e-8 where the curvature eases past an end). Its frame
/// is carried along by double reflection (Wang et al. 2008), turned by the twist.
///
/// Before 0 and past the length an open spine goes on: its curvature eases to zero within [`SpineDesc::ease`], then it is
/// straight, so that what sticks out is moved rigidly. A closed one comes round again.
#[derive(Clone, Debug)]
pub struct Spine {
    cells: Vec<Cell>,
    /// Arc length of a cell.
    step: f64,
    /// Arc length where the first cell begins.
    begin: f64,
    length: f64,
    closed: bool,
    /// The first frame vector at the start, before it is twisted.
    first: DVec3,
    pub(super) search: Search,
}

/// Curve and first frame vector between two samples.
#[derive(Clone, Copy, Debug)]
struct Cell {
    curve: Quintic,
    side: Cubic,
}

/// A piece of a spine as plain numbers: polynomials of `u`, from 0 to 1 over a step of arc length, coefficients by rising power.
///
/// What [`Spine::section`] makes of them can be made anywhere: tangent and curvature vector are derivatives of the curve, the
/// first frame vector is `side` without its part along the tangent, normalised.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct SpineCell {
    /// Point on the curve.
    pub curve: [[f64; 3]; 6],
    /// First frame vector, nearly.
    pub side: [[f64; 3]; 4],
}

/// A spine at one arc length: all that [`bend`](super::bend) asks of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Point on the curve.
    pub position: DVec3,
    /// Unit tangent.
    pub tangent: DVec3,
    /// First frame vector, unit, across the tangent.
    pub side: DVec3,
    /// Second frame vector, tangent × side.
    pub lift: DVec3,
    /// Curvature vector, to the centre of curvature, in the frame.
    pub curvature: DVec2,
    /// Its derivative by arc length.
    pub curvature_rate: DVec2,
    /// Turn of the frame about the tangent, radians by arc length.
    pub twist_rate: f64,
}

impl Section {
    /// A point of the cross-section.
    #[inline]
    pub fn point(&self, offset: DVec2) -> DVec3 {
        self.position + offset.x * self.side + offset.y * self.lift
    }
}

impl Spine {
    /// Prepares a spine.
    ///
    /// # Errors
    /// [`Error::Argument`] naming the entry (as in a file: `points/3`, `radius`) that is not finite, the curve that has no
    /// length or a cusp, an `up` along the spine.
    pub fn new(desc: &SpineDesc) -> Result<Self> {
        Self::build(desc, |tangent| {
            let upright = tangent.z.abs() < 0.99;
            let up = if upright { DVec3::Z } else { DVec3::Y };
            up.reject_from_normalized(tangent).normalize()
        })
    }

    /// Prepares a spine that another is bent to: without an `up` its frame starts as that of `rest` does before its twist, turned from the one
    /// tangent to the other by the shortest way.
    ///
    /// # Errors
    /// As [`Spine::new`].
    pub fn like(desc: &SpineDesc, rest: &Self) -> Result<Self> {
        let start = rest.section(0.0).tangent;
        Self::build(desc, |tangent| {
            let turned = DQuat::from_rotation_arc(start, tangent) * rest.first;
            turned.reject_from_normalized(tangent).normalize()
        })
    }

    fn build(desc: &SpineDesc, otherwise: impl Fn(DVec3) -> DVec3) -> Result<Self> {
        if !(0.0..=EASE).contains(&desc.ease) {
            let reason = format!("{} is not from 0 to {EASE}", desc.ease);
            return Err(Error::argument("ease", reason));
        }
        let (path, closed) = desc.curve.path()?;
        desc.twist.check(closed)?;
        let arc = ArcLength::new(&*path)?;
        let (samples, cells) = samples(&arc)?;
        let length = arc.length();
        let step = length / cells as f64;
        let first = match desc.up {
            Some(up) => across(up, samples[0].first)?,
            None => otherwise(samples[0].first),
        };
        let (samples, before) = match closed {
            true => (samples, 0),
            false => run_out(samples, (desc.ease * cells as f64).round() as usize, step),
        };
        let curves: Vec<Quintic> = samples
            .windows(2)
            .map(|pair| Quintic::new(&pair[0], &pair[1], step))
            .collect();
        let mut sides = frame::carry(&curves, &samples, before, first);
        let turn = |row: usize| {
            let share = (row as f64 - before as f64) / cells as f64;
            let (angle, rate) = desc.twist.at(share.clamp(0.0, 1.0));
            (angle, rate / length)
        };
        let rates = frame::twist(&mut sides, &samples, closed.then_some(length), turn);
        let side = |row: usize| {
            let (t, k, i) = (samples[row].first, samples[row].second, sides[row]);
            (i, rates[row] * t.cross(i) - k.dot(i) * t)
        };
        let cells: Vec<Cell> = curves
            .iter()
            .enumerate()
            .map(|(row, curve)| Cell {
                curve: *curve,
                side: Cubic::new(side(row), side(row + 1), step),
            })
            .collect();
        let begin = -(before as f64) * step;
        let search = Search::new(&samples, step, begin, closed);
        Ok(Self {
            cells,
            step,
            begin,
            length,
            closed,
            first,
            search,
        })
    }

    /// Arc length from the start to the end.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Whether the end is the start.
    pub fn closed(&self) -> bool {
        self.closed
    }

    /// Arc lengths where the sampled curve begins and ends; it is straight beyond.
    pub fn reach(&self) -> [f64; 2] {
        [self.begin, self.begin + self.step * self.cells.len() as f64]
    }

    /// Arc length of a cell.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// All cells, from the first of [`Spine::reach`] to the second.
    pub fn cells(&self) -> impl ExactSizeIterator<Item = SpineCell> {
        self.cells.iter().map(|cell| SpineCell {
            curve: cell.curve.0.map(|c| c.to_array()),
            side: cell.side.0.map(|c| c.to_array()),
        })
    }

    /// The cell, the share of it, and how far an arc length is past its end.
    #[inline]
    fn locate(&self, s: f64) -> (&Cell, f64, f64) {
        let s = match self.closed {
            true => s - self.length * (s / self.length).floor(),
            false => s,
        };
        let x = (s - self.begin) / self.step;
        let row = (x as usize).min(self.cells.len() - 1);
        let u = (x - row as f64).clamp(0.0, 1.0);
        let past = match self.closed {
            true => 0.0,
            false => (x - row as f64 - u) * self.step,
        };
        (&self.cells[row], u, past)
    }

    /// Point, unit tangent and curvature vector; arc length within [`Spine::reach`].
    #[inline]
    pub(super) fn jet(&self, s: f64) -> Jet {
        let (cell, u, _) = self.locate(s);
        let (jet, _) = cell.curve.at(u, self.step);
        arc(jet)
    }

    /// Point and frame at an arc length, which may lie past the ends; finite for all finite ones.
    #[inline]
    pub fn section(&self, s: f64) -> Section {
        let (cell, u, past) = self.locate(s);
        let (jet, third) = cell.curve.at(u, self.step);
        let jet = arc(jet);
        let tangent = jet.first;
        let (raw, rate) = cell.side.at(u, self.step);
        let along = raw.dot(tangent);
        let side = raw - along * tangent;
        let size = side.length();
        let side = side / size;
        let lift = tangent.cross(side);
        let plane = |v: DVec3| DVec2::new(v.dot(side), v.dot(lift));
        let mut section = Section {
            position: jet.point,
            tangent,
            side,
            lift,
            curvature: plane(jet.second),
            curvature_rate: DVec2::ZERO,
            twist_rate: 0.0,
        };
        if past == 0.0 {
            section.twist_rate = (rate - along * jet.second).dot(lift) / size;
            // The frame turns under the vector.
            let turned = DVec2::new(section.curvature.y, -section.curvature.x);
            section.curvature_rate = plane(third) + section.twist_rate * turned;
        } else {
            section.position += past * tangent;
            section.curvature = DVec2::ZERO;
        }
        section
    }
}

/// What is across the tangent of a direction.
fn across(up: DVec3, tangent: DVec3) -> Result<DVec3> {
    let Some(up) = up.try_normalize() else {
        return Err(Error::argument("up", "has no direction"));
    };
    let across = up.reject_from_normalized(tangent);
    match across.length() > 1e-6 {
        true => Ok(across.normalize()),
        false => Err(Error::argument("up", "is along the start of the spine")),
    }
}

/// By arc length, whatever is left of another speed.
#[inline]
fn arc(jet: Jet) -> Jet {
    let rate = 1.0 / jet.first.length();
    let first = rate * jet.first;
    Jet {
        point: jet.point,
        first,
        second: rate * rate * (jet.second - jet.second.dot(first) * first),
    }
}

/// Samples at even steps, as fine as it takes, and the number of cells between them.
fn samples(arc: &ArcLength<'_>) -> Result<(Vec<Jet>, usize)> {
    let length = arc.length();
    let at = |row: usize, cells: usize| arc.at(length * row as f64 / cells as f64);
    let mut cells = *CELLS.start();
    let mut samples = (0..=cells)
        .map(|i| at(i, cells))
        .collect::<Result<Vec<_>>>()?;
    loop {
        let middles = (0..cells)
            .map(|i| at(2 * i + 1, 2 * cells))
            .collect::<Result<Vec<_>>>()?;
        let step = length / cells as f64;
        let miss = |(pair, middle): (&[Jet], &Jet)| {
            let (jet, _) = Quintic::new(&pair[0], &pair[1], step).at(0.5, step);
            jet.first.distance(middle.first)
        };
        let worst = samples.windows(2).zip(&middles).map(miss);
        // What is no number stays.
        let worst = worst.fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a });
        let last = samples[cells];
        samples = samples
            .iter()
            .zip(&middles)
            .flat_map(|(a, b)| [*a, *b])
            .chain([last])
            .collect();
        cells *= 2;
        if worst < EXACT {
            return Ok((samples, cells));
        }
        if cells >= *CELLS.end() {
            let reason = format!("the curve turns too sharply or too often for {cells} samples");
            return match worst < ROUGH {
                true => Ok((samples, cells)),
                false => Err(Error::argument("points", reason)),
            };
        }
    }
}

/// Adds `count` samples past either end.
fn run_out(samples: Vec<Jet>, count: usize, step: f64) -> (Vec<Jet>, usize) {
    if count == 0 {
        return (samples, 0);
    }
    let back = |jet: Jet| Jet {
        first: -jet.first,
        ..jet
    };
    let reach = count as f64 * step;
    let before = RunOut::new(back(samples[0]), reach);
    let after = RunOut::new(samples[samples.len() - 1], reach);
    let before = (1..=count).rev().map(|i| back(before.at(i as f64 * step)));
    let after = (1..=count).map(|i| after.at(i as f64 * step));
    (before.chain(samples).chain(after).collect(), count)
}
