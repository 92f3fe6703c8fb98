//! Where the iterations begin: which bones a vertex may follow, and smooth geometric weights.

use rayon::prelude::*;

use super::skin::Skin;
use crate::{
    mesh::{HeatMatrix, Laplacian, Mesh},
    sphere_mesh::level::Level,
};
use glam::DVec3;

/// Weights of every vertex for its own sphere and those whose regions touch that one's, greatest first, sum 1: heat that
/// flows from each sphere into its region, 1/d² of the distance to its centre (Baran & Popović 2007).
pub(super) fn heat(mesh: &Mesh, level: &Level, centres: &[DVec3]) -> Vec<Vec<(u32, f64)>> {
    let laplacian = Laplacian::new(mesh);
    let mut regions = vec![Vec::new(); centres.len()];
    for (v, &sphere) in level.labels.iter().enumerate() {
        regions[sphere as usize].push(v as u32);
    }
    let source = |v: u32| {
        let sphere = level.labels[v as usize] as usize;
        let at = mesh.positions[v as usize].as_dvec3();
        laplacian.heat(v, at.distance(centres[sphere]))
    };
    let heat: Vec<f64> = (0..level.labels.len() as u32).map(source).collect();
    let column = |sphere: usize| {
        let near = level.near.row(sphere).iter().map(|&s| s as usize);
        let mut vertices: Vec<u32> = near
            .chain([sphere])
            .flat_map(|s| regions[s].iter().copied())
            .collect();
        vertices.sort_unstable();
        let here: Vec<f64> = vertices.iter().map(|&v| heat[v as usize]).collect();
        let own = |(&v, h): (&u32, &f64)| {
            let own = level.labels[v as usize] as usize == sphere;
            if own { *h } else { 0.0 }
        };
        let right: Vec<f64> = vertices.iter().zip(&here).map(own).collect();
        let solved = HeatMatrix::new(&laplacian, &vertices, &here).solve(&right);
        (vertices, solved)
    };
    let columns: Vec<(Vec<u32>, Vec<f64>)> =
        (0..centres.len()).into_par_iter().map(column).collect();
    let mut lists = vec![Vec::new(); level.labels.len()];
    for (sphere, (vertices, solved)) in columns.iter().enumerate() {
        for (&v, &w) in vertices.iter().zip(solved) {
            // `max` turns what is not a number into 0.
            lists[v as usize].push((sphere as u32, w.max(0.0)));
        }
    }
    for (list, &own) in lists.iter_mut().zip(&level.labels) {
        list.sort_by(|a: &(u32, f64), b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        if list[0].1 <= 0.0 {
            *list = vec![(own, 1.0)];
        }
    }
    lists
}

/// The first `width` of each list, sum 1.
pub(super) fn keep(lists: &[Vec<(u32, f64)>], width: usize) -> Skin {
    let kept = lists.iter().map(|list| {
        let list = &list[..list.len().min(width)];
        let sum: f64 = list.iter().map(|p| p.1).sum();
        list.iter().map(|p| (p.0, p.1 / sum)).collect()
    });
    Skin::new(width, &kept.collect::<Vec<_>>())
}
