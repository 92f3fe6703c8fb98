//! Mesh, skeleton, clips and weights of real characters.
#![allow(clippy::unwrap_used)]

use std::{collections::HashSet, path::PathBuf};

use super::{Pose, Skeleton, Weights, heat::heat_weights};
use crate::{
    asset::{self, Model},
    mesh::{Mesh, Welded, cotangent, mean_value, rings, weld},
};

/// A character of the data folder; `None`, and a line that says so, where the folder does not exist.
pub(super) fn character(name: &str) -> Option<Model> {
    let default = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let data = std::env::var_os("DERMIS_DATA").map_or(default, PathBuf::from);
    if !data.is_dir() {
        eprintln!("skipped: no data folder {}", data.display());
        return None;
    }
    Some(asset::load(&data.join("characters").join(name)).unwrap())
}

fn welded(model: &Model) -> Welded {
    weld(&model.positions, &model.triangles)
}

fn euler(mesh: &Mesh) -> i64 {
    let edges: HashSet<[u32; 2]> = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    mesh.positions.len() as i64 - edges.len() as i64 + mesh.triangles.len() as i64
}

#[test]
fn welded_counts_are_those_of_the_data_notice() {
    for (name, vertices) in [
        ("khronos/CesiumMan.glb", 2338),
        ("khronos/Fox.glb", 290),
        ("khronos/RiggedFigure.glb", 130),
        ("mesh2motion/horse-animations.glb", 1709),
        ("mesh2motion/human-male.glb", 7011),
        ("mesh2motion/human-sintel.glb", 20975),
    ] {
        let Some(model) = character(name) else { return };
        let mesh = welded(&model).mesh;
        assert_eq!(mesh.positions.len(), vertices, "{name}");
        let boundary = mesh.boundary.iter().filter(|b| **b).count();
        println!(
            "{name}: {vertices} vertices, {} triangles, euler {}, {} components, {boundary} boundary vertices",
            mesh.triangles.len(),
            euler(&mesh),
            mesh.component_count(),
        );
        if boundary == 0 {
            assert_eq!(euler(&mesh) % 2, 0, "{name}: a closed orientable surface");
        }
    }
}

#[test]
fn mean_values_reproduce_the_vertices_of_characters() {
    for name in ["khronos/CesiumMan.glb", "mesh2motion/human-male.glb"] {
        let Some(model) = character(name) else { return };
        let mesh = welded(&model).mesh;
        let phi = mean_value(&mesh);
        let mut relaxed = 0;
        for (v, &p) in mesh.positions.iter().enumerate() {
            let range = mesh.one_ring.offsets[v] as usize..mesh.one_ring.offsets[v + 1] as usize;
            let row = &phi[range];
            if row.iter().all(|w| *w == 0.0) {
                continue;
            }
            relaxed += 1;
            assert!(row.iter().all(|w| *w >= 0.0));
            assert!((row.iter().sum::<f32>() - 1.0).abs() < 1e-5);
            let ring = mesh
                .one_ring
                .row(v)
                .iter()
                .map(|u| mesh.positions[*u as usize]);
            let size = ring.clone().map(|q| q.distance(p)).fold(0.0, f32::max);
            let sum: glam::Vec3 = ring.zip(row).map(|(q, w)| *w * (q - p)).sum();
            let slip = sum.reject_from_normalized(mesh.normals[v]).length();
            assert!(slip <= 2e-4 * size, "{name} {v}: {slip} of {size}");
        }
        let share = relaxed as f64 / mesh.positions.len() as f64;
        println!("{name}: {share:.3} of the vertices can be relaxed");
        assert!(share > 0.8, "{name}: {share}");
        assert!(cotangent(&mesh).iter().all(|w| w.is_finite() && *w >= 0.0));
        let three = rings(&mesh, 3);
        let far = (0..three.len()).filter(|&v| three.row(v).len() <= mesh.one_ring.row(v).len());
        assert_eq!(far.count(), 0);
    }
}

#[test]
fn clips_move_joints_smoothly_and_hold_at_their_ends() {
    for name in [
        "khronos/CesiumMan.glb",
        "khronos/Fox.glb",
        "mesh2motion/horse-animations.glb",
    ] {
        let Some(model) = character(name) else { return };
        let skeleton = Skeleton::from_model(&model).unwrap();
        let mut moved = 0.0f32;
        for (row, clip) in model.clips.iter().enumerate() {
            let pose = |t: f32| Pose::from_clip(&model, &skeleton, row, t).unwrap();
            assert_eq!(pose(clip.seconds), pose(clip.seconds + 1.0));
            for k in 0..20 {
                let t = clip.seconds * k as f32 / 20.0;
                for (j, (a, b)) in pose(t)
                    .matrices
                    .iter()
                    .zip(pose(t + 1e-4).matrices)
                    .enumerate()
                {
                    let at = skeleton.origin(j);
                    let step = a.transform_point3(at).distance(b.transform_point3(at));
                    let size = a.x_axis.truncate().length();
                    assert!(step <= 0.01 * size * scale(&model), "{name} {}", clip.name);
                    moved = moved.max(step);
                }
            }
        }
        assert!(moved > 0.0, "{name} stands still");
    }
}

fn scale(model: &Model) -> f32 {
    welded(model).mesh.diagonal()
}

#[test]
fn heat_weights_agree_with_the_artists() {
    for (name, least) in [
        ("khronos/CesiumMan.glb", 0.6),
        ("mesh2motion/horse-animations.glb", 0.6),
        ("mesh2motion/human-male.glb", 0.6),
        ("mesh2motion/human-sintel.glb", 0.6),
    ] {
        let Some(model) = character(name) else { return };
        let skeleton = Skeleton::from_model(&model).unwrap();
        let welded = welded(&model);
        let first = welded.first_rows();
        let started = std::time::Instant::now();
        let n = welded.mesh.positions.len();
        let heat = Weights::from_lists(&heat_weights(&welded.mesh, &skeleton, &vec![true; n]));
        let seconds = started.elapsed().as_secs_f32();
        let (mut same, mut near) = (0, 0);
        for (v, row) in heat.weights.chunks(heat.width).enumerate() {
            assert!(row.iter().all(|w| *w >= 0.0));
            assert!((row.iter().sum::<f32>() - 1.0).abs() < 1e-5, "{name} {v}");
            let artist = usize::from(model.influences[first[v] as usize][0].joint);
            let ours = usize::from(heat.dominant(v));
            let parent = |j: usize| skeleton.joints[j].parent;
            same += usize::from(artist == ours);
            near += usize::from(
                artist == ours || parent(artist) == Some(ours) || parent(ours) == Some(artist),
            );
        }
        let (same, near) = (same as f64 / n as f64, near as f64 / n as f64);
        println!(
            "{name}: same dominant joint {same:.3}, or its neighbour {near:.3}, {seconds:.2} s"
        );
        assert!(same > least, "{name}: {same}");
    }
}
