//! Registration: where points are along and across a spine, once for all ways to bend it.

use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;

use super::{
    map::Map,
    spine::{Section, Spine},
};
use crate::{Error, Result};

/// Points that a thread takes at a time.
const CHUNK: usize = 1024;

/// Flag of a point: it is past the limit of the map at the rest spine, on or beyond the axis of curvature.
pub const PAST_REST_LIMIT: u32 = 1;
/// Flag of a point: it is past the limit of the map at the bent spine.
pub const PAST_BENT_LIMIT: u32 = 2;
/// Flag of a point: another part of the rest spine is as near within a hundredth; what is around it may be torn.
pub const AMBIGUOUS: u32 = 4;
/// Flag of a point: it is beyond an end of the rest spine. Nothing is wrong with it.
pub const PAST_END: u32 = 8;
/// Flags of points around which volume may not be kept.
pub const INVALID: u32 = PAST_REST_LIMIT | PAST_BENT_LIMIT | AMBIGUOUS;

/// A point by its rest spine: all that positions need when the spine bends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Anchor {
    /// Arc length of the closest point of the spine; before 0 or past the length beyond the ends.
    pub arc: f64,
    /// From there to the point, in the frame of the spine.
    pub offset: [f64; 2],
    /// Where that would be were the spine straight, by the map.
    pub straight: [f64; 2],
    /// Distance to the limit of the map at the rest spine, in units of the mesh: negative past it, infinite where it is straight.
    pub distance: f64,
    /// [`PAST_REST_LIMIT`], [`AMBIGUOUS`], [`PAST_END`].
    pub flags: u32,
    /// Zero.
    pub padding: u32,
}

/// What a normal needs besides: the surface's covector by arc length and offset, and how the map's straight offset changes with
/// these.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Tilt {
    /// The normal times the derivatives of the point by arc length and by both offsets.
    pub covector: [f64; 3],
    /// Derivative of [`Anchor::straight`] by arc length, the offset kept.
    pub along: [f64; 2],
    /// Its derivatives by the offsets, a column each.
    pub by_offset: [[f64; 2]; 2],
}

/// Points registered on a rest spine for one map.
#[derive(Clone, Debug)]
pub struct Registration {
    /// The map that [`Anchor::straight`] is of.
    pub map: Map,
    /// Length of the rest spine.
    pub length: f64,
    /// Whether the rest spine is closed.
    pub closed: bool,
    /// One a point.
    pub anchors: Vec<Anchor>,
    /// One a normal; empty without normals.
    pub tilts: Vec<Tilt>,
}

/// Registers points, and their normals where there are any (as many or none), on a spine.
///
/// # Errors
/// [`Error::Argument`] naming the row of a point or normal that is not finite or beyond 1e150, or where there is another number of normals.
pub fn register(
    spine: &Spine,
    map: Map,
    positions: &[DVec3],
    normals: &[DVec3],
) -> Result<Registration> {
    if !normals.is_empty() && normals.len() != positions.len() {
        let reason = format!("{} for {} positions", normals.len(), positions.len());
        return Err(Error::argument("normals", reason));
    }
    finite(positions, "positions")?;
    finite(normals, "normals")?;
    let mut anchors = vec![Anchor::default(); positions.len()];
    let mut tilts = vec![Tilt::default(); normals.len()];
    if normals.is_empty() {
        let chunks = anchors
            .par_chunks_mut(CHUNK)
            .zip(positions.par_chunks(CHUNK));
        chunks.for_each(|(anchors, positions)| {
            let mut room = Vec::new();
            for (anchor, position) in anchors.iter_mut().zip(positions) {
                *anchor = place(spine, map, *position, &mut room).0;
            }
        });
    } else {
        let rows = anchors
            .par_chunks_mut(CHUNK)
            .zip(tilts.par_chunks_mut(CHUNK));
        let given = positions.par_chunks(CHUNK).zip(normals.par_chunks(CHUNK));
        rows.zip(given)
            .for_each(|((anchors, tilts), (positions, normals))| {
                let mut room = Vec::new();
                for row in 0..anchors.len() {
                    let (anchor, section) = place(spine, map, positions[row], &mut room);
                    anchors[row] = anchor;
                    tilts[row] = tilt(&section, map, &anchor, normals[row]);
                }
            });
    }
    Ok(Registration {
        map,
        length: spine.length(),
        closed: spine.closed(),
        anchors,
        tilts,
    })
}

/// Coordinates whose squares are numbers.
const FAR: f64 = 1e150;

fn finite(rows: &[DVec3], name: &str) -> Result<()> {
    let wrong = |p: &DVec3| !p.abs().cmple(DVec3::splat(FAR)).all();
    match rows.par_iter().position_first(wrong) {
        Some(row) => {
            let reason = match rows[row].is_finite() {
                true => "is too far away",
                false => "is not finite",
            };
            Err(Error::argument(format!("{name}/{row}"), reason))
        }
        None => Ok(()),
    }
}

fn place(spine: &Spine, map: Map, position: DVec3, room: &mut Vec<f64>) -> (Anchor, Section) {
    let closest = spine.closest_by(position, room);
    let section = spine.section(closest.arc);
    let way = position - section.position;
    let offset = DVec2::new(way.dot(section.side), way.dot(section.lift));
    let straight = map.unbend(offset, section.curvature, DVec2::ZERO).offset;
    let left = map.room(offset, section.curvature);
    let past_end = !spine.closed() && !(0.0..=spine.length()).contains(&closest.arc);
    let flag = |on: bool, flag: u32| if on { flag } else { 0 };
    let anchor = Anchor {
        arc: closest.arc,
        offset: offset.to_array(),
        straight: straight.to_array(),
        distance: left / section.curvature.length(),
        flags: flag(left <= 0.0, PAST_REST_LIMIT)
            | flag(closest.ambiguous, AMBIGUOUS)
            | flag(past_end, PAST_END),
        padding: 0,
    };
    (anchor, section)
}

fn tilt(section: &Section, map: Map, anchor: &Anchor, normal: DVec3) -> Tilt {
    let offset = DVec2::from_array(anchor.offset);
    let shift = map.unbend(offset, section.curvature, section.curvature_rate);
    let basis = basis(section, offset, DMat2::IDENTITY, DVec2::ZERO);
    Tilt {
        covector: basis.map(|column| column.dot(normal)),
        along: shift.along.to_array(),
        by_offset: shift.by_offset.to_cols_array_2d(),
    }
}

/// Derivatives of a point of the cross-section by arc length and by two coordinates of which the offset has derivatives `by` and,
/// along the spine, `along`:
/// of X = C + x I + y J, where I' = -(k·I) T + w J and J' = -(k·J) T - w I.
#[inline]
pub(super) fn basis(section: &Section, offset: DVec2, by: DMat2, along: DVec2) -> [DVec3; 3] {
    let plane = |v: DVec2| v.x * section.side + v.y * section.lift;
    let forward = 1.0 - section.curvature.dot(offset);
    [
        forward * section.tangent + plane(section.twist_rate * offset.perp() + along),
        plane(by.x_axis),
        plane(by.y_axis),
    ]
}
