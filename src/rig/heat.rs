//! Weights by heat diffusion (Baran & Popović 2007, section 4).

use rayon::prelude::*;

use super::{
    Skeleton,
    bones::{Nearest, bones, nearest, nearest_visible},
};
use crate::{
    asset::Influence,
    mesh::{HeatMatrix, Laplacian, Mesh, TriangleGrid},
};

/// Influences kept a vertex.
const KEPT: usize = 4;

/// Influences of every vertex in components that hold a `wanted` vertex, greatest first, four at most, sum 1; empty
/// lists elsewhere.
///
/// Solves (-Δ + H) w = H p for each joint, H = 1/d² to the nearest visible bone, p the share of the joint in it. In a
/// component that sees no bone the nearest one stands in.
pub(super) fn heat_weights(
    mesh: &Mesh,
    skeleton: &Skeleton,
    wanted: &[bool],
) -> Vec<Vec<Influence>> {
    let mut components: Vec<Vec<u32>> = vec![Vec::new(); mesh.component_count()];
    let mut chosen = vec![false; components.len()];
    for (v, &c) in mesh.components.iter().enumerate() {
        components[c as usize].push(v as u32);
        chosen[c as usize] |= wanted[v];
    }
    let grid = TriangleGrid::new(mesh);
    let bones = bones(skeleton, &grid);
    let laplacian = Laplacian::new(mesh);
    let mut lists = vec![Vec::new(); mesh.positions.len()];
    for vertices in components.iter().zip(&chosen).filter(|c| *c.1).map(|c| c.0) {
        let mut sources: Vec<Option<Nearest>> = vertices
            .par_iter()
            .map(|&v| nearest_visible(mesh, &grid, &bones, v as usize))
            .collect();
        if sources.iter().all(Option::is_none) {
            let any = |&v: &u32| Some(nearest(mesh, &bones, v as usize));
            sources = vertices.par_iter().map(any).collect();
        }
        for (v, list) in vertices.iter().zip(diffuse(&laplacian, vertices, &sources)) {
            lists[*v as usize] = list;
        }
    }
    lists
}

/// Solves a component for all its joints; `vertices` ascend.
fn diffuse(
    laplacian: &Laplacian,
    vertices: &[u32],
    sources: &[Option<Nearest>],
) -> Vec<Vec<Influence>> {
    let heat: Vec<f64> = vertices
        .iter()
        .zip(sources)
        .map(|(&v, source)| {
            let source = source.as_ref();
            source.map_or(0.0, |s| laplacian.heat(v, s.distance))
        })
        .collect();
    let matrix = HeatMatrix::new(laplacian, vertices, &heat);
    let mut joints: Vec<u16> = sources
        .iter()
        .flatten()
        .flat_map(|s| &s.joints)
        .copied()
        .collect();
    joints.sort_unstable();
    joints.dedup();
    let columns: Vec<Vec<f64>> = joints
        .par_iter()
        .map(|joint| {
            let share =
                |s: &Nearest| f64::from(u8::from(s.joints.contains(joint))) / s.joints.len() as f64;
            let right: Vec<f64> = heat
                .iter()
                .zip(sources)
                .map(|(h, source)| h * source.as_ref().map_or(0.0, share))
                .collect();
            matrix.solve(&right)
        })
        .collect();
    (0..vertices.len())
        .map(|i| keep_greatest(joints.iter().zip(&columns).map(|(j, c)| (*j, c[i]))))
        .collect()
}

fn keep_greatest(weights: impl Iterator<Item = (u16, f64)>) -> Vec<Influence> {
    let mut all: Vec<(u16, f64)> = weights.filter(|w| w.1 > 1e-6).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    all.truncate(KEPT);
    let sum: f64 = all.iter().map(|w| w.1).sum();
    all.iter()
        .map(|&(joint, w)| Influence {
            joint,
            weight: (w / sum) as f32,
        })
        .collect()
}

#[cfg(test)]
#[path = "heat_tests.rs"]
mod tests;
