//! One-rings, corners, components, boundary flags and normals of a mesh.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{Csr, Mesh};

impl Mesh {
    /// Derives the topology of welded positions and triangles; triangles must be in range with three distinct corners.
    pub fn new(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        let corners = corners(positions.len(), &triangles);
        let vertices = (0..positions.len()).into_par_iter();
        let around = vertices.map(|v| (ring(corners.row(v)), boundary(corners.row(v))));
        let (rings, boundary): (Vec<_>, Vec<bool>) = around.unzip();
        Self {
            normals: normals(&positions, &triangles),
            one_ring: Csr::from_rows(&rings),
            components: components(positions.len(), &triangles),
            boundary,
            corners,
            positions,
            triangles,
        }
    }

    /// Length of the bounding box's diagonal, 0 for an empty mesh.
    pub fn diagonal(&self) -> f32 {
        let mut points = self.positions.iter().copied();
        let Some(first) = points.next() else {
            return 0.0;
        };
        let (low, high) = points.fold((first, first), |(l, h), p| (l.min(p), h.max(p)));
        low.distance(high)
    }

    /// Number of connected components; a vertex without triangle is one of its own.
    pub fn component_count(&self) -> usize {
        self.components.iter().max().map_or(0, |&c| c as usize + 1)
    }
}

/// Area-weighted unit normals, zero where a vertex has no triangle of positive area.
pub fn normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|v| positions[v as usize].as_dvec3());
        let area = (b - a).cross(c - a);
        for v in t {
            sums[*v as usize] += area;
        }
    }
    sums.iter()
        .map(|n| n.try_normalize().unwrap_or_default().as_vec3())
        .collect()
}

fn corners(vertices: usize, triangles: &[[u32; 3]]) -> Csr {
    let mut offsets = vec![0u32; vertices + 1];
    for v in triangles.iter().flatten() {
        offsets[*v as usize + 1] += 2;
    }
    for i in 0..vertices {
        offsets[i + 1] += offsets[i];
    }
    let mut cursor = offsets.clone();
    let mut items = vec![0; offsets[vertices] as usize];
    for t in triangles {
        for k in 0..3 {
            let at = &mut cursor[t[k] as usize];
            items[*at as usize] = t[(k + 1) % 3];
            items[*at as usize + 1] = t[(k + 2) % 3];
            *at += 2;
        }
    }
    Csr { offsets, items }
}

/// Neighbours in winding order and whether the fan closes; `None` where the corners form no single fan.
pub(super) fn fan(corners: &[u32]) -> Option<(Vec<u32>, bool)> {
    let pairs: Vec<[u32; 2]> = corners.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
    let unique = |k: usize| {
        pairs
            .iter()
            .enumerate()
            .all(|(i, p)| pairs[..i].iter().all(|q| q[k] != p[k]))
    };
    let first = pairs.first()?;
    if !unique(0) || !unique(1) {
        return None;
    }
    let start = pairs
        .iter()
        .find(|p| pairs.iter().all(|q| q[1] != p[0]))
        .unwrap_or(first)[0];
    let mut ring = vec![start];
    let mut at = start;
    while let Some(p) = pairs.iter().find(|p| p[0] == at) {
        at = p[1];
        if at == start {
            return (ring.len() == pairs.len()).then_some((ring, true));
        }
        ring.push(at);
    }
    (ring.len() == pairs.len() + 1).then_some((ring, false))
}

fn ring(corners: &[u32]) -> Vec<u32> {
    fan(corners).map(|(ring, _)| ring).unwrap_or_else(|| {
        let mut ring = corners.to_vec();
        ring.sort_unstable();
        ring.dedup();
        ring
    })
}

/// Union of the triangles' corners, numbered by their first vertex.
fn components(vertices: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut up: Vec<u32> = (0..vertices as u32).collect();
    fn root(up: &mut [u32], mut v: u32) -> u32 {
        while up[v as usize] != v {
            up[v as usize] = up[up[v as usize] as usize];
            v = up[v as usize];
        }
        v
    }
    for &[a, b, c] in triangles {
        for other in [b, c] {
            let (x, y) = (root(&mut up, a), root(&mut up, other));
            up[x.max(y) as usize] = x.min(y);
        }
    }
    let mut number = vec![u32::MAX; vertices];
    let mut next = 0;
    (0..vertices as u32)
        .map(|v| {
            let slot = &mut number[root(&mut up, v) as usize];
            if *slot == u32::MAX {
                *slot = next;
                next += 1;
            }
            *slot
        })
        .collect()
}

/// Whether a vertex is on an edge that does not have exactly two triangles: each gives its corners the far end once.
fn boundary(corners: &[u32]) -> bool {
    let mut ends = corners.to_vec();
    ends.sort_unstable();
    ends.chunk_by(|a, b| a == b).any(|edge| edge.len() != 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Mesh {
        let p = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        Mesh::new(p, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    }

    #[test]
    fn closed_fan_is_cyclic_and_follows_the_winding() {
        let mesh = tetrahedron();
        for v in 0..4 {
            let ring = mesh.one_ring.row(v);
            assert_eq!(ring.len(), 3);
            for k in 0..3 {
                let pair = [ring[k], ring[(k + 1) % 3]];
                assert!(mesh.corners.row(v).chunks(2).any(|c| c == pair));
            }
        }
        assert_eq!(mesh.boundary, [false; 4]);
        assert_eq!(mesh.component_count(), 1);
    }

    #[test]
    fn normals_point_out_of_a_tetrahedron() {
        let mesh = tetrahedron();
        let centre = Vec3::splat(0.25);
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert!((p - centre).dot(*n) > 0.0 && (n.length() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn open_fan_starts_at_the_boundary() {
        // Corners of vertex 9, listed out of order.
        assert_eq!(fan(&[2, 3, 1, 2, 3, 4]), Some((vec![1, 2, 3, 4], false)));
        assert_eq!(
            fan(&[2, 3, 1, 2, 3, 4, 4, 1]),
            Some((vec![2, 3, 4, 1], true))
        );
    }

    #[test]
    fn bow_ties_and_flipped_neighbours_are_no_fan_but_ascend() {
        assert_eq!(fan(&[1, 2, 3, 4]), None);
        assert_eq!(fan(&[1, 2, 1, 4]), None);
        assert_eq!(fan(&[1, 2, 2, 1, 3, 4, 4, 3]), None);
        assert_eq!(ring(&[4, 1, 4, 2]), [1, 2, 4]);
        assert_eq!(fan(&[]), None);
    }

    #[test]
    fn an_edge_of_three_triangles_is_boundary() {
        let p = (0..5).map(|i| Vec3::new(i as f32, (i * i) as f32, 0.0));
        let mesh = Mesh::new(p.collect(), vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        assert!(mesh.boundary.iter().all(|&b| b));
    }
}
