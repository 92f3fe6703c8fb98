//! Operators by their profile (2014, section 4): 128 biharmonic slices with their partial derivatives.

use half::f16;
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::{Error, Result};

use super::{
    EDGE, Partials, Profile, Volume,
    biharmonic::Biharmonic,
    pins::{Pin, pins},
};

/// The operator g(f1, f2, d) that is 0.5 on a profile, f on the axes and 1 where a field is 1 (Eq. 1 and 2).
///
/// The third axis is the depth d of a [`Controller`](super::Controller). It takes about half a second of two cores: callers that need it
/// often keep [`Volume::bytes`] and read them with [`Volume::from_bytes`].
///
/// Partials are central differences, also across the contact line: g is C¹ there and even, so both its partials are 0 *on* the line and
/// linear beside it, which is what central differences filtered linearly give. One-sided ones would have to choose a side at the line's own texels.
///
/// # Errors
/// [`Error::Argument`] with subject `profile`, naming the depth, where rounding makes a slice's system indefinite.
pub fn profile_volume(profile: &Profile) -> Result<Volume> {
    let depth = |k: usize| k as f64 / (EDGE - 1) as f64;
    let outlines: Vec<_> = (0..EDGE).map(|k| profile.outline(depth(k))).collect();
    let pins = pins(&outlines, EDGE - 1);
    let solver = Biharmonic::new(EDGE - 1);
    // Where neighbouring slices have the same pins one solution does for all.
    let runs: Vec<&[Vec<Pin>]> = pins.chunk_by(|a, b| a == b).collect();
    let slices: Vec<Option<Vec<[f16; 4]>>> = runs
        .par_iter()
        .map(|run| Some(texels(&solver.slice(&run[0])?)))
        .collect();
    let mut all = Vec::with_capacity(EDGE * EDGE * EDGE);
    for (run, slice) in runs.iter().zip(slices) {
        let slice = slice.ok_or_else(|| {
            let d = depth(all.len() / (EDGE * EDGE));
            Error::argument("profile", format!("depth {d}: no solution within rounding"))
        })?;
        for _ in 0..run.len() {
            all.extend_from_slice(&slice);
        }
    }
    Ok(Volume { texels: all })
}

/// A slice's texels, f1 fastest.
fn texels(g: &DMatrix<f64>) -> Vec<[f16; 4]> {
    let half = |p: Partials| [p.value, p.by_first, p.by_second, 0.0].map(f16::from_f64);
    let rows = (0..g.ncols()).flat_map(|j| (0..g.nrows()).map(move |i| (i, j)));
    rows.map(|(i, j)| half(partials(g, i, j))).collect()
}

/// g and its derivatives at a vertex.
fn partials(g: &DMatrix<f64>, i: usize, j: usize) -> Partials {
    let cells = g.nrows() - 1;
    // At the origin the axes' (1, 0) and (0, 1) meet: their mean, as in the union.
    let (by_first, by_second) = if (i, j) == (0, 0) {
        (0.5, 0.5)
    } else {
        (
            slope(|i| g[(i, j)], i, cells),
            slope(|j| g[(i, j)], j, cells),
        )
    };
    Partials {
        // A user's profile may overshoot; what composes the result further expects a field.
        value: g[(i, j)].clamp(0.0, 1.0),
        by_first,
        by_second,
    }
}

/// Derivative of a row of `cells` cells over [0, 1] at vertex `i`: 0 at the mirror, one-sided at the end, central elsewhere.
fn slope(row: impl Fn(usize) -> f64, i: usize, cells: usize) -> f64 {
    let per_cell = match i {
        0 => 0.0,
        i if i == cells => row(i) - row(i - 1),
        i => 0.5 * (row(i + 1) - row(i - 1)),
    };
    per_cell * cells as f64
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::sync::LazyLock;

    use super::*;

    static CONTACT: LazyLock<Volume> =
        LazyLock::new(|| profile_volume(&Profile::contact()).unwrap());
    static BULGE: LazyLock<Volume> =
        LazyLock::new(|| profile_volume(&Profile::bulge(1.0).unwrap()).unwrap());

    fn both() -> [(&'static str, &'static Volume); 2] {
        [("contact", &CONTACT), ("bulge", &BULGE)]
    }

    /// Channel `c` of a texel.
    fn texel(volume: &Volume, i: usize, j: usize, k: usize, c: usize) -> f64 {
        volume.texels[(k * EDGE + j) * EDGE + i][c].to_f64()
    }

    fn at(i: usize) -> f64 {
        i as f64 / (EDGE - 1) as f64
    }

    #[test]
    fn sides_have_the_values_of_equation_1_and_the_axes_exact_partials() {
        let half = |f: f64| f16::from_f64(f).to_f64();
        for (name, volume) in both() {
            for k in 0..EDGE {
                for i in 1..EDGE {
                    let axis = |c| [texel(volume, i, 0, k, c), texel(volume, 0, i, k, c)];
                    let outer = [texel(volume, i, 127, k, 0), texel(volume, 127, i, k, 0)];
                    assert_eq!(axis(0), [half(at(i)); 2], "{name} {i} {k}");
                    assert_eq!((axis(1), axis(2)), ([1.0, 0.0], [0.0, 1.0]), "{name} {i}");
                    assert_eq!(outer, [1.0; 2], "{name} {i} {k}");
                }
            }
        }
    }

    #[test]
    fn a_field_that_fades_in_has_no_slope_at_the_axis() {
        for (name, volume) in both() {
            let rise = |i, k| texel(volume, i, 1, k, 0) - texel(volume, i, 0, k, 0);
            for k in 0..EDGE {
                // At the origin both axes' slopes meet and no function is smooth. In the first cell g rises by half its second
                // derivative: .047 of a cell at texel 4, falling from there; without the mirror it would be 1 - f.
                for i in 4..EDGE - 1 {
                    assert!(rise(i, k).abs() < 0.05 * at(1), "{name} {i} {k}");
                }
            }
        }
    }

    #[test]
    fn the_contact_operator_is_half_on_its_surface_and_on_its_line() {
        for k in 0..EDGE {
            for i in 1..63 {
                // 0.5 lies midway between texels 63 and 64.
                let mean = 0.5 * (texel(&CONTACT, i, 63, k, 0) + texel(&CONTACT, i, 64, k, 0));
                assert!((mean - 0.5).abs() < 3e-4, "{i} {k}: {mean}");
            }
            let tip = 0.5 + at(k) / 2f64.sqrt();
            for i in (64..126).filter(|&i| at(i) <= tip) {
                assert_eq!(texel(&CONTACT, i, i, k, 0), 0.5, "{i} {k}");
            }
            let ahead = (64..126).find(|&i| at(i) > tip + at(2));
            assert!(
                ahead.is_none_or(|i| texel(&CONTACT, i, i, k, 0) > 0.5 + 1e-3),
                "{k}"
            );
        }
    }

    /// Greatest distance of a slice from 0.5 on the curve, with linear filtering.
    fn error_on_curve(g: impl Fn(f64, f64) -> f64, depth: f64) -> f64 {
        let curve = Profile::bulge(1.0).unwrap().outline(depth).surface;
        let errors = curve.iter().map(|p| (g(p[0], p[1]) - 0.5).abs());
        errors.fold(0.0, f64::max)
    }

    #[test]
    fn the_bulge_is_half_on_its_curve_and_far_closer_than_by_nearest_vertices() {
        for k in (0..EDGE).step_by(9) {
            let filtered = |f1, f2| BULGE.sample(f1 as f32, f2 as f32, at(k) as f32)[0] as f64;
            let error = error_on_curve(filtered, at(k));
            // Half a cell times the slope, as by the paper's vertices, would be 4e-3; half floats alone err by 2.4e-4.
            assert!(error < 4e-4, "{k}: {error:e}");
        }
        let wrong = |f1, f2| BULGE.sample(f1 as f32, f2 as f32, 0.5)[0] as f64;
        assert!(
            error_on_curve(wrong, 1.0) > 0.01,
            "a wrong slice must be noticed"
        );
    }

    #[test]
    fn the_clean_union_has_no_kink_on_the_diagonal() {
        for (name, volume) in both() {
            for i in 8..57 {
                // Across the diagonal, in units of a cell's change: max has 1 at its kink.
                let kink = texel(volume, i + 1, i - 1, 0, 0) - 2.0 * texel(volume, i, i, 0, 0)
                    + texel(volume, i - 1, i + 1, 0, 0);
                assert!(kink.abs() * 127.0 < 0.25, "{name} {i}: {}", kink * 127.0);
            }
        }
    }

    #[test]
    fn presets_are_symmetric_in_their_fields_and_stay_in_range() {
        for (name, volume) in both() {
            for t in 0..EDGE * EDGE * EDGE {
                let (i, j, k) = (t % EDGE, t / EDGE % EDGE, t / EDGE / EDGE);
                let g = texel(volume, i, j, k, 0);
                // One step of half floats below 1: solutions are symmetric to 1e-9, which may round apart.
                assert!(
                    (g - texel(volume, j, i, k, 0)).abs() < 5e-4,
                    "{name} {i} {j} {k}"
                );
                assert!((0.0..=1.0).contains(&g), "{name} {i} {j} {k}: {g}");
                let [a, b] = [texel(volume, i, j, k, 1), texel(volume, j, i, k, 2)];
                assert!(
                    (a - b).abs() <= 2e-3 * a.abs().max(1.0),
                    "{name} {i} {j} {k}: {a} {b}"
                );
            }
        }
    }

    /// Greatest change of g from slice to slice, and of that change, where both fields are at most `f`.
    fn change(volume: &Volume, f: f64) -> (f64, f64) {
        let last = (f * 127.0) as usize;
        let (mut first, mut second) = (0f64, 0f64);
        for k in 1..EDGE - 1 {
            for j in 0..=last {
                for i in 0..=last {
                    let [a, b, c] = [k - 1, k, k + 1].map(|k| texel(volume, i, j, k, 0));
                    first = first.max((b - a).abs()).max((c - b).abs());
                    second = second.max((c - 2.0 * b + a).abs());
                }
            }
        }
        (first, second)
    }

    #[test]
    fn slices_follow_each_other_smoothly() {
        for (name, volume) in both() {
            // Measured .0127 a slice and .0049 from one to the next inside. Towards the corner (1, 1) the sheet's 0.5 and the sides'
            // 1 come together and steps grow: .046 up to .95.
            let (inner, all) = (change(volume, 0.8), change(volume, 0.95));
            assert!(inner.0 < 0.014 && inner.1 < 0.006, "{name}: {inner:?}");
            assert!(all.0 < 0.05, "{name}: {all:?}");
        }
    }

    #[test]
    fn a_contact_line_grows_evenly_between_texels() {
        for (name, volume) in both() {
            let step = |k: usize| {
                let slice = |k: usize| &volume.texels[k * EDGE * EDGE..(k + 1) * EDGE * EDGE];
                let pairs = slice(k).iter().zip(slice(k + 1));
                let steps = pairs.map(|(a, b)| (a[0].to_f64() - b[0].to_f64()).abs());
                steps.fold(0.0, f64::max)
            };
            // Whole texels would be pinned at two of three slices: steps of nothing and of twice the mean. A half float is 7 % of a step.
            for k in 1..60 {
                let ratio = step(k + 1) / step(k);
                assert!((0.8..1.25).contains(&ratio), "{name} {k}: {ratio}");
            }
        }
    }

    #[test]
    fn values_rise_with_both_fields_outside_of_the_skin() {
        for (name, volume) in both() {
            let outside = volume.texels.iter().filter(|t| t[0] < f16::from_f64(0.5));
            let least = outside.flat_map(|t| [t[1].to_f64(), t[2].to_f64()]);
            let least = least.fold(f64::MAX, f64::min);
            // Biharmonic functions need not be monotone: -.0054 beside the bulge, nothing below 0 for the contact.
            assert!(least > -0.01, "{name}: {least}");
        }
    }

    #[test]
    fn partials_vanish_on_the_contact_line_and_part_beside_it() {
        for i in 70..100 {
            let [on, below, above] = [(i, i), (i + 2, i - 2), (i - 2, i + 2)]
                .map(|(i, j)| [1, 2].map(|c| texel(&CONTACT, i, j, 127, c)));
            assert!(on[0].abs() < 0.02 && on[1].abs() < 0.02, "{i}: {on:?}");
            assert!(below[0] > 0.03 && below[1] < -0.03, "{i}: {below:?}");
            assert!(above[0] < -0.03 && above[1] > 0.03, "{i}: {above:?}");
        }
    }

    #[test]
    fn partials_are_the_slopes_of_the_filtered_values() {
        let h = 0.5 / 127.0;
        for n in 1..5000 {
            let [a, b, d] = [0.819_172_513_396, 0.671_043_606_704, 0.549_700_477_901]
                .map(|x: f64| 0.05 + 0.75 * (0.5 + x * n as f64).fract());
            let g = |a: f64, b: f64| BULGE.sample(a as f32, b as f32, d as f32).map(|x| x as f64);
            let [_, first, second] = g(a, b);
            let slope = [
                (g(a + h, b)[0] - g(a - h, b)[0]),
                (g(a, b + h)[0] - g(a, b - h)[0]),
            ];
            // A half float's step over a cell is .06; curvature at the line's tip gives the rest.
            for (partial, slope) in [
                (first, slope[0] / (2.0 * h)),
                (second, slope[1] / (2.0 * h)),
            ] {
                assert!(
                    (partial - slope).abs() < 0.15,
                    "{a} {b} {d}: {partial} {slope}"
                );
            }
        }
    }
}
