//! Spheres as joints: which hangs on which, and where each turns against its parent.

use glam::{DMat3, DVec3};

use super::{
    Decomposition,
    border::{Border, borders},
};
use crate::sphere_mesh::{hierarchy::Hierarchy, level::Level};

/// What a longer way between two spheres costs against a joint that comes apart.
const LENGTH: f64 = 0.1;
/// How much a joint holds to the middle of its regions' border, against fixing the point that both of its bones move alike:
/// where they hardly turn against each other, nothing else says where it is.
const HOLD: f64 = 0.05;

/// Joints, parents before children.
pub(super) struct Tree {
    /// Sphere of each joint.
    pub(super) sphere: Vec<usize>,
    /// Row of its parent.
    pub(super) parent: Vec<Option<usize>>,
    /// Where it turns against its parent, at rest; the root's is its centre.
    pub(super) origin: Vec<DVec3>,
}

/// An edge that could be a joint: its cost, its spheres, and where it would turn.
struct Link {
    cost: f64,
    ends: [usize; 2],
    pivot: DVec3,
}

impl Tree {
    /// The spanning tree of the spheres' adjacency that comes apart least where its joints turn; pieces that nothing joins
    /// hang on the nearest sphere of another. The root is the sphere without which no half of the skin hangs together.
    pub(super) fn new(hierarchy: &Hierarchy, level: &Level, result: &Decomposition) -> Self {
        let count = level.nodes.len();
        let mut links = links(hierarchy, level, result);
        links.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.ends.cmp(&b.ends)));
        let mut group: Vec<usize> = (0..count).collect();
        let mut near: Vec<Vec<(usize, DVec3)>> = vec![Vec::new(); count];
        for link in &links {
            join(&mut group, &mut near, link.ends, link.pivot);
        }
        join_pieces(&mut group, &mut near, &result.centres);
        let mut size = vec![0.0; count];
        for list in &result.influences {
            list.iter()
                .for_each(|p| size[p.0 as usize] += f64::from(p.1));
        }
        let root = middle(&near, &size);
        let mut tree = Self {
            sphere: vec![root],
            parent: vec![None],
            origin: vec![result.centres[root]],
        };
        let mut seen = vec![false; count];
        seen[root] = true;
        let mut row = 0;
        while row < tree.sphere.len() {
            for &(s, pivot) in &near[tree.sphere[row]] {
                if !std::mem::replace(&mut seen[s], true) {
                    tree.sphere.push(s);
                    tree.parent.push(Some(row));
                    tree.origin.push(pivot);
                }
            }
            row += 1;
        }
        tree
    }
}

fn join(group: &mut [usize], near: &mut [Vec<(usize, DVec3)>], [a, b]: [usize; 2], pivot: DVec3) {
    let (from, to) = (group[b], group[a]);
    if from != to {
        group
            .iter_mut()
            .filter(|g| **g == from)
            .for_each(|g| *g = to);
        near[a].push((b, pivot));
        near[b].push((a, pivot));
    }
}

/// Joins all groups to that of the first sphere, the nearest sphere outside of it each time; the joint is in the middle.
///
/// Every sphere outside keeps the nearest inside (Prim 1957): meshes may have thousands of pieces.
fn join_pieces(group: &mut [usize], near: &mut [Vec<(usize, DVec3)>], centres: &[DVec3]) {
    let closer = |x: &(f64, usize), y: &(f64, usize)| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1));
    let mut nearest = vec![(f64::INFINITY, 0); centres.len()];
    let of = |group: &[usize], number: usize| -> Vec<usize> {
        (0..group.len()).filter(|&s| group[s] == number).collect()
    };
    let mut new = group.first().map_or(Vec::new(), |&first| of(group, first));
    while !new.is_empty() {
        let outside = || (0..group.len()).filter(|&s| group[s] != group[0]);
        for b in outside() {
            let away = |&a: &usize| (centres[a].distance_squared(centres[b]), a);
            let all = new.iter().map(away).chain([nearest[b]]);
            nearest[b] = all.min_by(closer).unwrap_or(nearest[b]);
        }
        let Some(b) = outside().min_by(|&x, &y| closer(&nearest[x], &nearest[y])) else {
            return;
        };
        let a = nearest[b].1;
        new = of(group, group[b]);
        join(group, near, [a, b], (centres[a] + centres[b]) * 0.5);
    }
}

fn links(hierarchy: &Hierarchy, level: &Level, result: &Decomposition) -> Vec<Link> {
    let rest: Vec<DVec3> = result.rest.iter().map(|p| p.as_dvec3()).collect();
    let borders = borders(&hierarchy.triangles, &level.labels, &rest);
    let link = |border: &Border| {
        let ends = border.spheres;
        let (pivot, apart) = pivot(result, ends, border.middle);
        let [a, b] = ends.map(|s| result.centres[s]);
        Link {
            cost: apart + LENGTH * a.distance(b),
            ends,
            pivot,
        }
    };
    borders.iter().map(link).collect()
}

/// The point p that two bones move most alike, and how far apart it comes on the mean:
/// Σ |A p − B p|² + HOLD n |p − border|², A p − B p = (R_a − R_b) p + t_a − t_b.
fn pivot(result: &Decomposition, [a, b]: [usize; 2], border: DVec3) -> (DVec3, f64) {
    let pairs = || {
        let frames = result.motions.iter().flatten();
        frames.map(|frame| {
            let ((ra, ta), (rb, tb)) = (frame[a], frame[b]);
            (ra - rb, ta - tb)
        })
    };
    let n = pairs().count() as f64;
    let mut matrix = DMat3::from_diagonal(DVec3::splat(HOLD * n));
    let mut right = HOLD * n * border;
    for (turn, shift) in pairs() {
        matrix += turn.transpose() * turn;
        right -= turn.transpose() * shift;
    }
    // At least HOLD n: never singular.
    let p = matrix.inverse() * right;
    let square: f64 = pairs().map(|(r, t)| (r * p + t).length_squared()).sum();
    (p, (square / n).sqrt())
}

/// The node whose greatest branch has the least weight.
fn middle(near: &[Vec<(usize, DVec3)>], size: &[f64]) -> usize {
    let mut order = vec![(0, usize::MAX)];
    let mut row = 0;
    while row < order.len() {
        let (node, parent) = order[row];
        let below = near[node].iter().filter(|n| n.0 != parent);
        order.extend(below.map(|n| (n.0, node)));
        row += 1;
    }
    let total: f64 = size.iter().sum();
    let mut whole = size.to_vec();
    let mut greatest = vec![0.0f64; size.len()];
    for &(node, parent) in order.iter().rev() {
        greatest[node] = greatest[node].max(total - whole[node]);
        if parent != usize::MAX {
            whole[parent] += whole[node];
            greatest[parent] = greatest[parent].max(whole[node]);
        }
    }
    let nodes = 0..size.len();
    { nodes }
        .min_by(|&a, &b| greatest[a].total_cmp(&greatest[b]))
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_hang_on_the_nearest_of_what_hangs_together() {
        let mut seed = 3u32;
        let mut next = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8)
        };
        let centres: Vec<DVec3> = (0..60)
            .map(|_| DVec3::new(next(), next(), next()))
            .collect();
        // 20 pieces of three spheres.
        let mut group: Vec<usize> = (0..60).map(|s| s % 20).collect();
        let mut near = vec![Vec::new(); 60];
        let mut expected = near.clone();
        let mut left = group.clone();
        let pair = |group: &[usize]| {
            let pairs = (0..60).flat_map(|a| (0..60).map(move |b| [a, b]));
            let open = pairs.filter(|[a, b]| group[*a] == group[0] && group[*b] != group[0]);
            let far = |pair: &[usize; 2]| centres[pair[0]].distance_squared(centres[pair[1]]);
            open.min_by(|x, y| far(x).total_cmp(&far(y)))
        };
        while let Some(ends) = pair(&left) {
            let [a, b] = ends.map(|s| centres[s]);
            join(&mut left, &mut expected, ends, (a + b) * 0.5);
        }
        join_pieces(&mut group, &mut near, &centres);
        assert_eq!(near, expected);
        assert_eq!(near.iter().map(Vec::len).sum::<usize>(), 2 * 19);
    }

    #[test]
    fn the_root_is_in_the_middle() {
        let none = DVec3::ZERO;
        let chain: Vec<Vec<(usize, DVec3)>> = vec![
            vec![(1, none)],
            vec![(0, none), (2, none)],
            vec![(1, none), (3, none)],
            vec![(2, none), (4, none)],
            vec![(3, none)],
        ];
        assert_eq!(middle(&chain, &[1.0; 5]), 2);
        assert_eq!(middle(&chain, &[9.0, 1.0, 1.0, 1.0, 1.0]), 0);
    }
}
