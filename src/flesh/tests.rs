#![allow(clippy::unwrap_used)]
//! The maps between spines: volume, inverse, normals, limits.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

use super::*;

const MAPS: [Map; 3] = [Map::Radial, Map::Normal, Map::Binormal];

/// Numbers from 0 to 1, the same on every machine (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn spine(curve: Curve) -> Spine {
    Spine::new(&SpineDesc::new(curve)).unwrap()
}

fn line(length: f64) -> Curve {
    Curve::Polyline(vec![DVec3::ZERO, DVec3::X, length * DVec3::X])
}

fn arc(radius: f64, normal: DVec3, length: f64) -> Curve {
    Curve::Arc(round(radius, normal, length))
}

fn round(radius: f64, normal: DVec3, length: f64) -> Round {
    Round {
        start: DVec3::new(0.2, -0.1, 0.3),
        tangent: DVec3::X,
        normal,
        radius,
        length,
    }
}

fn helix() -> Curve {
    let round = round(1.6, DVec3::new(0.3, 1.0, 0.2), 6.0);
    Curve::Helix { round, pitch: 3.0 }
}

/// No part of it in a plane, with a point of inflection.
fn bspline() -> Curve {
    let at = |i: u32| {
        let t = 0.6 * f64::from(i);
        DVec3::new(t, 0.6 * t.sin(), 0.3 * (1.7 * t).cos())
    };
    Curve::BSpline((0..10).map(at).collect())
}

fn polynomial() -> Curve {
    let rows = [
        [0.0, 0.0, 0.0],
        [1.7, 0.6, 0.2],
        [3.4, 0.3, 0.7],
        [5.2, -0.6, 0.4],
    ];
    Curve::Polynomial(rows.map(DVec3::from_array).to_vec())
}

/// Spines of about the same length, planar and not, straight to bent.
fn spines() -> Vec<(&'static str, Spine)> {
    vec![
        ("line", spine(line(6.0))),
        ("arc", spine(arc(2.5, DVec3::Y, 6.0))),
        ("arc in another plane", spine(arc(3.0, DVec3::Z, 6.0))),
        ("helix", spine(helix())),
        ("B-spline", spine(bspline())),
        ("polynomial", spine(polynomial())),
    ]
}

/// Points around a spine from `from` to `to` of its length, up to a radius.
fn around(spine: &Spine, count: usize, [from, to]: [f64; 2], radius: f64) -> Vec<DVec3> {
    let mut random = Random(7);
    let point = |_| {
        let s = (from + (to - from) * random.next()) * spine.length();
        let angle = glam::DVec2::from_angle(TAU * random.next());
        spine
            .section(s)
            .point(radius * random.next().sqrt() * angle)
    };
    (0..count).map(point).collect()
}

fn image(points: &[DVec3], rest: &Spine, bent: &Spine, map: Map) -> Bent {
    let registered = register(rest, map, points, &[]).unwrap();
    bend(&registered, bent, &BendOptions::default()).unwrap()
}

/// Jacobians of the whole map by central differences.
fn jacobians(points: &[DVec3], rest: &Spine, bent: &Spine, map: Map, h: f64) -> Vec<DMat3> {
    let moved = |step: DVec3| {
        let points: Vec<DVec3> = points.iter().map(|p| *p + step).collect();
        image(&points, rest, bent, map).positions
    };
    let column = |axis: DVec3| {
        let pairs = moved(h * axis).into_iter().zip(moved(-h * axis));
        pairs.map(|(a, b)| (a - b) / (2.0 * h)).collect::<Vec<_>>()
    };
    let (x, y, z) = (column(DVec3::X), column(DVec3::Y), column(DVec3::Z));
    (0..points.len())
        .map(|i| DMat3::from_cols(x[i], y[i], z[i]))
        .collect()
}

/// 100,000 points in all, within the spines' length and past their ends.
#[test]
fn every_map_keeps_volume_and_is_undone_by_its_inverse() {
    let spines = spines();
    let pairs: Vec<_> = (0..spines.len())
        .flat_map(|a| (0..spines.len()).map(move |b| (a, b)))
        .filter(|(a, b)| a != b)
        .collect();
    let count = 100_000 / pairs.len() + 1;
    let (mut checked, mut valid) = (0, 0);
    let mut worst = [(0f64, 0f64); 3];
    for (a, b) in pairs {
        let ((from, rest), (to, bent)) = (&spines[a], &spines[b]);
        let points = around(rest, count, [-0.2, 1.2], 0.45);
        for (map, worst) in MAPS.into_iter().zip(&mut worst) {
            let there = image(&points, rest, bent, map);
            let back = image(&there.positions, bent, rest, map);
            let jacobians = jacobians(&points, rest, bent, map, 1e-5);
            for row in 0..points.len() {
                checked += 1;
                // A step of the differences must not cross a limit.
                if there.flags[row] & INVALID != 0 || there.distances[row] < 0.05 {
                    continue;
                }
                valid += 1;
                let off = (jacobians[row].determinant() - 1.0).abs();
                worst.0 = worst.0.max(off);
                assert!(
                    off < 1e-5,
                    "{from} to {to}, {map:?}, {}: {off:e}",
                    points[row]
                );
                let off = back.positions[row].distance(points[row]);
                worst.1 = worst.1.max(off / 6.0);
                assert!(
                    off < 6e-9,
                    "{from} to {to}, {map:?}, {}: {off:e}",
                    points[row]
                );
            }
        }
    }
    for (map, (volume, back)) in MAPS.into_iter().zip(worst) {
        println!("{map:?}: |det - 1| up to {volume:.1e}, back within {back:.1e} of the length");
    }
    println!("{valid} of {checked} points checked");
    assert!(checked >= 300_000);
    assert!(
        valid as f64 > 0.95 * f64::from(checked),
        "{valid} of {checked}"
    );
}

#[test]
fn normals_are_those_of_the_mapped_surface() {
    let spines = spines();
    for (a, b) in [(0, 3), (3, 4), (1, 2), (4, 0)] {
        let ((from, rest), (to, bent)) = (&spines[a], &spines[b]);
        let points = around(rest, 500, [0.02, 0.98], 0.45);
        let normals: Vec<DVec3> = points
            .iter()
            .map(|p| {
                DVec3::new((7.0 * p.x).sin(), (5.0 * p.y).cos(), (9.0 * p.z).sin()).normalize()
            })
            .collect();
        for map in MAPS {
            for strength in [0.0, 0.6, 1.0] {
                let options = BendOptions {
                    strength,
                    stretch: strength > 0.5,
                    ..BendOptions::default()
                };
                let way = |points: &[DVec3], normals: &[DVec3]| {
                    let registered = register(rest, map, points, normals).unwrap();
                    bend(&registered, bent, &options).unwrap()
                };
                let found = way(&points, &normals);
                let h = 1e-5;
                let moved = |step: DVec3| {
                    let moved: Vec<DVec3> = points.iter().map(|p| *p + step).collect();
                    way(&moved, &[]).positions
                };
                let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|e| (moved(h * e), moved(-h * e)));
                for (row, normal) in normals.iter().enumerate() {
                    let column = |c: usize| (columns[c].0[row] - columns[c].1[row]) / (2.0 * h);
                    let jacobian = DMat3::from_cols(column(0), column(1), column(2));
                    let wanted = jacobian.inverse().transpose() * *normal;
                    let off = wanted.normalize().distance(found.normals[row]);
                    assert!(off < 1e-6, "{from} to {to}, {map:?}, {strength}: {off:e}");
                }
            }
        }
    }
}

#[test]
fn a_spine_under_itself_moves_nothing_past_the_limits_neither() {
    for (name, spine) in spines() {
        let points = around(&spine, 2000, [-0.3, 1.3], 6.0);
        for map in MAPS {
            let there = image(&points, &spine, &spine, map);
            let registered = register(&spine, map, &points, &[]).unwrap();
            for (row, point) in points.iter().enumerate() {
                let off = there.positions[row].distance(*point);
                // Next to the limit the inverse is a root.
                let near = registered.anchors[row].distance.abs() < 1e-3;
                assert!(
                    off < if near { 1e-6 } else { 1e-9 },
                    "{name} {map:?} {off:e}"
                );
            }
            // At a closest point the limit is not passed; where it is near, so are other parts.
            assert!(
                there.flags.iter().any(|f| f & INVALID != 0) || name == "line",
                "{name}"
            );
        }
    }
}

/// Along a ray that goes through the limit: flagged from there on, finite, without a jump.
#[test]
fn past_the_limit_points_are_flagged_finite_and_without_a_jump() {
    let (rest, bent) = (spine(line(6.0)), spine(arc(1.0, DVec3::Y, 6.0)));
    for (map, limit) in MAPS
        .into_iter()
        .zip([3f64.sqrt().recip(), 0.5, 1.0 - BINORMAL_ROOM])
    {
        let steps = 40_000;
        let ray = |i: i32| {
            let y = 4.0 * f64::from(i) / f64::from(steps);
            DVec3::new(3.0, y, 0.3)
        };
        let points: Vec<DVec3> = (0..=steps).map(ray).collect();
        let there = image(&points, &rest, &bent, map);
        let mut before = there.positions[0];
        for (row, point) in points.iter().enumerate() {
            let past = there.flags[row] & PAST_BENT_LIMIT != 0;
            if (point.y - limit).abs() > 1e-3 {
                assert_eq!(past, point.y > limit, "{map:?} {}", point.y);
            }
            assert_eq!(past, there.distances[row] <= 0.0);
            let moved = there.positions[row];
            assert!(
                moved.is_finite() && moved.distance(before) < 0.05,
                "{map:?} {}",
                point.y
            );
            before = moved;
        }
    }
}

#[test]
fn what_sticks_out_is_moved_rigidly_past_the_ease() {
    let (rest, bent) = (spine(line(6.0)), spine(arc(2.5, DVec3::Y, 6.0)));
    for map in MAPS {
        for from in [-0.5, 1.13] {
            let points = around(&rest, 300, [from, from + 0.3], 2.0);
            let there = image(&points, &rest, &bent, map);
            for (a, b) in [(0, 1), (5, 250), (100, 200)] {
                let (then, now) = (
                    points[a].distance(points[b]),
                    there.positions[a].distance(there.positions[b]),
                );
                assert!((then - now).abs() < 1e-9);
            }
            assert!(there.flags.iter().all(|f| *f == PAST_END));
        }
    }
}

#[test]
fn stretch_keeps_volume_between_unequal_lengths() {
    let (rest, bent) = (spine(line(5.0)), spine(arc(2.5, DVec3::Y, 6.0)));
    let points = around(&rest, 200, [0.05, 0.95], 0.4);
    let stretch = BendOptions {
        stretch: true,
        ..BendOptions::default()
    };
    for map in MAPS {
        let way = |step: DVec3| {
            let moved: Vec<DVec3> = points.iter().map(|p| *p + step).collect();
            let registered = register(&rest, map, &moved, &[]).unwrap();
            bend(&registered, &bent, &stretch).unwrap().positions
        };
        let h = 1e-5;
        let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|e| (way(h * e), way(-h * e)));
        for row in 0..points.len() {
            let column = |c: usize| (columns[c].0[row] - columns[c].1[row]) / (2.0 * h);
            let volume = column(0).dot(column(1).cross(column(2)));
            assert!((volume - 1.0).abs() < 1e-5, "{map:?} {volume}");
        }
    }
}

#[test]
fn a_ring_bends_into_a_ring() {
    let ring = |amplitude: f64| {
        let at = |i: u32| {
            let a = TAU * f64::from(i % 24) / 24.0;
            let wave = amplitude * (2.0 * a).sin();
            DVec3::new(2.0 * a.cos(), 2.0 * a.sin(), wave)
        };
        spine(Curve::BSpline((0..=24).map(at).collect()))
    };
    let (rest, bent) = (ring(0.0), ring(0.5));
    assert!(rest.closed() && bent.closed());
    let points = around(&rest, 2000, [0.0, 1.0], 0.4);
    for map in MAPS {
        let registered = register(&rest, map, &points, &[]).unwrap();
        let kept = bend(&registered, &bent, &BendOptions::default());
        assert!(kept.unwrap_err().to_string().contains("closed spines are"));
        let stretch = BendOptions {
            stretch: true,
            ..BendOptions::default()
        };
        let there = bend(&registered, &bent, &stretch).unwrap();
        let registered = register(&bent, map, &there.positions, &[]).unwrap();
        let back = bend(&registered, &rest, &stretch).unwrap();
        for (a, b) in back.positions.iter().zip(&points) {
            assert!(a.distance(*b) < 1e-9, "{map:?} {}", a.distance(*b));
        }
        // Both sides of the seam meet.
        let seam = [-1e-7, 1e-7].map(|s| rest.section(s).point(glam::DVec2::new(0.2, 0.1)));
        let registered = register(&rest, map, &seam, &[]).unwrap();
        let there = bend(&registered, &bent, &stretch).unwrap();
        assert!(there.positions[0].distance(there.positions[1]) < 1e-6);
        let open = spine(arc(2.0, DVec3::Y, 6.0));
        let torn = bend(&registered, &open, &BendOptions::default());
        assert!(torn.unwrap_err().to_string().contains("torn"));
    }
}

#[test]
fn a_circle_is_closed_and_twisted_by_whole_turns_only() {
    let full = arc(1.0, DVec3::Y, TAU);
    assert!(spine(full.clone()).closed());
    assert!(!spine(arc(1.0, DVec3::Y, 6.0)).closed());
    let twisted = |degrees: f64| {
        let mut desc = SpineDesc::new(full.clone());
        desc.twist.profile = vec![[0.0, 0.0], [1.0, degrees]];
        Spine::new(&desc)
    };
    assert!(twisted(360.0).is_ok());
    assert!(
        twisted(90.0)
            .unwrap_err()
            .to_string()
            .contains("whole turns")
    );
}

#[test]
fn twist_turns_cross_sections_and_keeps_volume() {
    let rest = spine(line(6.0));
    let mut desc = SpineDesc::new(arc(2.5, DVec3::Y, 6.0));
    desc.twist = Twist {
        degrees: 30.0,
        profile: vec![[0.0, 0.0], [0.5, 20.0], [1.0, 120.0]],
    };
    let (plain, twisted) = (spine(desc.curve.clone()), Spine::new(&desc).unwrap());
    for (share, degrees) in [(0.0, 30.0f64), (0.5, 50.0), (1.0, 150.0)] {
        let (a, b) = (plain.section(6.0 * share), twisted.section(6.0 * share));
        assert!((a.side.dot(b.side) - degrees.to_radians().cos()).abs() < 1e-9);
        assert!(a.side.cross(b.side).dot(a.tangent) > 0.0);
    }
    let points = around(&rest, 300, [0.05, 0.95], 0.4);
    for map in MAPS {
        for jacobian in jacobians(&points, &rest, &twisted, map, 1e-5) {
            assert!((jacobian.determinant() - 1.0).abs() < 1e-6, "{map:?}");
        }
    }
}

#[test]
fn the_middle_between_two_strands_is_ambiguous() {
    let at = |i: u32| {
        let a = PI * f64::from(i) / 20.0;
        DVec3::new(a.sin() * 2.0, a.cos(), 0.0)
    };
    let hairpin = spine(Curve::BSpline((0..=20).map(at).collect()));
    let between = DVec3::new(0.4, 0.0, 0.0);
    assert!(hairpin.closest(between).ambiguous);
    assert!(!hairpin.closest(DVec3::new(0.4, 0.8, 0.1)).ambiguous);
}

#[test]
fn rows_that_are_not_finite_are_named() {
    let rest = spine(line(6.0));
    let points = [DVec3::ZERO, DVec3::new(0.0, f64::NAN, 0.0)];
    let error = register(&rest, Map::Radial, &points, &[]).unwrap_err();
    assert_eq!(error.to_string(), "positions/1: is not finite");
    let far = [DVec3::splat(1e149), DVec3::splat(-1e200)];
    let error = register(&rest, Map::Radial, &far, &[]).unwrap_err();
    assert_eq!(error.to_string(), "positions/1: is too far away");
    let bent = spine(helix());
    assert!(image(&far[..1], &rest, &bent, Map::Radial).positions[0].is_finite());
    let error = register(&rest, Map::Radial, &points[..1], &points).unwrap_err();
    assert!(error.to_string().starts_with("normals: 2 for 1"));
    let registered = register(&rest, Map::Radial, &[], &[]).unwrap();
    let strong = BendOptions {
        strength: f64::NAN,
        ..BendOptions::default()
    };
    assert!(bend(&registered, &rest, &strong).is_err());
}
