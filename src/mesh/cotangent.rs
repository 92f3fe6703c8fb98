//! Cotangent weights and lumped areas of the Laplacian (Pinkall & Polthier 1993).

use glam::DVec3;
use rayon::prelude::*;

use super::Mesh;

/// Bound of one cotangent: slivers must not drown their neighbours.
const LIMIT: f64 = 1e4;

/// (cot α + cot β) / 2 of each edge, aligned with `mesh.one_ring.items`, clamped to at least 0; symmetric bit for bit.
pub fn cotangent(mesh: &Mesh) -> Vec<f32> {
    let rows: Vec<Vec<f32>> = (0..mesh.positions.len())
        .into_par_iter()
        .map(|v| row(mesh, v))
        .collect();
    rows.concat()
}

fn row(mesh: &Mesh, v: usize) -> Vec<f32> {
    let ring = mesh.one_ring.row(v);
    let point = |u: u32| mesh.positions[u as usize].as_dvec3();
    let here = point(v as u32);
    let mut sums = vec![0.0f64; ring.len()];
    for corner in mesh.corners.row(v).chunks_exact(2) {
        let (a, b) = (point(corner[0]), point(corner[1]));
        // The angle opposite an edge faces it across the triangle.
        for (to, angle) in [
            (corner[0], cot(here - b, a - b)),
            (corner[1], cot(here - a, b - a)),
        ] {
            if let Some(k) = ring.iter().position(|&u| u == to) {
                sums[k] += 0.5 * angle;
            }
        }
    }
    sums.iter().map(|w| w.max(0.0) as f32).collect()
}

fn cot(a: DVec3, b: DVec3) -> f64 {
    let cot = a.dot(b) / a.cross(b).length();
    if cot.is_nan() {
        0.0
    } else {
        cot.clamp(-LIMIT, LIMIT)
    }
}

/// A third of the area of the triangles around each vertex.
pub fn lumped_areas(mesh: &Mesh) -> Vec<f64> {
    let mut areas = vec![0.0; mesh.positions.len()];
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3());
        let area = (b - a).cross(c - a).length() / 6.0;
        for v in t {
            areas[*v as usize] += area;
        }
    }
    areas
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_square_has_weight_zero_on_its_diagonal_and_half_on_its_sides() {
        let p = vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let mesh = Mesh::new(p, vec![[0, 1, 2], [0, 2, 3]]);
        let weights = cotangent(&mesh);
        let weight = |v: usize, u: u32| {
            let at = mesh.one_ring.row(v).iter().position(|&x| x == u);
            at.map(|k| weights[mesh.one_ring.offsets[v] as usize + k])
        };
        assert!(weight(0, 2).is_some_and(|w| w.abs() < 1e-7));
        assert!(weight(0, 1).is_some_and(|w| (w - 0.5).abs() < 1e-7));
        assert_eq!(weight(1, 3), None);
        assert!((lumped_areas(&mesh).iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn obtuse_angles_are_clamped_and_the_matrix_is_symmetric() {
        let p = vec![
            Vec3::ZERO,
            Vec3::X,
            Vec3::new(0.5, 0.1, 0.0),
            Vec3::new(0.4, -0.05, 0.1),
        ];
        let mesh = Mesh::new(p, vec![[0, 1, 2], [1, 0, 3]]);
        let weights = cotangent(&mesh);
        assert!(weights.iter().all(|w| *w >= 0.0) && weights.contains(&0.0));
        for v in 0..4u32 {
            for (k, &u) in mesh.one_ring.row(v as usize).iter().enumerate() {
                let back = mesh.one_ring.row(u as usize).iter().position(|&x| x == v);
                let there = mesh.one_ring.offsets[u as usize] as usize;
                let here = mesh.one_ring.offsets[v as usize] as usize;
                assert_eq!(
                    back.map(|b| weights[there + b].to_bits()),
                    Some(weights[here + k].to_bits())
                );
            }
        }
    }
}
