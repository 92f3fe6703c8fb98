#![allow(clippy::unwrap_used)]

use glam::{Quat, Vec3};

use super::{
    Sheets::{Flat, Outer},
    *,
};

/// A closed tube along x with rounded ends, `rings` × `around` vertices, bent by `turn` radians at its middle.
pub(super) fn tube(rings: usize, around: usize, turn: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut points = Vec::new();
    for i in 0..rings {
        let t = (i as f32 + 0.5) / rings as f32 * 2.0 - 1.0;
        let r = 0.2 * (1.0 - t.powi(6)).max(0.0).sqrt();
        for k in 0..around {
            let a = k as f32 / around as f32 * std::f32::consts::TAU;
            points.push(Vec3::new(t, r * a.cos(), r * a.sin()));
        }
    }
    points.extend([Vec3::NEG_X, Vec3::X]);
    for p in &mut points {
        let angle = turn * (p.x * 2.0).clamp(0.0, 1.0);
        *p = Quat::from_rotation_z(angle) * *p;
    }
    let (n, m) = (around as u32, rings as u32);
    let mut triangles = Vec::new();
    for k in 0..n {
        let next = (k + 1) % n;
        for i in 0..m - 1 {
            let [a, b, c, d] = [i * n + k, i * n + next, (i + 1) * n + k, (i + 1) * n + next];
            triangles.extend([[a, b, c], [b, d, c]]);
        }
        triangles.push([m * n, next, k]);
        triangles.push([m * n + 1, (m - 1) * n + k, (m - 1) * n + next]);
    }
    (points, triangles)
}

pub(super) fn bending(frames: usize) -> Sequence {
    let turn = |f: usize| f as f32 * 0.2;
    Sequence {
        triangles: tube(24, 12, 0.0).1,
        frames: (0..frames).map(|f| tube(24, 12, turn(f)).0).collect(),
        ..Sequence::default()
    }
}

pub(super) fn built(sequence: &Sequence) -> Hierarchy {
    build(sequence, &Options::default(), &|_| {}).unwrap()
}

/// A sphere of `rings` × 2 `rings` vertices.
fn ball(rings: usize, centre: Vec3, radius: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut points, triangles) = tube(rings, 2 * rings, 0.0);
    for p in &mut points {
        let around = Vec3::new(0.0, p.y, p.z).normalize_or_zero();
        let angle = p.x * std::f32::consts::FRAC_PI_2;
        *p = centre + radius * (Vec3::X * angle.sin() + around * angle.cos());
    }
    (points, triangles)
}

#[test]
fn a_ball_that_moves_becomes_one_sphere_of_its_radius() {
    let path = |f: usize| Vec3::new(f as f32 * 0.3, (f * f) as f32 * 0.1, 5.0);
    let sequence = Sequence {
        triangles: ball(16, Vec3::ZERO, 1.0).1,
        frames: (0..5).map(|f| ball(16, path(f), 0.5).0).collect(),
        ..Sequence::default()
    };
    let hierarchy = built(&sequence);
    assert_eq!(hierarchy.range().start, 1);
    let level = hierarchy.level(1).unwrap();
    let node = level.nodes[0] as usize;
    for f in 0..5 {
        assert!(
            hierarchy.centre(node, f).distance(path(f)) < 1e-3,
            "frame {f}"
        );
    }
    // The planes of an inscribed polyhedron are a little nearer than the sphere: by 1 - cos(π / 32) at most.
    let radius = hierarchy.radius(node);
    assert!((0.5 * 0.985..0.5).contains(&radius), "{radius}");
    assert!(hierarchy.error(1) < 0.5 && hierarchy.error(1) > 0.0);
}

#[test]
fn a_bending_tube_becomes_a_chain() {
    let hierarchy = built(&bending(6));
    let level = hierarchy.level(5).unwrap().optimised(&hierarchy);
    let radii = level.nodes.iter().map(|&n| hierarchy.radius(n as usize));
    let inside = radii.filter(|r| (0.1..0.25).contains(r)).count();
    assert!(inside >= 3, "{level:?}");
    assert!(!level.edges.is_empty());
}

#[test]
fn every_level_opens_and_partitions_the_vertices() {
    let hierarchy = built(&bending(3));
    let range = hierarchy.range();
    assert_eq!(range.end - 1, hierarchy.vertices);
    for spheres in [range.start, 2, 7, 100, hierarchy.vertices] {
        let level = hierarchy.level(spheres).unwrap();
        assert_eq!(level.nodes.len(), spheres);
        let regions = hierarchy.regions(&level);
        let total: usize = (0..spheres).map(|k| regions.row(k).len()).sum();
        assert_eq!(total, hierarchy.vertices);
        assert!((0..spheres).all(|k| !regions.row(k).is_empty()));
    }
    assert_eq!(
        hierarchy.level(hierarchy.vertices).unwrap().triangles.len(),
        hierarchy.triangles.len()
    );
    let error = hierarchy
        .level(hierarchy.vertices + 1)
        .unwrap_err()
        .to_string();
    assert!(error.contains("1 (one a component) to 290"), "{error}");
    assert!(hierarchy.level(0).is_err());
}

#[test]
fn an_error_picks_the_least_number_of_spheres() {
    let hierarchy = built(&bending(3));
    for error in [0.05, 0.5, 2.0] {
        let spheres = hierarchy.spheres_for(error);
        assert!(hierarchy.error(spheres) <= error);
        assert!(spheres == 1 || hierarchy.error(spheres - 1) > error);
    }
    assert_eq!(hierarchy.spheres_for(1e9), 1);
}

#[test]
fn the_classic_metric_has_no_radius_and_a_greater_error() {
    let sequence = bending(4);
    let classic = build(&sequence, &Options::classic(), &|_| {}).unwrap();
    assert!(classic.merges.iter().all(|m| m.radius == 0.0));
    let plain = Options {
        curvature: 0.0,
        ..Options::default()
    };
    let spheres = build(&sequence, &plain, &|_| {}).unwrap();
    assert!(
        spheres.error(6) < 0.7 * classic.error(6),
        "{} {}",
        spheres.error(6),
        classic.error(6)
    );
}

#[test]
fn temporal_coherence_keeps_spheres_at_the_middle_of_their_regions() {
    let sequence = bending(6);
    let drift = |temporal| {
        let options = Options {
            temporal,
            ..Options::default()
        };
        let hierarchy = build(&sequence, &options, &|_| {}).unwrap();
        let level = hierarchy.level(8).unwrap();
        let regions = hierarchy.regions(&level);
        let mut sum = 0.0;
        for (k, &node) in level.nodes.iter().enumerate() {
            let row = regions.row(k);
            let middle = |f| {
                row.iter()
                    .map(|&v| hierarchy.position(v as usize, f))
                    .sum::<Vec3>()
            };
            let off = |f| hierarchy.centre(node as usize, f) - middle(f) / row.len() as f32;
            sum += (1..6).map(|f| off(f).distance(off(0))).sum::<f32>();
        }
        sum
    };
    let (free, held) = (drift(0.0), drift(100.0));
    assert!(held < 0.8 * free, "{free} {held}");
}

#[test]
fn the_same_sequence_gives_the_same_hierarchy_whatever_the_threads() {
    let sequence = bending(5);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let alone = pool.install(|| built(&sequence));
    assert_eq!(alone, built(&sequence));
}

#[test]
fn seams_are_welded_where_they_stay_closed() {
    let (points, triangles) = tube(8, 6, 0.0);
    // Every triangle has corners of its own.
    let rows: Vec<Vec3> = triangles
        .iter()
        .flatten()
        .map(|&v| points[v as usize])
        .collect();
    let apart: Vec<[u32; 3]> = (0..triangles.len() as u32)
        .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
        .collect();
    let mut sequence = Sequence {
        triangles: apart,
        frames: vec![rows.clone(), rows],
        ..Sequence::default()
    };
    assert_eq!(built(&sequence).vertices, points.len());
    sequence.frames[1][0] += Vec3::X;
    assert_eq!(built(&sequence).vertices, points.len() + 1);
}

#[test]
fn a_level_that_is_a_point_is_as_far_as_the_point() {
    let corners = [-3.0, 3.0].map(|x| Vec3::new(x, 0.0, 0.0));
    let sequence = Sequence {
        path: "x".into(),
        frames: vec![vec![corners[0], corners[1], Vec3::Y * 4.0]],
        triangles: vec![[0, 1, 2]],
    };
    let classic = build(&sequence, &Options::classic(), &|_| {}).unwrap();
    let level = classic.level(1).unwrap();
    let point = Shape::new(&classic, &level, 0).balls[0].centre;
    let farthest = sequence.frames[0].iter();
    let farthest = farthest
        .map(|p| p.as_dvec3().distance(point))
        .fold(0.0, f64::max);
    let d = distances(&classic, &level, Flat, 0);
    let percent = 100.0 / 52f64.sqrt();
    assert!((d.hausdorff - percent * farthest).abs() < 1e-3, "{d:?}");
    assert!(d.m12 > 0.1 * d.hausdorff && d.m12 < d.hausdorff, "{d:?}");
}

#[test]
fn malformed_sequences_give_an_error_or_something_valid() {
    let one = |frames: Vec<Vec<Vec3>>, triangles: Vec<[u32; 3]>| Sequence {
        path: "x".into(),
        frames,
        triangles,
    };
    let corner = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    for bad in [
        one(vec![], vec![]),
        one(vec![vec![]], vec![]),
        one(vec![corner.clone(), corner[..2].to_vec()], vec![[0, 1, 2]]),
        one(vec![vec![Vec3::NAN, Vec3::X, Vec3::Y]], vec![[0, 1, 2]]),
        one(vec![corner.clone()], vec![[0, 1, 3]]),
        one(vec![corner.clone()], vec![[0, 1, 1]]),
        one(vec![vec![Vec3::ONE; 3]], vec![[0, 1, 2]]),
        one(
            vec![
                corner.clone(),
                corner.iter().map(|p| *p + Vec3::X * 1e7).collect(),
            ],
            vec![[0, 1, 2]],
        ),
    ] {
        let error = build(&bad, &Options::default(), &|_| {}).unwrap_err();
        assert!(error.to_string().contains('x'), "{error}");
    }
    let ten = (0..10u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let apart = (0..30).map(|i| corner[i % 3] + Vec3::Z * (i / 3) as f32);
    let grid = (0..25).map(|i| Vec3::new((i % 5) as f32, (i / 5) as f32, 0.0));
    let quads = (0..20u32).filter(|i| i % 5 != 4);
    let flat = quads.flat_map(|i| [[i, i + 1, i + 5], [i + 1, i + 6, i + 5]]);
    let line = vec![Vec3::ZERO, Vec3::X, Vec3::X * 2.0];
    for (good, least) in [
        (one(vec![corner.clone()], vec![[0, 1, 2]]), 1),
        (one(vec![apart.collect()], ten), 10),
        (one(vec![grid.collect()], flat.collect()), 1),
        (one(vec![line], vec![[0, 1, 2]]), 1),
        (
            one(vec![corner.clone(), vec![Vec3::ONE; 3]], vec![[0, 1, 2]]),
            1,
        ),
        (
            one(
                vec![corner.iter().map(|p| *p * 1e-12).collect()],
                vec![[0, 1, 2]],
            ),
            1,
        ),
        (
            one(
                vec![corner.iter().map(|p| *p * 1e12).collect()],
                vec![[0, 1, 2]],
            ),
            1,
        ),
        (one(vec![corner], vec![[0, 1, 2], [0, 1, 2], [2, 1, 0]]), 1),
    ] {
        for options in [Options::default(), Options::classic()] {
            let hierarchy = build(&good, &options, &|_| {}).unwrap();
            assert_eq!(hierarchy.range().start, least);
            assert!(hierarchy.centres.iter().all(|x| x.is_finite()));
            assert!(
                hierarchy
                    .merges
                    .iter()
                    .all(|m| m.total.is_finite() && m.radius >= 0.0)
            );
            let level = hierarchy.level(least).unwrap().optimised(&hierarchy);
            assert_eq!(level.labels.len(), hierarchy.vertices);
            for (frame, sheets) in (0..hierarchy.frames).flat_map(|f| [(f, Outer), (f, Flat)]) {
                let d = distances(&hierarchy, &level, sheets, frame);
                let all = [d.hausdorff, d.m12, d.m21];
                assert!(all.iter().all(|x| x.is_finite()), "{all:?}");
            }
        }
    }
    let wrong = Options {
        curvature: f64::NAN,
        ..Options::default()
    };
    assert!(build(&bending(1), &wrong, &|_| {}).is_err());
}

#[test]
fn between_frames_spheres_go_straight_and_outside_they_stay() {
    let hierarchy = built(&bending(3));
    let level = hierarchy.level(12).unwrap();
    let frames = [0, 1, 2].map(|frame| Shape::new(&hierarchy, &level, frame));
    let at = |time: f64| Shape::at(&hierarchy, &level, time);
    for (time, frame) in [(0.0, 0), (1.0, 1), (2.0, 2), (-3.0, 0), (7.5, 2)] {
        assert_eq!(at(time).balls, frames[frame].balls, "{time}");
    }
    let between = at(1.25);
    assert_eq!(between.edges, frames[0].edges);
    assert_eq!(between.triangles, frames[0].triangles);
    for (row, ball) in between.balls.iter().enumerate() {
        let [a, b] = [1, 2].map(|f: usize| frames[f].balls[row].centre);
        assert!(ball.centre.distance(a * 0.75 + b * 0.25) < 1e-6);
        assert_eq!(ball.radius, frames[0].balls[row].radius);
    }
    assert!(between.balls != frames[1].balls);
}
