//! Binary operators g(f1, f2) in closed form, with their partial derivatives (2013, section 4.2 and appendix A).
//!
//! A level set g = C is the corner of the union, {max = C}, opened between f = k(C) and f = C. The opening is
//! D(C) = C - k(C); with t = tan θ the appendix gives k = t C up to C = 0.5 and a second line from there, on which
//! D falls to 0 at C = 0.7: deeper inside, the operator is the union. t = 1 closes the opening everywhere.

use crate::{Error, Result};

/// Value above which every operator is the union.
const INSIDE: f64 = 0.7;
/// The reference iso-value, where k(C) changes its line.
const SURFACE: f64 = 0.5;
/// Greatest magnitude of the bulge for which every level set is a graph, so that g stays single-valued.
pub const MAX_MAGNITUDE: f32 = 3.0;
/// Control points of the bulge's profile, a uniform quadratic B-spline over the opening, in units of D (the authors' values).
const BULGE: [f64; 11] = [0., 0., 0., 0.025, 0.05, 0.075, 0.1, 0.125, 0.1, 0.1, 0.1];

/// An operator's value and its derivatives by f1 and by f2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Partials {
    /// g.
    pub value: f64,
    /// ∂g/∂f1.
    pub by_first: f64,
    /// ∂g/∂f2.
    pub by_second: f64,
}

/// Refuses a magnitude of the bulge operator that is not in [0, [`MAX_MAGNITUDE`]].
pub fn check_magnitude(magnitude: f32) -> Result<f32> {
    if (0.0..=MAX_MAGNITUDE).contains(&magnitude) {
        return Ok(magnitude);
    }
    Err(Error::argument(
        "magnitude",
        format!("{magnitude} is not in 0 to {MAX_MAGNITUDE}"),
    ))
}

/// max(f1, f2) (Ricci 1973); on the crease the derivatives are the mean of both sides.
pub(super) fn union(f1: f64, f2: f64) -> Partials {
    let by_first = match f1.total_cmp(&f2) {
        std::cmp::Ordering::Greater => 1.0,
        std::cmp::Ordering::Equal => 0.5,
        std::cmp::Ordering::Less => 0.0,
    };
    Partials {
        value: f1.max(f2),
        by_first,
        by_second: 1.0 - by_first,
    }
}

/// k(C) as slope and offset, on the line that holds at `c`.
fn line(c: f64, t: f64) -> (f64, f64) {
    if c <= SURFACE {
        (t, 0.0)
    } else {
        ((7.0 - 5.0 * t) / 2.0, 1.75 * (t - 1.0))
    }
}

/// Whether the operator is the union at a point of the (f1, f2) plane: deep inside, or beside the opening.
fn is_union(f1: f64, f2: f64, t: f64) -> bool {
    let (least, greatest) = (f1.min(f2), f1.max(f2));
    let (slope, offset) = line(greatest, t);
    greatest >= INSIDE || least <= slope * greatest + offset
}

/// Gradient-based blend (appendix A): the opening is rounded by a quarter circle; t = tan θ in [0, 1].
///
/// (f1 - k)² + (f2 - k)² = (C - k)² with k = m C + b is the quadratic A C² - 2 B C + E = 0 in C, with g_i = f_i - b,
/// A = m² + 2m - 1, B = m (g1 + g2) - b (1 - m), E = g1² + g2² - b²; its lesser root is E / (B + √(B² - A E)).
pub fn blend(f1: f64, f2: f64, t: f64) -> Partials {
    if is_union(f1, f2, t) {
        return union(f1, f2);
    }
    let root = |(m, b): (f64, f64)| {
        let (g1, g2) = (f1 - b, f2 - b);
        let (a, half, e) = (
            m * m + 2.0 * m - 1.0,
            m * (g1 + g2) - b * (1.0 - m),
            g1 * g1 + g2 * g2 - b * b,
        );
        e / (half + (half * half - a * e).sqrt())
    };
    let outer = root(line(SURFACE, t));
    // A root that is not real is NaN and fails the comparison.
    let outside = f1.max(f2) <= outer && outer <= SURFACE;
    let c = if outside {
        outer
    } else {
        root(line(INSIDE, t)).clamp(f1.max(f2), INSIDE)
    };
    let (m, b) = line(if outside { SURFACE } else { INSIDE }, t);
    let k = m * c + b;
    let slope = (c - k) * (1.0 - m) + m * (f1 + f2 - 2.0 * k);
    if slope <= 1e-9 {
        return union(f1, f2);
    }
    Partials {
        value: c,
        by_first: (f1 - k) / slope,
        by_second: (f2 - k) / slope,
    }
}

/// Gradient-based bulge in contact: the two surfaces swell on either side of the crease where they meet, and the crease stays.
///
/// t = tan θ in [0, 1] (0 is the full bulge); `magnitude` in [0, [`MAX_MAGNITUDE`]] scales the swelling, 0 being the union.
/// With a = min, b = max and x = (a - k)/D the place in the opening, the level set is (b - k)/D = 1 - magnitude·c(x), that is
/// F(C) = C - b - magnitude·D(C)·c(x) = 0 with x = 1 - (C - a)/D. F rises with C, so bisection finds its only root in [b, 0.7].
pub fn bulge(f1: f64, f2: f64, t: f64, magnitude: f64) -> Partials {
    let (a, b) = (f1.min(f2), f1.max(f2));
    if magnitude <= 0.0 || is_union(f1, f2, t) {
        return union(f1, f2);
    }
    let opening = |c: f64| {
        let (slope, offset) = line(c, t);
        c - slope * c - offset
    };
    let excess = |c: f64| {
        let d = opening(c);
        if d <= 1e-12 {
            return c - b;
        }
        c - b - magnitude * d * profile(1.0 - (c - a) / d).0
    };
    let (mut low, mut high) = (b, INSIDE);
    for _ in 0..52 {
        let middle = 0.5 * (low + high);
        if excess(middle) <= 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    bulge_partials(f1, f2, low, t, magnitude)
}

/// Derivatives of the bulge at its value `c`, by the implicit function theorem on F(C; a, b).
fn bulge_partials(f1: f64, f2: f64, c: f64, t: f64, magnitude: f64) -> Partials {
    let (slope, offset) = line(c, t);
    let d = c - slope * c - offset;
    if d <= 1e-9 {
        return union(f1, f2);
    }
    let x = 1.0 - (c - f1.min(f2)) / d;
    let (height, rise) = profile(x);
    let by_c = 1.0 - magnitude * ((1.0 - slope) * (height + rise * (1.0 - x)) - rise);
    let (by_least, by_greatest) = (magnitude * rise / by_c, 1.0 / by_c);
    let side = union(f1, f2);
    Partials {
        value: c,
        by_first: side.by_first * by_greatest + side.by_second * by_least,
        by_second: side.by_second * by_greatest + side.by_first * by_least,
    }
}

/// The bulge's profile c(x) and its slope; 0 for x ≤ 0, the end value for x ≥ 1.
fn profile(x: f64) -> (f64, f64) {
    let spans = BULGE.len() - 2;
    let u = x.clamp(0.0, 1.0) * spans as f64;
    let i = (u as usize).min(spans - 1);
    let s = u - i as f64;
    let (p, q, r) = (BULGE[i], BULGE[i + 1], BULGE[i + 2]);
    let value = 0.5 * (1.0 - s) * (1.0 - s) * p + (0.5 + s - s * s) * q + 0.5 * s * s * r;
    let slope = ((1.0 - s) * (q - p) + s * (r - q)) * spans as f64;
    (value, if x > 0.0 && x < 1.0 { slope } else { 0.0 })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Deterministic points in [0, 1)³ (Kronecker sequence of the plastic number).
    fn points(n: usize) -> impl Iterator<Item = [f64; 3]> {
        (0..n).map(|i| {
            [0.819_172_513_396, 0.671_043_606_704, 0.549_700_477_901]
                .map(|a| (0.5 + a * (i + 1) as f64).fract())
        })
    }

    /// Equation 8 as printed, solved by bisection on C with k branching on C.
    fn equation_8(f1: f64, f2: f64, t: f64) -> f64 {
        let (least, greatest) = (f1.min(f2), f1.max(f2));
        let k = |c: f64| {
            if c <= 0.5 {
                t * c
            } else {
                0.5 * (7.0 - 5.0 * t) * c + 1.75 * (t - 1.0)
            }
        };
        if greatest > 0.7 || least <= k(greatest) {
            return greatest;
        }
        let (mut low, mut high) = (greatest, 0.7);
        for _ in 0..100 {
            let c = 0.5 * (low + high);
            if (f1 - k(c)).hypot(f2 - k(c)) > c - k(c) && least > k(c) {
                low = c;
            } else {
                high = c;
            }
        }
        low
    }

    #[test]
    fn blend_agrees_with_bisection_of_equation_8() {
        let mut worst: f64 = 0.0;
        for [f1, f2, t] in points(20_000) {
            worst = worst.max((blend(f1, f2, t).value - equation_8(f1, f2, t)).abs());
        }
        assert!(worst < 1e-12, "{worst:e}");
    }

    type Named = (&'static str, fn(f64, f64, f64) -> Partials);
    const OPERATORS: [Named; 4] = [
        ("union", |a, b, _| union(a, b)),
        ("blend", blend),
        ("bulge", |a, b, t| bulge(a, b, t, 1.0)),
        ("great bulge", |a, b, t| {
            bulge(a, b, t, MAX_MAGNITUDE as f64)
        }),
    ];

    #[test]
    fn no_operator_is_below_the_union_and_all_are_symmetric() {
        for (name, g) in OPERATORS {
            for [f1, f2, t] in points(20_000) {
                let (p, q) = (g(f1, f2, t), g(f2, f1, t));
                assert!(p.value >= f1.max(f2), "{name} {f1} {f2} {t}");
                assert!(p.value <= 1.0 && p.by_first.is_finite() && p.by_second.is_finite());
                assert_eq!((p.value, p.by_first), (q.value, q.by_second), "{name}");
            }
        }
    }

    #[test]
    fn on_the_axes_an_operator_is_the_other_field() {
        for (name, g) in OPERATORS {
            for [f, _, t] in points(1000) {
                for t in [t, 0.0, 1.0] {
                    let (p, q) = (g(f, 0.0, t), g(0.0, f, t));
                    assert_eq!((p.value, p.by_first, p.by_second), (f, 1.0, 0.0), "{name}");
                    assert_eq!((q.value, q.by_first, q.by_second), (f, 0.0, 1.0), "{name}");
                }
            }
        }
    }

    #[test]
    fn partials_are_the_derivatives_away_from_creases() {
        let h = 1e-7;
        for (name, g) in OPERATORS {
            let mut checked = 0;
            for [f1, f2, t] in points(20_000) {
                let difference = |h: f64| {
                    [
                        (g(f1 + h, f2, t).value - g(f1 - h, f2, t).value) / (2.0 * h),
                        (g(f1, f2 + h, t).value - g(f1, f2 - h, t).value) / (2.0 * h),
                    ]
                };
                let (d, wide) = (difference(h), difference(100.0 * h));
                let p = g(f1, f2, t);
                if (0..2).any(|i| (d[i] - wide[i]).abs() > 1e-4) {
                    continue; // a crease lies between
                }
                checked += 1;
                let error = (p.by_first - d[0]).abs().max((p.by_second - d[1]).abs());
                assert!(error < 1e-4, "{name} {f1} {f2} {t}: {p:?} {d:?}");
            }
            assert!(checked > 17_000, "{name}: {checked}");
        }
    }

    #[test]
    fn values_are_continuous_and_rise_along_the_diagonal() {
        for (name, g) in OPERATORS {
            for [f1, f2, t] in points(50_000) {
                let h = 1e-6;
                let step = (g(f1 + h, f2 + h, t).value - g(f1, f2, t).value) / h;
                assert!((0.0..4.0).contains(&step), "{name} {f1} {f2} {t}: {step}");
                let across = (g(f1 + h, f2, t).value - g(f1, f2, t).value).abs() / h;
                assert!(across < 4.0, "{name} {f1} {f2} {t}: {across}");
            }
        }
    }

    #[test]
    fn a_greater_magnitude_bulges_further_and_keeps_the_crease() {
        let at = |m: f64| bulge(0.42, 0.4, 0.0, m);
        assert_eq!(at(0.0).value, 0.42);
        assert!(at(0.5).value > 0.43 && at(1.0).value > at(0.5).value + 0.01);
        assert!(at(3.0).value > at(1.0).value + 0.05);
        let (left, right) = (
            bulge(0.4, 0.4 - 1e-9, 0.0, 1.0),
            bulge(0.4 - 1e-9, 0.4, 0.0, 1.0),
        );
        assert!(left.by_first - right.by_first > 0.8, "{left:?} {right:?}");
    }

    #[test]
    fn a_magnitude_out_of_range_is_refused() {
        assert!(check_magnitude(1.0).is_ok());
        for bad in [-0.1, 3.1, f32::NAN] {
            assert!(check_magnitude(bad).is_err());
        }
    }
}
