//! Midpoint subdivision of a model: every triangle becomes four, the shape and the seams stay.

use std::collections::HashMap;

use super::rigid::welded_rigid;
use crate::{
    Error, Result,
    asset::{Influence, Model},
    mesh::weld,
};

/// Most rows or triangles after subdivision.
const LIMIT: usize = 1 << 28;

/// Cuts every triangle into four at its edges' midpoints, `n` times; normals, influences and rigidity are interpolated.
///
/// Rows that a seam duplicates are first given one position and one rigidity, so that they and their midpoints coincide bit for bit.
/// Rows stay grouped by primitive: a primitive's old rows, then its midpoints.
///
/// # Errors
/// [`Error::Argument`] where the result would pass 2²⁸ triangles.
pub fn subdivide(model: &Model, n: u32) -> Result<Model> {
    let mut fine = model.clone();
    let grown = 4usize
        .checked_pow(n)
        .and_then(|f| f.checked_mul(model.triangles.len()));
    if grown.is_none_or(|t| t > LIMIT) {
        let reason = format!("{n} times makes more than {LIMIT} triangles");
        return Err(Error::argument("subdivide", reason));
    }
    if n > 0 {
        let welded = weld(&model.positions, &model.triangles);
        for (row, &vertex) in welded.vertex.iter().enumerate() {
            fine.positions[row] = welded.mesh.positions[vertex as usize];
        }
        if !fine.rigid.is_empty() {
            let rigid = welded_rigid(&model.rigid, &welded);
            fine.rigid = welded.vertex.iter().map(|v| rigid[*v as usize]).collect();
        }
        fine.influences.resize(fine.positions.len(), Vec::new());
    }
    for _ in 0..n {
        fine = once(&fine);
    }
    Ok(fine)
}

fn once(coarse: &Model) -> Model {
    let mut fine = Model {
        positions: Vec::new(),
        normals: Vec::new(),
        triangles: Vec::new(),
        influences: Vec::new(),
        rigid: Vec::new(),
        ..coarse.clone()
    };
    // Where a coarse row has gone.
    let mut moved = vec![u32::MAX; coarse.positions.len()];
    for (k, primitive) in coarse.primitives.iter().enumerate() {
        let start = fine.positions.len();
        for row in primitive.vertices.clone() {
            moved[row] = fine.positions.len() as u32;
            fine.positions.push(coarse.positions[row]);
            fine.normals.push(coarse.normals[row]);
            fine.influences.push(coarse.influences[row].clone());
            fine.rigid.extend(coarse.rigid.get(row));
        }
        let mut midpoints = HashMap::new();
        let triangles = fine.triangles.len();
        for corners in &coarse.triangles[primitive.triangles.clone()] {
            let [a, b, c] = *corners;
            let mut middle = |x: u32, y: u32| {
                *midpoints
                    .entry([x.min(y), x.max(y)])
                    .or_insert_with(|| push_midpoint(&mut fine, coarse, x as usize, y as usize))
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            let [a, b, c] = corners.map(|row| moved[row as usize]);
            fine.triangles
                .extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        fine.primitives[k].vertices = start..fine.positions.len();
        fine.primitives[k].triangles = triangles..fine.triangles.len();
    }
    fine
}

fn push_midpoint(fine: &mut Model, coarse: &Model, a: usize, b: usize) -> u32 {
    let sum = coarse.normals[a] + coarse.normals[b];
    // Addition commutes exactly: both sides of a seam get the same bits whatever the order of their rows.
    fine.positions
        .push((coarse.positions[a] + coarse.positions[b]) * 0.5);
    fine.normals
        .push(sum.try_normalize().unwrap_or(coarse.normals[a]));
    fine.influences
        .push(mean(&coarse.influences[a], &coarse.influences[b]));
    if let (Some(x), Some(y)) = (coarse.rigid.get(a), coarse.rigid.get(b)) {
        fine.rigid.push((x + y) * 0.5);
    }
    fine.positions.len() as u32 - 1
}

/// Mean of two lists of influences, greatest first; empty where either end has none.
fn mean(a: &[Influence], b: &[Influence]) -> Vec<Influence> {
    if a.is_empty() || b.is_empty() {
        return Vec::new();
    }
    let mut all: Vec<Influence> = Vec::with_capacity(a.len() + b.len());
    for i in a.iter().chain(b) {
        match all.iter_mut().find(|x| x.joint == i.joint) {
            Some(x) => x.weight += 0.5 * i.weight,
            None => all.push(Influence {
                joint: i.joint,
                weight: 0.5 * i.weight,
            }),
        }
    }
    all.sort_by(|x, y| y.weight.total_cmp(&x.weight).then(x.joint.cmp(&y.joint)));
    all
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::asset::Primitive;
    use glam::Vec3;

    /// A tetrahedron, the last face with rows of its own and in a second primitive.
    fn seamed() -> Model {
        let p = [
            Vec3::ZERO,
            Vec3::X,
            Vec3::Y,
            Vec3::Z,
            Vec3::Z,
            Vec3::X,
            Vec3::Y,
        ];
        let primitive = |vertices, triangles| Primitive {
            name: "part".into(),
            vertices,
            triangles,
            base_color: [1.0; 4],
        };
        let one = |joint| vec![Influence { joint, weight: 1.0 }];
        Model {
            positions: p.to_vec(),
            normals: vec![Vec3::ONE.normalize(); 7],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [5, 6, 4]],
            primitives: vec![primitive(0..4, 0..3), primitive(4..7, 3..4)],
            influences: [0, 1, 1, 2, 2, 1, 1].map(one).to_vec(),
            ..Model::default()
        }
    }

    #[test]
    fn seams_stay_closed_and_volume_stays() {
        let coarse = seamed();
        let fine = subdivide(&coarse, 3).unwrap();
        assert_eq!(fine.triangles.len(), 4 * 64);
        assert_eq!(fine.primitives[1].triangles, 192..256);
        assert_eq!(fine.primitives[1].vertices.end, fine.positions.len());
        let welded = weld(&fine.positions, &fine.triangles);
        assert!(welded.mesh.boundary.iter().all(|b| !b), "a seam opened");
        for (row, &v) in welded.vertex.iter().enumerate() {
            assert_eq!(fine.positions[row], welded.mesh.positions[v as usize]);
        }
        let volume: f32 = fine
            .triangles
            .iter()
            .map(|t| t.map(|r| fine.positions[r as usize]))
            .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
            .sum();
        assert!((volume - 1.0 / 6.0).abs() < 1e-5);
    }

    #[test]
    fn influences_are_means_and_sum_to_one() {
        let fine = subdivide(&seamed(), 2).unwrap();
        for list in &fine.influences {
            assert!((list.iter().map(|i| i.weight).sum::<f32>() - 1.0).abs() < 1e-6);
            assert!(list.is_sorted_by(|a, b| a.weight >= b.weight));
        }
        assert!(fine.influences.iter().any(|l| l.len() == 3));
    }

    #[test]
    fn rigidity_is_interpolated_and_one_on_both_sides_of_a_seam() {
        let mut coarse = seamed();
        assert!(subdivide(&coarse, 1).unwrap().rigid.is_empty());
        // Rows 3 and 4 are one vertex, of which only the second primitive knows that it is rigid.
        coarse.rigid = vec![0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        let fine = subdivide(&coarse, 2).unwrap();
        assert_eq!(fine.rigid.len(), fine.positions.len());
        for (p, rigid) in fine.positions.iter().zip(&fine.rigid) {
            assert_eq!(p.z, *rigid);
        }
    }

    #[test]
    fn none_changes_nothing_and_too_many_are_refused() {
        let coarse = seamed();
        assert_eq!(subdivide(&coarse, 0).unwrap().triangles, coarse.triangles);
        assert!(subdivide(&coarse, 40).is_err());
    }
}
