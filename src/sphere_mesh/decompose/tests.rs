#![allow(clippy::unwrap_used)]

use glam::{Quat, Vec3};

use super::*;
use crate::{
    asset::{self, Room},
    sphere_mesh::{
        build,
        tests::{bending, tube},
    },
};

/// Weight of the right half of the tube.
fn right(x: f32) -> f32 {
    let t = ((x + 0.3) / 0.6).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A tube of two bones: the right one bends by `turn` a frame about the middle, both drift.
fn two_bones(frames: usize, turn: f32) -> Sequence {
    let (rest, triangles) = tube(40, 12, 0.0);
    let frame = |f: usize| {
        let bend = Quat::from_rotation_z(turn * f as f32);
        let drift = Vec3::new(0.0, 0.05, 0.02) * f as f32;
        let skin = |p: &Vec3| p.lerp(bend * *p, right(p.x)) + drift;
        rest.iter().map(skin).collect()
    };
    Sequence {
        path: "two.bones".into(),
        triangles,
        frames: (0..frames).map(frame).collect(),
    }
}

fn decomposed(clips: &[Sequence], spheres: usize, options: &Decomposing) -> Decomposition {
    let (hierarchy, level) = opened(&clips[0], spheres);
    decompose(&hierarchy, &level, clips, options, &|_| {}).unwrap()
}

fn opened(sequence: &Sequence, spheres: usize) -> (Hierarchy, Level) {
    let hierarchy = build(sequence, &crate::sphere_mesh::Options::default(), &|_| {}).unwrap();
    let level = hierarchy.level(spheres).unwrap().optimised(&hierarchy);
    (hierarchy, level)
}

fn animation() -> Decomposing {
    Decomposing {
        weighting: Weighting::Animation,
        ..Decomposing::default()
    }
}

/// Positive weights that sum to 1, at most `most` a vertex, and every sphere's skin in one piece.
fn check_weights(result: &Decomposition, sequence: &Sequence, most: usize) {
    for list in &result.influences {
        assert!((1..=most).contains(&list.len()), "{list:?}");
        assert!(list.iter().all(|p| p.1 > 0.0), "{list:?}");
        assert!(list.is_sorted_by(|a, b| a.1 >= b.1), "{list:?}");
        assert!(
            (list.iter().map(|p| p.1).sum::<f32>() - 1.0).abs() < 1e-5,
            "{list:?}"
        );
    }
    let hierarchy = build(sequence, &crate::sphere_mesh::Options::default(), &|_| {}).unwrap();
    let ring = Mesh::new(result.rest.clone(), hierarchy.triangles).one_ring;
    let mut bones = vec![Vec::new(); result.centres.len()];
    for (v, list) in result.influences.iter().enumerate() {
        let pairs = list.iter().map(|&(s, w)| (s as usize, f64::from(w)));
        pairs.for_each(|(s, w)| bones[s].push((v as u32, w)));
    }
    for (sphere, vertices) in bones.iter().enumerate() {
        let pieces = islands::pieces(&ring, vertices);
        assert!(
            pieces.iter().all(|p| *p == 0),
            "sphere {sphere} has islands"
        );
    }
}

#[test]
fn two_bones_are_found_again() {
    let sequence = two_bones(8, 0.12);
    let long = Decomposing {
        iterations: 300,
        tolerance: 0.0,
        ..animation()
    };
    let found = decomposed(std::slice::from_ref(&sequence), 2, &long);
    assert!(found.e_rms < 0.2, "{}", found.e_rms);
    check_weights(&found, &sequence, 2);
    // The rotation of one against the other since the first frame is what it was, in every frame.
    let turn = |frame: &[(DMat3, DVec3)]| frame[0].0.transpose() * frame[1].0;
    let first = turn(&found.motions[0][0]);
    for (f, frame) in found.motions[0].iter().enumerate() {
        let since = first.transpose() * turn(frame);
        let angle = glam::DQuat::from_mat3(&since).to_axis_angle().1.abs();
        let angle = angle.min(std::f64::consts::TAU - angle);
        assert!((angle - 0.12 * f as f64).abs() < 0.02, "frame {f}: {angle}");
    }
    let mixed = decomposed(&[sequence], 2, &Decomposing::default());
    assert!(mixed.e_rms < 2.0, "{}", mixed.e_rms);
}

#[test]
fn weights_are_positive_sum_to_one_and_have_no_islands() {
    let sequence = bending(7);
    for (influences, spheres) in [(1, 5), (2, 9), (4, 9), (8, 30)] {
        for weighting in [Weighting::Mixed, Weighting::Animation] {
            let options = Decomposing {
                influences,
                weighting,
                ..Decomposing::default()
            };
            let found = decomposed(std::slice::from_ref(&sequence), spheres, &options);
            check_weights(&found, &sequence, influences);
        }
    }
}

#[test]
fn more_influences_and_iterations_lower_the_error() {
    let sequence = bending(7);
    let error = |influences, iterations| {
        let options = Decomposing {
            influences,
            iterations,
            tolerance: 0.0,
            ..animation()
        };
        decomposed(std::slice::from_ref(&sequence), 6, &options).e_rms
    };
    assert!(error(4, 20) < 0.8 * error(1, 20));
    assert!(error(4, 20) < 0.8 * error(4, 1));
}

#[test]
fn iterations_end_by_tolerance_or_number() {
    let sequence = bending(5);
    let with = |tolerance, iterations| {
        let options = Decomposing {
            tolerance,
            iterations,
            ..Decomposing::default()
        };
        let found = decomposed(std::slice::from_ref(&sequence), 6, &options);
        (found.iterations, found.converged)
    };
    assert_eq!(with(0.0, 3), (3, false));
    let (few, converged) = with(0.15, 60);
    assert!(few < 20 && converged, "{few}");
    let (more, _) = with(0.005, 60);
    assert!(more > few, "{more} {few}");
    assert_eq!(with(0.002, 0), (0, false));
}

#[test]
fn a_rise_of_the_error_does_not_end_the_iterations() {
    let falls: Vec<f64> = (0..12).map(|k| 0.99f64.powi(k)).collect();
    let ends = |errors: &[f64]| settled(errors, 5e-3);
    assert!((0..=falls.len()).all(|n| !ends(&falls[..n])));
    // Bones are chosen anew, and what follows is worse for two iterations, then better than ever.
    let mut risen = falls.clone();
    risen.extend([falls[11] * 1.1, falls[11] * 1.02, falls[11] * 0.95]);
    assert!((13..=15).all(|n| !ends(&risen[..n])));
    let flat = [&falls[..], &[falls[11] * 0.999; 5]].concat();
    assert!(!ends(&flat[..14]) && ends(&flat));
}

#[test]
fn what_moves_as_one_can_be_posed_apart_with_mixed_weights() {
    // The right half is rigid, and several spheres' regions lie in it.
    let sequence = two_bones(8, 0.12);
    let found = decomposed(&[sequence], 8, &Decomposing::default());
    let rigid: Vec<usize> = (0..8).filter(|&s| found.centres[s].x > 0.4).collect();
    assert!(rigid.len() >= 2, "{:?}", found.centres);
    for sphere in rigid {
        let weights = found.influences.iter().flatten();
        let own = weights.filter(|p| p.0 as usize == sphere);
        let most = own.map(|p| p.1).fold(0.0, f32::max);
        let leads = found.influences.iter().any(|l| l[0].0 as usize == sphere);
        assert!(leads && most > 0.4, "sphere {sphere}: {most}");
    }
    assert!(found.e_rms < 2.0, "{}", found.e_rms);
}

#[test]
fn spheres_that_hold_together_come_less_apart() {
    let sequence = bending(7);
    let (hierarchy, level) = opened(&sequence, 8);
    let apart = |joints| {
        let options = Decomposing {
            joints,
            ..Decomposing::default()
        };
        let found = decomposed(std::slice::from_ref(&sequence), 8, &options);
        let rest: Vec<DVec3> = found.rest.iter().map(|p| p.as_dvec3()).collect();
        let borders = border::borders(&hierarchy.triangles, &level.labels, &rest);
        let mut sum = 0.0;
        for frame in found.motions.iter().flatten() {
            for border in &borders {
                let [a, b] = border
                    .spheres
                    .map(|s| frame[s].0 * border.middle + frame[s].1);
                sum += a.distance_squared(b);
            }
        }
        (sum, found.e_rms)
    };
    let (free, held) = (apart(0.0), apart(1.0));
    assert!(held.0 < 0.25 * free.0, "{free:?} {held:?}");
    assert!(held.1 > free.1, "{free:?} {held:?}");
}

#[test]
fn clips_share_rest_pose_and_weights() {
    let clips = [two_bones(5, 0.15), two_bones(3, -0.2)];
    let found = decomposed(&clips, 3, &animation());
    assert_eq!(
        found.motions.iter().map(Vec::len).collect::<Vec<_>>(),
        [5, 3]
    );
    assert_eq!(found.mse.iter().map(Vec::len).collect::<Vec<_>>(), [5, 3]);
    assert!(found.e_rms < 0.5, "{}", found.e_rms);
    assert!(found.mse.iter().flatten().all(|m| *m < 1e-6));
    let (hierarchy, level) = opened(&clips[0], 3);
    let model = found.model(&hierarchy, &level, &clips, 24.0).unwrap();
    let names: Vec<&str> = model.clips.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["two", "two_2"]);
    assert!(found.model(&hierarchy, &level, &clips[..1], 24.0).is_err());
    assert!(found.model(&hierarchy, &level, &clips, 0.0).is_err());
}

#[test]
fn the_character_plays_what_was_decomposed() {
    let clips = [bending(6), two_rows(4)];
    for (clip, spheres) in clips.iter().zip([7, 4]) {
        let clips = std::slice::from_ref(clip);
        let found = decomposed(clips, spheres, &Decomposing::default());
        let (hierarchy, level) = opened(&clips[0], spheres);
        let model = found.model(&hierarchy, &level, clips, 30.0).unwrap();
        assert_eq!(model.joints.len(), spheres);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.glb");
        asset::write_glb_skinned(&path, &model).unwrap();
        let back = asset::load(&path).unwrap();
        assert_eq!(back.warnings, Vec::<String>::new());
        let room = Room {
            bytes: u64::MAX,
            need: |_| 1,
        };
        let played = crate::rig::sequence(&back, 0, 30.0, room).unwrap();
        assert_eq!(played.frames.len(), clips[0].frames.len());
        let pairs = played
            .frames
            .iter()
            .flatten()
            .zip(clips[0].frames.iter().flatten());
        let squares = pairs.map(|(a, b)| f64::from(a.distance_squared(*b)));
        // All rows of these clips are welded vertices.
        let count = (3 * clips[0].frames.len() * hierarchy.vertices) as f64;
        let e_rms = 2000.0 * (squares.sum::<f64>() / count).sqrt() / hierarchy.diagonal;
        assert!(
            (e_rms - found.e_rms).abs() < 2e-3,
            "{e_rms} {}",
            found.e_rms
        );
    }
}

/// Two tubes beside each other, one of which moves away.
fn two_rows(frames: usize) -> Sequence {
    let (points, triangles) = tube(12, 8, 0.0);
    let n = points.len() as u32;
    let second = triangles.iter().map(|t| t.map(|v| v + n));
    let frame = |f: usize| {
        let away = points.iter().map(|p| *p + Vec3::Y * (0.5 + 0.1 * f as f32));
        points.iter().copied().chain(away).collect()
    };
    Sequence {
        path: "rows".into(),
        triangles: triangles.iter().copied().chain(second).collect(),
        frames: (0..frames).map(frame).collect(),
    }
}

#[test]
fn parts_that_nothing_joins_follow_their_own_spheres() {
    let found = decomposed(&[two_rows(5)], 2, &Decomposing::default());
    assert!(found.e_rms < 1e-2, "{}", found.e_rms);
}

#[test]
fn little_is_decomposed_as_well() {
    let corner = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let one = Sequence {
        triangles: vec![[0, 1, 2]],
        frames: vec![
            corner.clone(),
            corner.iter().map(|p| *p + Vec3::Z).collect(),
        ],
        ..Sequence::default()
    };
    for spheres in [1, 2, 3] {
        let found = decomposed(std::slice::from_ref(&one), spheres, &Decomposing::default());
        assert!(found.e_rms < 1e-2, "{spheres}: {}", found.e_rms);
    }
    let still = bending(1);
    let count = still.frames[0].len();
    for spheres in [1, 12, count] {
        let found = decomposed(
            std::slice::from_ref(&still),
            spheres,
            &Decomposing::default(),
        );
        assert!(found.e_rms < 1e-2, "{spheres}: {}", found.e_rms);
        assert!(found.rest.iter().all(|p| p.is_finite()));
    }
    let mut point = still.clone();
    point.frames[0].fill(Vec3::ONE);
    let (hierarchy, level) = opened(&still, 3);
    let options = Decomposing::default();
    let clips = [point];
    let found = decompose(&hierarchy, &level, &clips, &options, &|_| {}).unwrap();
    assert!(found.e_rms < 1e-2, "{}", found.e_rms);
    for fps in [0.0, 1e-44, 1e30, f32::NAN] {
        assert!(found.model(&hierarchy, &level, &clips, fps).is_err());
    }
}

#[test]
fn the_result_does_not_depend_on_the_threads() {
    let sequence = bending(6);
    let run = || decomposed(std::slice::from_ref(&sequence), 7, &Decomposing::default());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
    let alone = pool.build().unwrap().install(run);
    let all = run();
    assert_eq!(alone.influences, all.influences);
    assert_eq!(alone.rest, all.rest);
    assert_eq!(alone.e_rms, all.e_rms);
}

#[test]
fn clips_of_another_mesh_and_bad_options_are_refused() {
    type Change = fn(&mut Sequence);
    let good = bending(3);
    let (hierarchy, level) = opened(&good, 4);
    let refuse = |change: Change| {
        let mut clip = good.clone();
        clip.path = "clip.x".into();
        change(&mut clip);
        let clips = [good.clone(), clip];
        let found = decompose(&hierarchy, &level, &clips, &Decomposing::default(), &|_| {});
        let error = found.unwrap_err();
        assert!(matches!(error, Error::Asset { .. }), "{error}");
        error.to_string()
    };
    let changes: [(Change, &str); 6] = [
        (|c| c.frames.clear(), "no frames"),
        (|c| c.frames[1].truncate(9), "frame 1: 9 vertices"),
        (
            |c| c.frames[2][7].y = f32::NAN,
            "frame 2, vertex 7: not finite",
        ),
        (|c| c.triangles[5].swap(0, 1), "triangle 5"),
        (|c| c.triangles.truncate(5), "triangles: 5"),
        (|c| c.triangles[0][0] = u32::MAX, "triangle 0"),
    ];
    for (change, word) in changes {
        let error = refuse(change);
        assert!(
            error.contains("clip.x") && error.contains(word),
            "{word}: {error}"
        );
    }
    let clips = [good];
    for change in [
        |o: &mut Decomposing| o.influences = 0,
        |o: &mut Decomposing| o.influences = 25,
        |o: &mut Decomposing| o.tolerance = f64::NAN,
        |o: &mut Decomposing| o.tolerance = -1.0,
        |o: &mut Decomposing| o.joints = f64::INFINITY,
    ] {
        let mut options = Decomposing::default();
        change(&mut options);
        let error = decompose(&hierarchy, &level, &clips, &options, &|_| {}).unwrap_err();
        assert!(matches!(error, Error::Argument { .. }), "{error}");
    }
    let none = decompose(&hierarchy, &level, &[], &Decomposing::default(), &|_| {});
    assert!(none.is_err());
    let (_, others) = opened(&two_bones(2, 0.1), 4);
    let wrong = decompose(
        &hierarchy,
        &others,
        &clips,
        &Decomposing::default(),
        &|_| {},
    );
    let error = wrong.unwrap_err().to_string();
    assert!(error.starts_with("level: "), "{error}");
}
