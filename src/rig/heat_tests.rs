#![allow(clippy::unwrap_used)]
use super::*;
use crate::{mesh::weld, rig::skeleton::tests::skeleton};
use glam::Vec3;

/// A tube of radius 0.3 around x from -1.5 to 2.7, closed at both ends.
fn tube() -> Mesh {
    let (n, m) = (16u32, 60u32);
    let mut p = Vec::new();
    for j in 0..=m {
        for i in 0..n {
            let a = i as f32 / n as f32 * std::f32::consts::TAU;
            let x = -1.5 + 4.2 * j as f32 / m as f32;
            p.push(Vec3::new(x, 0.3 * a.cos(), 0.3 * a.sin()));
        }
    }
    let mut t = Vec::new();
    for j in 0..m {
        for i in 0..n {
            let (a, b) = (j * n + i, j * n + (i + 1) % n);
            t.push([a, b, a + n]);
            t.push([b, b + n, a + n]);
        }
    }
    for k in 1..n - 1 {
        t.push([0, k + 1, k]);
        t.push([m * n, m * n + k, m * n + k + 1]);
    }
    weld(&p, &t).mesh
}

#[test]
fn weights_of_a_tube_follow_its_bones() {
    let mesh = tube();
    let lists = heat_weights(&mesh, &skeleton(), &vec![true; mesh.positions.len()]);
    for (p, list) in mesh.positions.iter().zip(&lists) {
        let sum: f32 = list.iter().map(|i| i.weight).sum();
        assert!((sum - 1.0).abs() < 1e-5);
        assert!(list.iter().all(|i| i.weight > 0.0));
        // Bones: root 0..1 and 0..-1, elbow 1..2, hand beyond 2, tail beyond -1.
        let wanted = match p.x {
            x if x > 2.15 => 2,
            x if x > 1.15 && x < 1.85 => 1,
            x if x > -0.85 && x < 0.85 => 0,
            x if x < -1.15 => 3,
            _ => continue,
        };
        assert_eq!(list[0].joint, wanted, "{p}");
        assert!(list[0].weight > 0.5);
    }
    let middle = lists.iter().filter(|l| l.len() > 1 && l[0].weight < 0.9);
    assert!(middle.count() > 50, "joints must blend");
}

#[test]
fn a_component_that_sees_no_bone_takes_the_nearest() {
    let far = [
        Vec3::new(2.0, 5.0, 0.0),
        Vec3::new(2.1, 5.0, 0.0),
        Vec3::new(2.0, 5.1, 0.0),
    ];
    // Seen from its front, the triangle's normal points at the bones.
    let mesh = Mesh::new(far.to_vec(), vec![[0, 1, 2]]);
    let skeleton = skeleton();
    let lists = heat_weights(&mesh, &skeleton, &[true; 3]);
    for list in lists {
        assert!((list.iter().map(|i| i.weight).sum::<f32>() - 1.0).abs() < 1e-5);
        assert!([1, 2].contains(&list[0].joint));
    }
}

#[test]
fn components_that_have_weights_are_left_alone() {
    let tube = tube();
    let n = tube.positions.len() as u32;
    let mut positions = tube.positions.clone();
    positions.extend([Vec3::Y * 3.0, Vec3::Y * 4.0, Vec3::Y * 4.0 + Vec3::X]);
    let mut triangles = tube.triangles.clone();
    triangles.push([n, n + 1, n + 2]);
    let mesh = Mesh::new(positions, triangles);
    let wanted: Vec<bool> = (0..n + 3).map(|v| v >= n).collect();
    let lists = heat_weights(&mesh, &skeleton(), &wanted);
    assert!(lists[..n as usize].iter().all(Vec::is_empty));
    assert!(lists[n as usize..].iter().all(|l| !l.is_empty()));
}

#[test]
fn a_vertex_without_triangle_takes_its_nearest_joint() {
    let p = [
        Vec3::Z,
        Vec3::Z + Vec3::X,
        Vec3::Z + Vec3::Y,
        Vec3::new(1.5, 0.2, 0.0),
    ];
    let mesh = Mesh::new(p.to_vec(), vec![[0, 1, 2]]);
    let lists = heat_weights(&mesh, &skeleton(), &[true; 4]);
    let joints: Vec<u16> = lists[3].iter().map(|i| i.joint).collect();
    assert_eq!(joints, [1]);
    assert_eq!(lists[3][0].weight, 1.0);
}
