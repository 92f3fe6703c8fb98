//! Even triangles on a shape, and proof that they close.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{grid::Quads, shape::Shape};
use crate::Result;

/// A closed triangle mesh.
pub(crate) struct Surface {
    /// Positions on the shape.
    pub(crate) positions: Vec<DVec3>,
    /// Outward unit normals.
    pub(crate) normals: Vec<DVec3>,
    /// Triangles, counter-clockwise seen from outside.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Rows joined by a quad's edge, a list a vertex, ascending.
    pub(crate) neighbours: Vec<Vec<u32>>,
}

/// Evens out quads on the shape's surface and splits them.
pub(crate) fn fair(shape: &Shape, quads: Quads, rounds: usize) -> Result<Surface> {
    let neighbours = neighbours(quads.positions.len(), &quads.faces);
    let mut positions: Vec<DVec3> = quads.positions.iter().map(|p| shape.project(*p)).collect();
    for _ in 0..rounds {
        positions = relaxed(shape, &positions, &neighbours);
    }
    let triangles: Vec<_> = quads
        .faces
        .iter()
        .flat_map(|face| split(&positions, face))
        .collect();
    let normals = normals(&positions, &triangles);
    let surface = Surface {
        positions,
        normals,
        triangles,
        neighbours,
    };
    check_closed(&surface.triangles, surface.positions.len())?;
    Ok(surface)
}

/// Neighbours along the edges of faces.
pub(crate) fn neighbours(vertices: usize, faces: &[[u32; 4]]) -> Vec<Vec<u32>> {
    let mut lists = vec![Vec::new(); vertices];
    for face in faces {
        for i in 0..4 {
            lists[face[i] as usize].push(face[(i + 1) % 4]);
            lists[face[(i + 1) % 4] as usize].push(face[i]);
        }
    }
    for list in &mut lists {
        list.sort_unstable();
        list.dedup();
    }
    lists
}

/// Each vertex half-way to the mean of its neighbours, along the surface.
fn relaxed(shape: &Shape, positions: &[DVec3], neighbours: &[Vec<u32>]) -> Vec<DVec3> {
    let moved = positions.iter().zip(neighbours).map(|(point, list)| {
        let sum: DVec3 = list.iter().map(|n| positions[*n as usize]).sum();
        let normal = shape.gradient(*point).normalize();
        let step = (sum / list.len() as f64 - *point) * 0.5;
        shape.project(*point + step - normal * step.dot(normal))
    });
    moved.collect()
}

/// Splits a quad along its shorter diagonal.
pub(crate) fn split(positions: &[DVec3], &[a, b, c, d]: &[u32; 4]) -> [[u32; 3]; 2] {
    let length = |i: u32, j: u32| positions[i as usize].distance_squared(positions[j as usize]);
    if length(a, c) <= length(b, d) {
        [[a, b, c], [a, c, d]]
    } else {
        [[a, b, d], [b, c, d]]
    }
}

/// Area-weighted unit normals.
pub(crate) fn normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|row| positions[row as usize]);
        triangle
            .iter()
            .for_each(|row| sums[*row as usize] += (b - a).cross(c - a));
    }
    sums.into_iter().map(DVec3::normalize).collect()
}

/// Every edge has two triangles of opposite direction, every vertex one fan, and the whole is one sphere.
pub(crate) fn check_closed(triangles: &[[u32; 3]], vertices: usize) -> Result<()> {
    let mut next = vec![BTreeMap::new(); vertices];
    for &[a, b, c] in triangles {
        for (at, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
            if next[at as usize].insert(from, to).is_some() {
                return Err(format!("edge {at}-{from} has more than two triangles"));
            }
        }
    }
    for (vertex, fan) in next.iter().enumerate() {
        let first = *fan
            .keys()
            .next()
            .ok_or(format!("vertex {vertex} has no triangle"))?;
        let (mut at, mut steps) = (first, 0);
        while steps == 0 || at != first {
            at = *fan
                .get(&at)
                .ok_or(format!("vertex {vertex} lies on an open edge"))?;
            steps += 1;
        }
        if steps != fan.len() {
            return Err(format!("vertex {vertex} joins two surfaces"));
        }
    }
    // Euler: V - E + F = 2, with 3 F = 2 E.
    if vertices * 2 != triangles.len() + 4 {
        return Err("the surface has a handle or several pieces".into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    #[test]
    fn a_tetrahedron_is_closed() {
        assert_eq!(check_closed(&TETRAHEDRON, 4), Ok(()));
    }

    #[test]
    fn what_is_not_a_closed_surface_is_rejected() {
        assert!(check_closed(&TETRAHEDRON[1..], 4).is_err(), "open");
        assert!(
            check_closed(&[[0, 1, 2], [0, 1, 3], [1, 2, 3], [2, 0, 3]], 4).is_err(),
            "flipped"
        );
        let shifted = |by: u32| TETRAHEDRON.map(|t| t.map(|v| if v == 0 { 0 } else { v + by }));
        let pinched = [shifted(0), shifted(3)].concat();
        assert!(
            check_closed(&pinched, 7).is_err(),
            "two surfaces that share a vertex"
        );
        let two = [TETRAHEDRON, TETRAHEDRON.map(|t| t.map(|v| v + 4))].concat();
        assert!(check_closed(&two, 8).is_err(), "two pieces");
    }
}
