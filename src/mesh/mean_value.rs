//! Mean value coordinates of every vertex in its one-ring (Hormann & Floater 2006; implicit skinning 2013, Eq. 5).

use glam::DVec3;
use rayon::prelude::*;

use super::{Mesh, topology::fan};

/// Reconstruction error above this share of the ring's size voids a row.
const RESIDUAL: f64 = 1e-4;

/// Weights Φ aligned with `mesh.one_ring.items`: the vertex is Σ Φ q, the q being its neighbours projected on its tangent
/// plane; a row sums to 1.
///
/// Rows are all zero where the vertex may not be relaxed: on a boundary, without a closed fan, with a negative or
/// non-finite weight, or where the weights do not reproduce the vertex.
pub fn mean_value(mesh: &Mesh) -> Vec<f32> {
    let rows: Vec<Vec<f32>> = (0..mesh.positions.len())
        .into_par_iter()
        .map(|v| row(mesh, v).unwrap_or_else(|| vec![0.0; mesh.one_ring.row(v).len()]))
        .collect();
    rows.concat()
}

fn row(mesh: &Mesh, v: usize) -> Option<Vec<f32>> {
    let (ring, closed) = fan(mesh.corners.row(v))?;
    if !closed || mesh.boundary[v] {
        return None;
    }
    let normal = mesh.normals[v].as_dvec3();
    let centre = mesh.positions[v].as_dvec3();
    let spokes: Vec<DVec3> = ring
        .iter()
        .map(|&u| (mesh.positions[u as usize].as_dvec3() - centre).reject_from_normalized(normal))
        .collect();
    let n = spokes.len();
    // tan(angle / 2) = sin / (1 + cos) between spoke k and the next.
    let half: Vec<f64> = (0..n)
        .map(|k| {
            let (a, b) = (spokes[k], spokes[(k + 1) % n]);
            a.cross(b).dot(normal) / (a.length() * b.length() + a.dot(b))
        })
        .collect();
    let weights: Vec<f64> = (0..n)
        .map(|k| (half[(k + n - 1) % n] + half[k]) / spokes[k].length())
        .collect();
    let sum: f64 = weights.iter().sum();
    let row: Vec<f32> = weights.iter().map(|w| (w / sum) as f32).collect();
    let good = sum.is_finite() && weights.iter().all(|w| w.is_finite() && *w >= 0.0);
    let error: DVec3 = row
        .iter()
        .zip(&spokes)
        .map(|(w, s)| s * f64::from(*w))
        .sum();
    let size = spokes.iter().map(|s| s.length()).fold(0.0, f64::max);
    (good && error.length() <= RESIDUAL * size).then_some(row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn fan_mesh(centre: Vec3, rim: &[Vec3]) -> Mesh {
        let n = rim.len() as u32;
        let mut p = vec![centre];
        p.extend(rim);
        // A second apex below closes the mesh, so that no vertex is boundary.
        p.push(Vec3::new(0.0, 0.0, -1.0));
        let top = (0..n).map(|k| [0, 1 + k, 1 + (k + 1) % n]);
        let bottom = (0..n).map(|k| [n + 1, 1 + (k + 1) % n, 1 + k]);
        Mesh::new(p, top.chain(bottom).collect())
    }

    fn rim(n: usize) -> Vec<Vec3> {
        (0..n)
            .map(|k| {
                let angle = k as f32 / n as f32 * std::f32::consts::TAU;
                Vec3::new(angle.cos(), angle.sin(), 0.0)
            })
            .collect()
    }

    #[test]
    fn regular_ring_gives_equal_weights() {
        let mesh = fan_mesh(Vec3::new(0.0, 0.0, 0.3), &rim(6));
        let weights = mean_value(&mesh);
        for w in &weights[..6] {
            assert!((w - 1.0 / 6.0).abs() < 1e-6);
        }
    }

    #[test]
    fn an_eccentric_vertex_is_reproduced() {
        let centre = Vec3::new(0.4, -0.2, 0.0);
        let mesh = fan_mesh(centre, &rim(7));
        let weights = mean_value(&mesh);
        let n = mesh.normals[0];
        let mut sum = Vec3::ZERO;
        for (w, &u) in weights.iter().zip(mesh.one_ring.row(0)) {
            assert!(*w > 0.0);
            sum += *w * (mesh.positions[u as usize] - centre).reject_from_normalized(n);
        }
        assert!(sum.length() < 1e-5);
        assert!((weights[..7].iter().sum::<f32>() - 1.0).abs() < 1e-6);
        assert!(
            (weights[0] - weights[3]).abs() > 1e-2,
            "weights must differ"
        );
    }

    #[test]
    fn a_vertex_outside_its_ring_and_the_boundary_are_not_relaxed() {
        // The centre lies outside the rim: some weight is negative.
        let mesh = fan_mesh(Vec3::new(2.0, 0.0, 0.0), &rim(6));
        assert!(mean_value(&mesh)[..6].iter().all(|w| *w == 0.0));
        let open = Mesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
        assert_eq!(mean_value(&open), [0.0; 6]);
    }
}
