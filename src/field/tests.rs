//! Fields of a capsule with an elbow, whose distance function is known.
#![allow(clippy::unwrap_used)]

use glam::{DVec3, Mat4, Vec3};

use super::*;
use crate::{
    mesh::Mesh,
    rig::{Joint, Skeleton},
};

/// A capsule of radius 0.5 from x = -2 to x = 2, scaled and moved.
fn capsule(scale: f32, origin: Vec3) -> Mesh {
    const AROUND: usize = 32;
    let mut profile = Vec::new();
    for i in 1..8 {
        let a = std::f32::consts::FRAC_PI_2 * i as f32 / 8.0;
        profile.push((-2.0 - 0.5 * a.cos(), 0.5 * a.sin()));
    }
    profile.extend((0..=40).map(|i| (-2.0 + i as f32 / 10.0, 0.5)));
    for i in (1..8).rev() {
        let a = std::f32::consts::FRAC_PI_2 * i as f32 / 8.0;
        profile.push((2.0 + 0.5 * a.cos(), 0.5 * a.sin()));
    }
    let mut points = vec![Vec3::new(-2.5, 0.0, 0.0)];
    for &(x, r) in &profile {
        for k in 0..AROUND {
            let (s, c) = (std::f32::consts::TAU * k as f32 / AROUND as f32).sin_cos();
            points.push(Vec3::new(x, r * c, r * s));
        }
    }
    points.push(Vec3::new(2.5, 0.0, 0.0));
    let last = points.len() as u32 - 1;
    let at = |ring: usize, k: usize| 1 + (ring * AROUND + k % AROUND) as u32;
    let mut triangles = Vec::new();
    for k in 0..AROUND {
        triangles.push([0, at(0, k + 1), at(0, k)]);
        triangles.push([last, at(profile.len() - 1, k), at(profile.len() - 1, k + 1)]);
        for ring in 0..profile.len() - 1 {
            let (a, b, c, d) = (
                at(ring, k),
                at(ring, k + 1),
                at(ring + 1, k),
                at(ring + 1, k + 1),
            );
            triangles.extend([[a, b, c], [c, b, d]]);
        }
    }
    let points = points.into_iter().map(|p| origin + scale * p).collect();
    Mesh::new(points, triangles)
}

/// Joints at the given places, each the child of the one before.
fn chain(places: &[Vec3]) -> Skeleton {
    let joints = places
        .iter()
        .enumerate()
        .map(|(i, &p)| Joint {
            name: format!("joint_{i}"),
            parent: i.checked_sub(1),
            bind: Mat4::from_translation(p),
            inverse_bind: Mat4::from_translation(-p),
        })
        .collect();
    let children = (0..places.len())
        .map(|i| {
            if i + 1 < places.len() {
                vec![i + 1]
            } else {
                vec![]
            }
        })
        .collect();
    Skeleton { joints, children }
}

/// Upper arm from x = -2 and forearm from the elbow at the origin.
pub(crate) fn arm(scale: f32, origin: Vec3) -> (Mesh, Fitted) {
    let mesh = capsule(scale, origin);
    let skeleton = chain(&[origin - 2.0 * scale * Vec3::X, origin]);
    let part = mesh
        .positions
        .iter()
        .map(|p| u16::from(p.x > origin.x))
        .collect();
    let fitted = fit(&mesh, &skeleton, part).unwrap();
    (mesh, fitted)
}

/// Points filling the box of a field, and points on its faces.
fn grid(bounds: &FieldBox, n: usize) -> Vec<(Vec3, bool)> {
    let to_rest = bounds.to_rest();
    (0..n * n * n)
        .map(|i| {
            let cell = [i % n, i / n % n, i / n / n];
            let face = cell.iter().any(|&c| c == 0 || c == n - 1);
            let at = cell.map(|c| c as f32 / (n - 1) as f32);
            (to_rest.transform_point3(Vec3::from(at)), face)
        })
        .collect()
}

#[test]
fn normals_of_the_test_mesh_point_outward() {
    let mesh = capsule(1.0, Vec3::ZERO);
    assert!(
        mesh.positions
            .iter()
            .zip(&mesh.normals)
            .all(|(p, n)| p.dot(*n) > 0.0)
    );
}

#[test]
fn a_capsule_is_fitted_in_any_unit() {
    for (scale, origin) in [
        (1.0, Vec3::ZERO),
        (100.0, Vec3::new(500.0, 3.0, -200.0)),
        (1e-3, Vec3::ZERO),
    ] {
        let (mesh, fitted) = arm(scale, origin);
        assert_eq!(fitted.fields.len(), 2);
        assert!(fitted.warnings.is_empty());
        for (v, &x) in mesh.positions.iter().enumerate() {
            let field = &fitted.fields[fitted.part[v] as usize];
            let (f, gradient) = field.evaluate(x);
            assert!((f - 0.5).abs() < 0.05, "{scale} {x}: {f}");
            let slope = gradient.length() * field.radius as f64;
            assert!((0.4..1.2).contains(&slope), "{scale} {x}: {slope}");
            assert!(gradient.dot(mesh.normals[v].as_dvec3()) < 0.0);
        }
        for field in &fitted.fields {
            assert!(
                (field.radius / scale - 0.5).abs() < 0.02,
                "{}",
                field.radius
            );
        }
    }
}

#[test]
fn fields_close_at_the_joint_and_overlap_there() {
    let (_, fitted) = arm(1.0, Vec3::ZERO);
    let at = |i: usize, x: f32| fitted.fields[i].evaluate(Vec3::new(x, 0.0, 0.0)).0;
    assert!(at(0, 0.0) > 0.8 && at(1, 0.0) > 0.8);
    // The closures lie one radius beyond the joint.
    assert!((at(0, 0.5) - 0.5).abs() < 0.05 && (at(1, -0.5) - 0.5).abs() < 0.05);
    assert!(at(0, 0.8) < 0.2 && at(1, -0.8) < 0.2);
}

#[test]
fn no_support_is_cut_and_boxes_are_tight() {
    let (_, fitted) = arm(1.0, Vec3::ZERO);
    for field in &fitted.fields {
        for (x, face) in grid(&field.bounds, 25) {
            let f = field.evaluate(x).0;
            assert!((0.0..=1.0).contains(&f));
            assert!(!face || f < 2e-3, "{x}: {f}");
        }
        // 2 of bone, caps of 1.5 at the tip and 1 at the joint at most; 2 across.
        assert!(
            field.bounds.size.x < 4.6 && field.bounds.size.y < 2.4,
            "{:?}",
            field.bounds
        );
        assert!(field.bounds.axes.x_axis.abs_diff_eq(Vec3::X, 1e-5));
    }
}

#[test]
fn the_gradient_is_the_derivative_also_in_the_fade() {
    let (_, fitted) = arm(1.0, Vec3::ZERO);
    let mut faded = 0;
    for (x, _) in grid(&fitted.fields[0].bounds, 14) {
        let field = &fitted.fields[0];
        let x = x.as_dvec3();
        let difference = DVec3::from_array(std::array::from_fn(|a| {
            let h = 1e-5 * DVec3::AXES[a];
            (field.at(x + h).0 - field.at(x - h).0) / 2e-5
        }));
        let (f, gradient) = field.at(x);
        faded += usize::from(f > 0.0 && field.to_bone(x).0 > FADE[0] as f64 * 0.5);
        assert!(
            difference.distance(gradient) < 1e-3,
            "{x} {difference} {gradient}"
        );
    }
    assert!(faded > 100, "{faded}");
}

#[test]
fn coincident_and_empty_joints_change_nothing() {
    let mesh = capsule(1.0, Vec3::ZERO);
    let places = [-2.0, -2.0, -1.0, 0.0, 0.0].map(|x| Vec3::new(x, 0.0, 0.0));
    let part = mesh
        .positions
        .iter()
        .map(|p| if p.x > 0.0 { 3 } else { 0 })
        .collect();
    let fitted = fit(&mesh, &chain(&places), part).unwrap();
    let (_, plain) = arm(1.0, Vec3::ZERO);
    for (a, b) in fitted.fields.iter().zip(&plain.fields) {
        assert!((a.radius - b.radius).abs() < 0.03);
        for x in [-1.5, -0.5, 0.3, 1.0] {
            let x = Vec3::new(x, 0.4, 0.1);
            assert!((a.evaluate(x).0 - b.evaluate(x).0).abs() < 0.1, "{x}");
        }
    }
}

#[test]
fn small_parts_join_their_parent() {
    let mesh = capsule(1.0, Vec3::ZERO);
    let skeleton = chain(&[-2.0, 0.0, 2.4].map(|x| Vec3::new(x, 0.0, 0.0)));
    let part: Vec<u16> = mesh
        .positions
        .iter()
        .map(|p| if p.x > 2.499 { 2 } else { u16::from(p.x > 0.0) })
        .collect();
    let fitted = fit(&mesh, &skeleton, part).unwrap();
    assert_eq!(fitted.fields.len(), 2);
    assert_eq!(*fitted.part.last().unwrap(), 1);
    assert_eq!(fitted.radius[2], fitted.radius[1]);
    assert!(fitted.warnings[0].contains("joint_2"));
}

#[test]
fn a_single_triangle_has_no_field() {
    let mesh = Mesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
    let fitted = fit(&mesh, &chain(&[Vec3::ZERO]), vec![0; 3]).unwrap();
    assert!(fitted.fields.is_empty() && fitted.part == [0, 0, 0] && fitted.radius[0] > 0.0);
    assert_eq!(fitted.warnings.len(), 1);
}

#[test]
fn a_partition_that_does_not_match_is_refused() {
    let mesh = Mesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
    let skeleton = chain(&[Vec3::ZERO]);
    assert!(fit(&mesh, &skeleton, vec![0; 2]).is_err());
    let error = fit(&mesh, &skeleton, vec![0, 1, 0]).unwrap_err();
    assert!(error.to_string().contains("vertex 1"));
}

#[test]
fn fitting_twice_gives_the_same_bits() {
    let (_, a) = arm(1.0, Vec3::ZERO);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let (_, b) = pool.install(|| arm(1.0, Vec3::ZERO));
    for (a, b) in a.fields.iter().zip(&b.fields) {
        assert_eq!(a.hrbf.lambda, b.hrbf.lambda);
        assert_eq!(a.bounds.size, b.bounds.size);
    }
}

#[test]
fn a_layer_below_another_is_not_sampled() {
    let outer = capsule(1.0, Vec3::ZERO);
    let inner = capsule(0.85, Vec3::ZERO);
    let count = outer.positions.len() as u32;
    let positions = [outer.positions, inner.positions].concat();
    let below = inner.triangles.iter().map(|t| t.map(|v| v + count));
    // A body under a coat with a lining: the inner layer once outward and once inward.
    let lining = inner
        .triangles
        .iter()
        .map(|t| [t[0], t[2], t[1]].map(|v| v + count));
    for layer in [below.collect::<Vec<_>>(), lining.collect()] {
        let triangles = [outer.triangles.clone(), layer].concat();
        let mesh = Mesh::new(positions.clone(), triangles);
        let part = vec![0; positions.len()];
        let fitted = fit(&mesh, &chain(&[-2.0 * Vec3::X, 2.0 * Vec3::X]), part).unwrap();
        for (v, &x) in mesh.positions.iter().enumerate() {
            let f = fitted.fields[0].evaluate(x).0;
            let expected = if v < count as usize {
                0.45..0.55
            } else {
                0.55..0.9
            };
            assert!(expected.contains(&f), "{v} {x}: {f}");
        }
    }
}
