#![allow(clippy::unwrap_used)]
//! Spines: arc length, frames, closest points, and curves that are none.

use std::f64::consts::TAU;

use glam::DVec3;

use super::*;

fn round() -> Round {
    Round {
        start: DVec3::new(1.0, 2.0, 3.0),
        tangent: DVec3::new(2.0, 0.0, 1.0),
        normal: DVec3::new(0.0, 3.0, 0.0),
        radius: 1.5,
        length: 8.0,
    }
}

fn wave(count: u32, close: bool) -> Vec<DVec3> {
    let at = |i: u32| {
        let a = TAU * f64::from(i % count) / f64::from(count);
        DVec3::new(3.0 * a.cos(), 2.0 * a.sin(), 0.6 * (3.0 * a).sin())
    };
    (0..count + u32::from(close)).map(at).collect()
}

fn curves() -> Vec<(&'static str, Curve)> {
    vec![
        ("two points", Curve::BSpline(vec![DVec3::ZERO, DVec3::Y])),
        ("polynomial", Curve::Polynomial(wave(9, false))),
        ("B-spline", Curve::BSpline(wave(14, false))),
        ("closed B-spline", Curve::BSpline(wave(14, true))),
        ("polyline", Curve::Polyline(wave(200, false))),
        ("closed polyline", Curve::Polyline(wave(200, true))),
        ("arc", Curve::Arc(round())),
        (
            "helix",
            Curve::Helix {
                round: round(),
                pitch: -2.0,
            },
        ),
    ]
}

/// Tangent, curvature, frame and rates are the derivatives that they say, by arc length; past the ends too.
#[test]
fn a_spine_goes_by_arc_length_with_a_frame_that_does_not_turn() {
    for (name, curve) in curves() {
        let spine = Spine::new(&SpineDesc::new(curve)).unwrap();
        let (length, h) = (spine.length(), 1e-5);
        // Where a polyline's stretches meet, third derivatives jump.
        let coarse: f64 = if name.contains("polyline") {
            1e-2
        } else {
            1e-5
        };
        for i in -30..130 {
            let s = length * (f64::from(i) + 0.37) / 100.0;
            let (a, b, c) = (spine.section(s - h), spine.section(s), spine.section(s + h));
            let plane = |k: glam::DVec2| k.x * b.side + k.y * b.lift;
            let slope = |f: fn(&Section) -> DVec3| (f(&c) - f(&a)) / (2.0 * h);
            assert!(
                slope(|s| s.position).distance(b.tangent) < 1e-8,
                "{name} {i}"
            );
            let near = slope(|s| s.tangent).distance(plane(b.curvature));
            assert!(near < 1e-6, "{name} {i} {near:e}");
            let turn = slope(|s| s.side).dot(b.lift);
            assert!((turn - b.twist_rate).abs() < 1e-6, "{name} {i} {turn}");
            // Cubic between samples.
            if !spine.closed() {
                assert!(turn.abs() < 1e-4, "{name} {i} {turn}");
            }
            let rate = (c.curvature - a.curvature) / (2.0 * h);
            let near = rate.distance(b.curvature_rate);
            assert!(
                near < coarse.max(1e-3 * f64::from(u8::from(!(0..100).contains(&i)))),
                "{name} {i} {near:e}"
            );
            for v in [b.side, b.lift, b.tangent] {
                assert!((v.length() - 1.0).abs() < 1e-12);
            }
            assert!(b.side.dot(b.tangent).abs() < 1e-12);
        }
    }
}

#[test]
fn curves_go_through_their_points() {
    for curve in [
        Curve::Polynomial(wave(9, false)),
        Curve::BSpline(wave(14, false)),
        Curve::BSpline(wave(14, true)),
        Curve::Polyline(wave(200, true)),
    ] {
        let spine = Spine::new(&SpineDesc::new(curve.clone())).unwrap();
        let (Curve::Polynomial(points) | Curve::BSpline(points) | Curve::Polyline(points)) = curve
        else {
            unreachable!()
        };
        for point in points {
            let found = spine.closest(point);
            assert!(found.distance < 1e-9, "{point} {found:?}");
        }
    }
}

#[test]
fn arcs_and_helices_are_what_they_say() {
    let arc = Spine::new(&SpineDesc::new(Curve::Arc(round()))).unwrap();
    let centre = round().start + 1.5 * DVec3::Y;
    for i in 0..=20 {
        let section = arc.section(0.4 * f64::from(i));
        assert!((section.position.distance(centre) - 1.5).abs() < 1e-11);
        assert!((section.curvature.length() - 1.0 / 1.5).abs() < 1e-9);
    }
    assert!((arc.length() - 8.0).abs() < 1e-12);
    let pitch = 2.0;
    let long = Round {
        length: 20.0,
        ..round()
    };
    let helix = Curve::Helix { round: long, pitch };
    let helix = Spine::new(&SpineDesc::new(helix)).unwrap();
    let start = helix.section(0.0);
    assert!(start.tangent.distance(round().tangent.normalize()) < 1e-12);
    // A turn later it is one pitch along the axis, which the tangent leans towards.
    let turn = (TAU * 1.5).hypot(pitch);
    let risen = helix.section(turn).position - start.position;
    assert!((risen.length() - pitch).abs() < 1e-9);
    assert!((risen.dot(start.tangent) - pitch * pitch / turn).abs() < 1e-9);
    assert!(risen.dot(start.tangent.cross(DVec3::Y)) > 0.0);
}

/// Against all of a fine sampling.
#[test]
fn the_closest_point_is_the_closest() {
    for (name, curve) in curves() {
        let spine = Spine::new(&SpineDesc::new(curve)).unwrap();
        let samples: Vec<DVec3> = (0..=20_000)
            .map(|i| {
                spine
                    .section(spine.length() * f64::from(i) / 20_000.0)
                    .position
            })
            .collect();
        for i in 0..200u32 {
            let a = f64::from(i);
            let point = DVec3::new((1.3 * a).sin(), (2.7 * a).cos(), (0.9 * a).sin());
            let point = spine
                .section(spine.length() * (0.5 + 0.4 * (0.7 * a).sin()))
                .position
                + 1.2 * point;
            let found = spine.closest(point);
            let least = samples
                .iter()
                .map(|s| s.distance(point))
                .fold(f64::INFINITY, f64::min);
            assert!(found.distance <= least + 1e-12, "{name} {point}");
            let section = spine.section(found.arc);
            let way = point - section.position;
            assert!((way.length() - found.distance).abs() < 1e-9);
            assert!(
                way.dot(section.tangent).abs() < 1e-9 * (1.0 + way.length()),
                "{name} {point}"
            );
        }
    }
}

#[test]
fn a_frame_starts_as_asked() {
    let mut desc = SpineDesc::new(Curve::Arc(round()));
    desc.up = Some(DVec3::new(1.0, 1.0, 0.0));
    let spine = Spine::new(&desc).unwrap();
    let start = spine.section(0.0);
    let wanted = DVec3::new(1.0, 1.0, 0.0).reject_from_normalized(start.tangent);
    assert!(start.side.distance(wanted.normalize()) < 1e-12);
    // Without an up, as the rest spine does, by the shortest way.
    let rest = Spine::new(&SpineDesc::new(Curve::BSpline(vec![DVec3::ZERO, DVec3::Z]))).unwrap();
    desc.up = None;
    let like = Spine::like(&desc, &rest).unwrap().section(0.0);
    let axis = DVec3::Z.cross(like.tangent).normalize();
    let before = rest.section(0.0).side;
    assert!((before.dot(axis) - like.side.dot(axis)).abs() < 1e-12);
}

#[test]
fn curves_that_are_none_are_refused_by_name() {
    let refused = |curve: Curve, part: &str| {
        let error = Spine::new(&SpineDesc::new(curve)).unwrap_err().to_string();
        assert!(error.contains(part), "{error}: {part}");
    };
    let p = |x: f64| DVec3::new(x, 0.0, 0.0);
    for curve in [Curve::Polynomial, Curve::BSpline, Curve::Polyline] {
        refused(curve(vec![]), "points: 0 given");
        refused(curve(vec![p(1.0)]), "points: 1 given");
        refused(curve(vec![p(0.0), p(f64::NAN)]), "points/1: is not finite");
        refused(
            curve(vec![p(0.0), p(f64::INFINITY)]),
            "points/1: is not finite",
        );
    }
    refused(
        Curve::BSpline(vec![p(0.0), p(0.0)]),
        "points/1: is the same",
    );
    refused(
        Curve::Polyline(vec![p(2.0), p(2.0), p(2.0)]),
        "points: 1 given",
    );
    refused(
        Curve::Polynomial((0..17).map(|i| p(f64::from(i))).collect()),
        "2 to 16",
    );
    // There and back again on a line: a cusp.
    refused(Curve::Polynomial(vec![p(0.0), p(1.0), p(0.0)]), "cusp");
    let with = |change: fn(&mut Round)| {
        let mut round = round();
        change(&mut round);
        Curve::Arc(round)
    };
    refused(with(|r| r.radius = 0.0), "radius: 0");
    refused(with(|r| r.radius = f64::NAN), "radius: NaN");
    refused(with(|r| r.length = -1.0), "length: -1");
    refused(with(|r| r.length = 0.0), "length: 0");
    refused(with(|r| r.length = 100.0), "full circle");
    refused(with(|r| r.tangent = DVec3::ZERO), "tangent");
    refused(with(|r| r.normal = r.tangent), "normal");
    refused(with(|r| r.start.x = f64::NAN), "start");
    let mut desc = SpineDesc::new(Curve::Arc(round()));
    desc.up = Some(round().tangent);
    assert!(Spine::new(&desc).unwrap_err().to_string().starts_with("up"));
    desc.up = None;
    desc.ease = 2.0;
    assert!(
        Spine::new(&desc)
            .unwrap_err()
            .to_string()
            .starts_with("ease")
    );
}

/// What a shader would make of the cells is the section.
#[test]
fn cells_are_all_that_a_section_needs() {
    for (name, curve) in curves() {
        let spine = Spine::new(&SpineDesc::new(curve)).unwrap();
        let cells: Vec<SpineCell> = spine.cells().collect();
        let [begin, end] = spine.reach();
        assert!((begin + spine.step() * cells.len() as f64 - end).abs() < 1e-12);
        for i in 0..50 {
            let s = begin + (end - begin) * (f64::from(i) + 0.5) / 50.0;
            let row = ((s - begin) / spine.step()) as usize;
            let u = (s - begin) / spine.step() - row as f64;
            let value = |rows: &[[f64; 3]], order: i32| {
                let term = |(power, row): (usize, &[f64; 3])| {
                    let power = power as i32;
                    let factor: f64 = (0..order).map(|k| f64::from(power - k)).product();
                    match power >= order {
                        true => factor * u.powi(power - order) * DVec3::from_array(*row),
                        false => DVec3::ZERO,
                    }
                };
                rows.iter().enumerate().map(term).sum::<DVec3>() / spine.step().powi(order)
            };
            let (cell, section) = (&cells[row], spine.section(s));
            let tangent = value(&cell.curve, 1).normalize();
            let side = value(&cell.side, 0).reject_from_normalized(tangent);
            let curvature = value(&cell.curve, 2);
            assert!(
                value(&cell.curve, 0).distance(section.position) < 1e-12,
                "{name}"
            );
            assert!(tangent.distance(section.tangent) < 1e-12);
            assert!(side.normalize().distance(section.side) < 1e-12);
            let plane = glam::DVec2::new(curvature.dot(section.side), curvature.dot(section.lift));
            let near = plane.distance(section.curvature);
            // The curve's speed, which the section divides by, is 1 to about 1e-9 where few cells ease the curvature.
            assert!(near < 1e-8 * (1.0 + plane.length()), "{name} {near:e}");
        }
    }
}

/// Extreme numbers: a spine that is finite everywhere, or a refusal; never a panic, a NaN or an endless loop.
#[test]
fn extreme_curves_are_finite_or_refused() {
    let sizes = [1e-300, 1e-160, 1e-30, 1e-6, 1.0, 1e6, 1e30, 1e160, 1e300];
    let check = |curve: Curve| {
        let Ok(spine) = Spine::new(&SpineDesc::new(curve.clone())) else {
            return false;
        };
        for share in [-2.0, -0.06, 0.0, 0.37, 1.0, 1.1, 5.0] {
            let section = spine.section(share * spine.length());
            let vectors = [
                section.position,
                section.tangent,
                section.side,
                section.lift,
            ];
            assert!(
                vectors.iter().all(|v| v.is_finite()),
                "{curve:?} {section:?}"
            );
            assert!(section.curvature.is_finite(), "{curve:?} {section:?}");
            let found = spine.closest(section.position);
            assert!(
                found.arc.is_finite() && found.distance.is_finite(),
                "{curve:?}"
            );
        }
        true
    };
    let mut fine = 0;
    for radius in sizes {
        for length in sizes {
            for pitch in [0.0, 1e-300, 1.0, 1e300] {
                let round = Round {
                    radius,
                    length,
                    ..round()
                };
                fine += u32::from(check(Curve::Helix { round, pitch }));
                fine += u32::from(check(Curve::Arc(round)));
            }
        }
        for points in [wave(7, false), wave(7, true)] {
            let points: Vec<DVec3> = points.iter().map(|p| radius * *p).collect();
            fine += u32::from(check(Curve::Polynomial(points.clone())));
            fine += u32::from(check(Curve::BSpline(points.clone())));
            fine += u32::from(check(Curve::Polyline(points)));
        }
    }
    assert!(fine > 100, "{fine}");
    // Noise that no smooth curve follows, and more turns than samples.
    let noise = |i: u32| DVec3::new(f64::from(i), (f64::from(i) * 12.9898).sin() * 50.0, 0.0);
    check(Curve::Polyline((0..20_000).map(noise).collect()));
    let round = Round {
        radius: 1e-3,
        length: 1e3,
        ..round()
    };
    let wound = Spine::new(&SpineDesc::new(Curve::Helix { round, pitch: 1e-3 }));
    assert!(wound.unwrap_err().to_string().contains("too often"));
}
