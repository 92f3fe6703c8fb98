//! One level of a hierarchy: its spheres, whose vertices they stand for, and what joins them.

use std::collections::BTreeSet;

use super::hierarchy::Hierarchy;
use crate::mesh::Csr;

/// A sphere-mesh with a fixed number of spheres.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Nodes of the hierarchy, ascending; everything else names spheres by their rows here.
    pub nodes: Vec<u32>,
    /// Sphere of each welded vertex.
    pub labels: Vec<u32>,
    /// Edges that no triangle has, ends ascending.
    pub edges: Vec<[u32; 2]>,
    /// Triangles, corners ascending.
    pub triangles: Vec<[u32; 3]>,
    /// Spheres whose regions touch, ascending.
    pub near: Csr,
}

impl Level {
    pub(super) fn new(hierarchy: &Hierarchy, spheres: usize) -> Self {
        let vertices = hierarchy.vertices;
        let merges = &hierarchy.merges[..vertices - spheres];
        let mut up: Vec<u32> = (0..(vertices + merges.len()) as u32).collect();
        for (k, merge) in merges.iter().enumerate() {
            for child in merge.children {
                up[child as usize] = (vertices + k) as u32;
            }
        }
        // A node's parent comes later: from the last on, every parent knows its root.
        for node in (0..up.len()).rev() {
            up[node] = up[up[node] as usize];
        }
        let nodes: Vec<u32> = (0..up.len() as u32)
            .filter(|&n| up[n as usize] == n)
            .collect();
        let mut row = vec![0; up.len()];
        for (k, &node) in nodes.iter().enumerate() {
            row[node as usize] = k as u32;
        }
        let labels = up[..vertices].iter().map(|&root| row[root as usize]);
        let labels: Vec<u32> = labels.collect();
        Self::from_labels(hierarchy, nodes, labels)
    }

    /// The dual of a labelling (2016, section 4.3): a triangle of three labels joins three spheres, one of two labels two.
    fn from_labels(hierarchy: &Hierarchy, nodes: Vec<u32>, labels: Vec<u32>) -> Self {
        let (mut edges, mut triangles) = (BTreeSet::new(), BTreeSet::new());
        for t in &hierarchy.triangles {
            let mut t = t.map(|v| labels[v as usize]);
            t.sort_unstable();
            let [a, b, c] = t;
            edges.extend([[a, b], [b, c], [a, c]].into_iter().filter(|[a, b]| a != b));
            if a != b && b != c {
                triangles.insert(t);
            }
        }
        let mut near = vec![Vec::new(); nodes.len()];
        for &[a, b] in &edges {
            near[a as usize].push(b);
            near[b as usize].push(a);
        }
        near.iter_mut().for_each(|row| row.sort_unstable());
        for &[a, b, c] in &triangles {
            for edge in [[a, b], [b, c], [a, c]] {
                edges.remove(&edge);
            }
        }
        Self {
            nodes,
            labels,
            edges: edges.into_iter().collect(),
            triangles: triangles.into_iter().collect(),
            near: Csr::from_rows(&near),
        }
    }

    /// Whether every row names something of the hierarchy; a level of another one may not.
    pub(super) fn is_of(&self, hierarchy: &Hierarchy) -> bool {
        let nodes = hierarchy.vertices + hierarchy.merges.len();
        self.labels.len() == hierarchy.vertices
            && self.near.len() == self.nodes.len()
            && self.nodes.iter().all(|&n| (n as usize) < nodes)
            && self.labels.iter().all(|&l| (l as usize) < self.nodes.len())
    }

    /// The level with every vertex given to the nearest of its sphere and that sphere's neighbours, by the square of its
    /// distance to their surfaces over all frames, and joined anew (2016, section 4.3).
    ///
    /// The printed sum of |v - q| - r has a sign: a great sphere would win every vertex that it holds.
    #[must_use]
    pub fn optimised(&self, hierarchy: &Hierarchy) -> Self {
        use rayon::prelude::*;
        let labels = self.labels.par_iter().enumerate().map(|(vertex, &own)| {
            let others = self.near.row(own as usize).iter().copied();
            let all = std::iter::once(own).chain(others);
            let costs = all.map(|s| (self.distance(hierarchy, vertex, s), s));
            costs
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .map_or(own, |(_, s)| s)
        });
        let labels = labels.collect();
        Self::from_labels(hierarchy, self.nodes.clone(), labels)
    }

    /// Sum over the frames of the squared distance of a vertex to a sphere's surface, in units of the diagonal.
    fn distance(&self, hierarchy: &Hierarchy, vertex: usize, sphere: u32) -> f64 {
        let stride = hierarchy.frames;
        let node = self.nodes[sphere as usize] as usize;
        let radius = node.checked_sub(hierarchy.vertices);
        let radius = radius.map_or(0.0, |k| hierarchy.merges[k].radius);
        let (a, b) = (hierarchy.row(vertex), hierarchy.row(node));
        let at = |f: usize| {
            let square = |k: usize| (a[k * stride + f] - b[k * stride + f]).powi(2);
            let e = (square(0) + square(1) + square(2)).sqrt() - radius;
            f64::from(e * e)
        };
        (0..hierarchy.frames).map(at).sum()
    }
}
