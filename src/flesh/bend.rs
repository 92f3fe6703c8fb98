//! Bending: registered points on another spine.

use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;

use super::{
    map::Map,
    register::{Anchor, PAST_BENT_LIMIT, Registration, Tilt, basis},
    spine::{Section, Spine},
};
use crate::{Error, Result};

const CHUNK: usize = 1024;
/// Rings whose lengths differ by less than this share fit each other.
const SAME: f64 = 1e-6;

/// How points follow the bent spine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BendOptions {
    /// From 0, plain skinning by the frames, to 1.
    pub strength: f64,
    /// How far along a bent spine that is longer, or shorter, from 0, starts aligned, to 1, ends aligned. Around a closed one
    /// under an open one: once around.
    pub slide: f64,
    /// Without: arc length is kept, and what sticks out of a shorter spine goes on past its end. With: arc length is scaled to
    /// that of the bent spine, and cross-sections with the inverse root of it, so that volume is kept.
    pub stretch: bool,
}

impl Default for BendOptions {
    fn default() -> Self {
        Self {
            strength: 1.0,
            slide: 0.0,
            stretch: false,
        }
    }
}

/// Bent points, a row each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bent {
    /// Positions.
    pub positions: Vec<DVec3>,
    /// Unit normals, or zero for a normal of zero; empty without normals.
    pub normals: Vec<DVec3>,
    /// Distance to the nearer of the map's limits at the rest and the bent spine, in units of the mesh: negative past it,
    /// infinite where both are straight.
    pub distances: Vec<f64>,
    /// Flags of registration and [`PAST_BENT_LIMIT`].
    pub flags: Vec<u32>,
}

/// From arc length and offset of rest to those of one bent spine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The map.
    pub map: Map,
    /// From 0 to 1.
    pub strength: f64,
    /// Arc length on the bent spine is `scale` times that of rest, plus `shift`.
    pub scale: f64,
    /// See `scale`.
    pub shift: f64,
    /// Scale of straight offsets.
    pub across: f64,
}

impl Placement {
    /// # Errors
    /// [`Error::Argument`] for options out of range, a closed rest spine that would be torn open, or two rings of unequal length
    /// without stretch.
    pub fn new(rest: &Registration, bent: &Spine, options: &BendOptions) -> Result<Self> {
        for (name, value) in [("strength", options.strength), ("slide", options.slide)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(Error::argument(name, format!("{value} is not from 0 to 1")));
            }
        }
        let ratio = bent.length() / rest.length;
        if rest.closed && !bent.closed() {
            let reason = "a closed rest spine needs a closed bent one: the shape would be torn";
            return Err(Error::argument("bent", reason));
        }
        if rest.closed && !options.stretch && (ratio - 1.0).abs() > SAME {
            let reason = format!(
                "closed spines are {} and {} long: make them equal, or stretch",
                rest.length,
                bent.length()
            );
            return Err(Error::argument("bent", reason));
        }
        // Rings of nearly one length have to meet exactly.
        let stretch = options.stretch || rest.closed;
        let scale = if stretch { ratio } else { 1.0 };
        let way = match bent.closed() {
            true => bent.length(),
            false => bent.length() - scale * rest.length,
        };
        Ok(Self {
            map: rest.map,
            strength: options.strength,
            scale,
            shift: options.slide * way,
            across: scale.sqrt().recip(),
        })
    }

    /// Arc length on the bent spine.
    #[inline]
    pub fn arc(&self, anchor: &Anchor) -> f64 {
        self.scale * anchor.arc + self.shift
    }

    /// The bent point, and its distance to the map's limit at the bent spine as a share of the radius of curvature.
    #[inline]
    pub fn point(&self, anchor: &Anchor, section: &Section) -> (DVec3, f64) {
        let straight = self.across * DVec2::from_array(anchor.straight);
        let bent = self
            .map
            .bend(straight, section.curvature, DVec2::ZERO)
            .offset;
        let plain = DVec2::from_array(anchor.offset);
        let room = self.map.room(bent, section.curvature);
        (section.point(plain.lerp(bent, self.strength)), room)
    }

    /// The bent unit normal, by the inverse transposed Jacobian of the whole map: of covector c and columns a, b, c' of the
    /// Jacobian that is (c0 b × c' + c1 c' × a + c2 a × b) / det.
    #[inline]
    pub fn normal(&self, anchor: &Anchor, tilt: &Tilt, section: &Section) -> DVec3 {
        let straight = self.across * DVec2::from_array(anchor.straight);
        let bent = self
            .map
            .bend(straight, section.curvature, section.curvature_rate);
        let chain = self.across * bent.by_offset;
        let by = chain * DMat2::from_cols_array_2d(&tilt.by_offset);
        // By arc length at rest.
        let along = chain * DVec2::from_array(tilt.along) / self.scale + bent.along;
        let (plain, share) = (DVec2::from_array(anchor.offset), self.strength);
        let by = (1.0 - share) * DMat2::IDENTITY + share * by;
        let [a, b, c] = basis(section, plain.lerp(bent.offset, share), by, share * along);
        let a = self.scale * a;
        let [x, y, z] = tilt.covector;
        let sum = x * b.cross(c) + y * c.cross(a) + z * a.cross(b);
        let turned = if a.dot(b.cross(c)) < 0.0 { -sum } else { sum };
        turned.normalize_or_zero()
    }
}

/// Bends registered points.
///
/// # Errors
/// As [`Placement::new`].
pub fn bend(rest: &Registration, bent: &Spine, options: &BendOptions) -> Result<Bent> {
    let placement = Placement::new(rest, bent, options)?;
    let count = rest.anchors.len();
    let mut out = Bent {
        positions: vec![DVec3::ZERO; count],
        normals: vec![DVec3::ZERO; rest.tilts.len()],
        distances: vec![0.0; count],
        flags: vec![0; count],
    };
    bend_into(rest, bent, &placement, &mut out);
    Ok(out)
}

/// The same into arrays of the right lengths, without allocating.
///
/// # Errors
/// As [`Placement::new`].
pub fn bend_again(
    rest: &Registration,
    bent: &Spine,
    options: &BendOptions,
    out: &mut Bent,
) -> Result<()> {
    let placement = Placement::new(rest, bent, options)?;
    let count = rest.anchors.len();
    out.positions.resize(count, DVec3::ZERO);
    out.normals.resize(rest.tilts.len(), DVec3::ZERO);
    out.distances.resize(count, 0.0);
    out.flags.resize(count, 0);
    bend_into(rest, bent, &placement, out);
    Ok(())
}

fn bend_into(rest: &Registration, bent: &Spine, placement: &Placement, out: &mut Bent) {
    let point = |anchor: &Anchor, section: &Section| {
        let (position, room) = placement.point(anchor, section);
        let distance = anchor.distance.min(room / section.curvature.length());
        let flag = if room <= 0.0 { PAST_BENT_LIMIT } else { 0 };
        (position, distance, anchor.flags | flag)
    };
    let rows = out
        .positions
        .par_chunks_mut(CHUNK)
        .zip(out.distances.par_chunks_mut(CHUNK))
        .zip(out.flags.par_chunks_mut(CHUNK))
        .zip(rest.anchors.par_chunks(CHUNK));
    if rest.tilts.is_empty() {
        rows.for_each(|(((positions, distances), flags), anchors)| {
            for (row, anchor) in anchors.iter().enumerate() {
                let section = bent.section(placement.arc(anchor));
                (positions[row], distances[row], flags[row]) = point(anchor, &section);
            }
        });
        return;
    }
    let normals = out.normals.par_chunks_mut(CHUNK);
    let rows = rows.zip(normals.zip(rest.tilts.par_chunks(CHUNK)));
    rows.for_each(
        |((((positions, distances), flags), anchors), (normals, tilts))| {
            for (row, anchor) in anchors.iter().enumerate() {
                let section = bent.section(placement.arc(anchor));
                (positions[row], distances[row], flags[row]) = point(anchor, &section);
                normals[row] = placement.normal(anchor, &tilts[row], &section);
            }
        },
    );
}
