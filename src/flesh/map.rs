//! The three maps of a cross-section that keep volume: to where it would be were the spine straight, and back.
//!
//! A point of the cross-section is `offset` from the spine, whose curvature vector there is `k`; both in the frame. A volume is
//! as large as that of the straight spine times 1 - k·offset, which each map makes up for in its own direction. Past its
//! limit, k·offset = 1 or, straight, that of its equation, a map goes on with the ratio that it has there: continuous, finite
//! and its own inverse's inverse, but without keeping volume.

use glam::{DMat2, DVec2};

/// In which direction flesh gives way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Map {
    /// From and to the spine (Eqs. 6 to 9).
    #[default]
    Radial,
    /// In the plane of the bend (Eqs. 10 to 13).
    Normal,
    /// Across the plane of the bend (Eqs. 14 to 17).
    Binormal,
}

/// The binormal map stretches by 1 / (1 - k·offset), without bound; its limit is where this much is left.
pub const BINORMAL_ROOM: f64 = 1.0 / 32.0;

/// The radial map at its limit, and its straight limit's k·offset, inverted.
const SQRT_3: f64 = 1.732_050_807_568_877_2;
/// Least slope in a derivative: at the limit itself some are infinite.
const FLAT: f64 = 1e-6;
/// Curvature times offset below which a cross-section is that of a straight spine.
const STRAIGHT: f64 = 1e-14;

/// Where a point of the cross-section goes, and how that changes.
#[derive(Clone, Copy, Debug)]
pub struct Shift {
    /// The new offset.
    pub offset: DVec2,
    /// Its derivative by the old one.
    pub by_offset: DMat2,
    /// Its derivative along the spine, the old offset kept.
    pub along: DVec2,
}

impl Map {
    /// From the bent spine's cross-section to the straight one's (Eqs. 7, 11, 15). `rate`: derivative of the curvature vector
    /// along the spine.
    #[inline]
    pub fn unbend(self, offset: DVec2, curvature: DVec2, rate: DVec2) -> Shift {
        match self {
            Self::Radial => {
                // r* = r sqrt(1 - 2/3 k·offset).
                let a = curvature.dot(offset);
                if a >= 1.0 {
                    return scaled(offset, 1.0 / SQRT_3);
                }
                let ratio = (1.0 - a / 1.5).sqrt();
                radial(offset, curvature, rate, (ratio, -1.0 / (3.0 * ratio)))
            }
            Self::Normal => Plane::new(offset, curvature, rate).shift(|x, _, k| {
                // x* = x (1 - k x / 2).
                let (value, by_x, by_k) = match k * x >= 1.0 {
                    true => (0.5 * x, 0.5, 0.0),
                    false => (x - 0.5 * k * x * x, 1.0 - k * x, -0.5 * x * x),
                };
                Grown::along_normal(value, by_x, by_k)
            }),
            Self::Binormal => Plane::new(offset, curvature, rate).shift(|x, y, k| {
                // y* = y (1 - k x).
                let room = 1.0 - k * x;
                match room < BINORMAL_ROOM {
                    true => Grown::along_binormal(BINORMAL_ROOM * y, BINORMAL_ROOM, 0.0, 0.0),
                    false => Grown::along_binormal(room * y, room, -k * y, -x * y),
                }
            }),
        }
    }

    /// From the straight spine's cross-section to the bent one's (Eqs. 8, 12, 16); the inverse of [`Map::unbend`].
    #[inline]
    pub fn bend(self, offset: DVec2, curvature: DVec2, rate: DVec2) -> Shift {
        match self {
            Self::Radial => {
                // r = r* / x with x³ - x - a = 0, a = -2/3 k·offset: the root that is 1 at a = 0, in closed form.
                let a = curvature.dot(offset) / -1.5;
                let t = 1.5 * SQRT_3 * a;
                if t <= -1.0 {
                    return scaled(offset, SQRT_3);
                }
                let x = 2.0 / SQRT_3 * root(t);
                let slope = (3.0 * x * x - 1.0).max(FLAT);
                radial(
                    offset,
                    curvature,
                    rate,
                    (1.0 / x, 1.0 / (1.5 * x * x * slope)),
                )
            }
            Self::Normal => Plane::new(offset, curvature, rate).shift(|x, _, k| {
                // x = (1 - sqrt(1 - 2 k x*)) / k, without a quotient of zeros.
                let square = 1.0 - 2.0 * k * x;
                if square <= 0.0 {
                    return Grown::along_normal(2.0 * x, 2.0, 0.0);
                }
                let value = 2.0 * x / (1.0 + square.sqrt());
                let by_x = 1.0 / square.sqrt().max(FLAT);
                Grown::along_normal(value, by_x, 0.5 * value * value * by_x)
            }),
            Self::Binormal => Plane::new(offset, curvature, rate).shift(|x, y, k| {
                // y = y* / (1 - k x).
                let room = 1.0 - k * x;
                if room < BINORMAL_ROOM {
                    let most = 1.0 / BINORMAL_ROOM;
                    return Grown::along_binormal(most * y, most, 0.0, 0.0);
                }
                let (value, rate) = (y / room, y / (room * room));
                Grown::along_binormal(value, 1.0 / room, k * rate, x * rate)
            }),
        }
    }

    /// Curvature times straight offset at the limit of the map (Eqs. 9, 13, 17).
    pub fn straight_limit(self) -> f64 {
        match self {
            Self::Radial => 1.0 / SQRT_3,
            Self::Normal => 0.5,
            Self::Binormal => 1.0 - BINORMAL_ROOM,
        }
    }

    /// How far a point is from the limit of the map, as a share of the radius of curvature: 1 - k·offset, less what the binormal
    /// map keeps. 1 on the spine, 0 at the limit, negative past it.
    #[inline]
    pub fn room(self, offset: DVec2, curvature: DVec2) -> f64 {
        let room = 1.0 - curvature.dot(offset);
        match self {
            Self::Binormal => room - BINORMAL_ROOM,
            Self::Radial | Self::Normal => room,
        }
    }
}

/// cos(acos(t) / 3), and what it goes on as past 1.
#[inline]
fn root(t: f64) -> f64 {
    match t <= 1.0 {
        true => (t.acos() / 3.0).cos(),
        false => (t.acosh() / 3.0).cosh(),
    }
}

fn scaled(offset: DVec2, ratio: f64) -> Shift {
    Shift {
        offset: ratio * offset,
        by_offset: DMat2::from_diagonal(DVec2::splat(ratio)),
        along: DVec2::ZERO,
    }
}

/// offset times a ratio that depends on k·offset alone; `ratio` with its derivative by it.
#[inline]
fn radial(offset: DVec2, curvature: DVec2, rate: DVec2, (ratio, slope): (f64, f64)) -> Shift {
    Shift {
        offset: ratio * offset,
        by_offset: DMat2::from_cols(
            DVec2::new(ratio, 0.0) + slope * curvature.x * offset,
            DVec2::new(0.0, ratio) + slope * curvature.y * offset,
        ),
        along: slope * rate.dot(offset) * offset,
    }
}

/// An offset along the normal and the binormal, and how these turn along the spine.
struct Plane {
    normal: DVec2,
    x: f64,
    y: f64,
    curvature: f64,
    rate: f64,
    turn: f64,
}

/// The coordinate that the map changes, with its derivatives.
struct Grown {
    along_normal: bool,
    value: f64,
    by_x: f64,
    by_y: f64,
    by_curvature: f64,
}

impl Grown {
    #[inline]
    fn along_normal(value: f64, by_x: f64, by_curvature: f64) -> Self {
        Self {
            along_normal: true,
            value,
            by_x,
            by_y: 0.0,
            by_curvature,
        }
    }

    #[inline]
    fn along_binormal(value: f64, by_y: f64, by_x: f64, by_curvature: f64) -> Self {
        Self {
            along_normal: false,
            value,
            by_x,
            by_y,
            by_curvature,
        }
    }
}

impl Plane {
    #[inline]
    fn new(offset: DVec2, curvature: DVec2, rate: DVec2) -> Self {
        let size = curvature.length();
        let straight = size * (offset.x.abs() + offset.y.abs()) < STRAIGHT;
        // Where the curvature passes through zero, its direction is that in which it changes.
        let normal = match straight {
            true => rate.try_normalize().unwrap_or(DVec2::X),
            false => curvature / size,
        };
        Self {
            normal,
            x: offset.dot(normal),
            y: normal.perp_dot(offset),
            curvature: if straight { 0.0 } else { size },
            rate: rate.dot(normal),
            turn: if straight {
                0.0
            } else {
                normal.perp_dot(rate) / size
            },
        }
    }

    #[inline]
    fn shift(&self, map: impl FnOnce(f64, f64, f64) -> Grown) -> Shift {
        let (x, y, turn) = (self.x, self.y, self.turn);
        let grown = map(x, y, self.curvature);
        // The offset is kept while normal and binormal turn.
        let (xs, ys) = (turn * y, -turn * x);
        let rate = grown.by_x * xs + grown.by_y * ys + grown.by_curvature * self.rate;
        let by = DVec2::new(grown.by_x, grown.by_y);
        let (place, rate, inner) = match grown.along_normal {
            true => (
                DVec2::new(grown.value, y),
                DVec2::new(rate, ys),
                DMat2::from_cols(DVec2::new(by.x, 0.0), DVec2::new(by.y, 1.0)),
            ),
            false => (
                DVec2::new(x, grown.value),
                DVec2::new(xs, rate),
                DMat2::from_cols(DVec2::new(1.0, by.x), DVec2::new(0.0, by.y)),
            ),
        };
        let axes = DMat2::from_cols(self.normal, self.normal.perp());
        Shift {
            offset: axes * place,
            by_offset: axes * inner * axes.transpose(),
            along: axes * (rate + turn * place.perp()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAPS: [Map; 3] = [Map::Radial, Map::Normal, Map::Binormal];

    /// Offsets and curvatures on all sides, straight, within and past the limits.
    fn cases() -> Vec<(DVec2, DVec2)> {
        let mut cases = Vec::new();
        for angle in 0..12 {
            for size in [0.0, 1e-18, 1e-9, 0.1, 0.4, 0.57, 0.9, 0.99, 1.2, 3.0] {
                let k = size * DVec2::from_angle(0.4 + f64::from(angle));
                cases.push((DVec2::new(0.3, -0.95), k));
                cases.push((DVec2::new(1.1, 0.2), k));
                cases.push((DVec2::ZERO, k));
            }
        }
        cases
    }

    #[test]
    fn bending_undoes_unbending_past_the_limit_too() {
        for map in MAPS {
            for (offset, k) in cases() {
                let straight = map.unbend(offset, k, DVec2::ZERO).offset;
                let back = map.bend(straight, k, DVec2::ZERO).offset;
                // Next to the limit a root is all that is left.
                let near = map.room(offset, k).abs() < 1e-6;
                let bound = if near { 1e-7 } else { 1e-12 };
                assert!(back.distance(offset) < bound, "{map:?} {offset} {k} {back}");
            }
        }
    }

    #[test]
    fn volume_is_kept_within_the_limit() {
        for map in MAPS {
            for (offset, k) in cases() {
                if map.room(offset, k) > 1e-6 {
                    let there = map.unbend(offset, k, DVec2::ZERO);
                    let wanted = 1.0 - k.dot(offset);
                    assert!(
                        (there.by_offset.determinant() - wanted).abs() < 1e-12,
                        "{map:?}"
                    );
                    let back = map.bend(there.offset, k, DVec2::ZERO);
                    assert!(
                        (back.by_offset.determinant() * wanted - 1.0).abs() < 1e-9,
                        "{map:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_the_values() {
        let h = 1e-6;
        for map in MAPS {
            for (offset, k) in cases() {
                let rate = DVec2::new(-0.3, 0.8);
                for way in [Map::unbend, Map::bend] {
                    let at = |o: DVec2, s: f64| way(map, o, k + s * rate, rate);
                    let room = 1.0 - k.dot(offset).abs() * 2.0;
                    if room.abs() < 0.05 || (1.0 - k.dot(offset)).abs() < 0.05 || k.length() < 1e-3
                    {
                        continue; // a limit, or too near to a change of direction for the step
                    }
                    let exact = at(offset, 0.0);
                    let slope = |a: Shift, b: Shift| (a.offset - b.offset) / (2.0 * h);
                    let along = slope(at(offset, h), at(offset, -h));
                    assert!(along.distance(exact.along) < 1e-5, "{map:?} {offset} {k}");
                    for (axis, column) in [
                        (DVec2::X, exact.by_offset.x_axis),
                        (DVec2::Y, exact.by_offset.y_axis),
                    ] {
                        let by = slope(at(offset + h * axis, 0.0), at(offset - h * axis, 0.0));
                        assert!(
                            by.distance(column) < 1e-5,
                            "{map:?} {offset} {k} {by} {column}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_map_is_continuous_at_its_limit() {
        for map in MAPS {
            for k in [DVec2::new(0.7, 0.0), DVec2::new(-0.2, 0.5)] {
                for side in [-0.4, 0.0, 0.9] {
                    let at = |a: f64| a * k / k.length_squared() + side * k.perp();
                    for limit in [1.0 / SQRT_3, 0.5, 1.0, 1.0 - BINORMAL_ROOM] {
                        for way in [Map::unbend, Map::bend] {
                            let near = |a: f64| way(map, at(a), k, DVec2::ZERO).offset;
                            let (a, b) = (near(limit - 1e-12), near(limit + 1e-12));
                            assert!(a.is_finite() && a.distance(b) < 1e-5, "{map:?} {a} {b}");
                        }
                    }
                }
            }
        }
    }
}
