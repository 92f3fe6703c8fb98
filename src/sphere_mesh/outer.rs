//! The outer surface of a shape: what of its solids' surfaces is in no other solid and can be seen from outside.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::{
    facets::{Facet, facets},
    shape::{Shape, Solid},
    sight::{Sight, Walls, middle_and_normal},
    tree::Tree,
};

/// How often a facet is quartered where another solid cuts it.
const CUTS: usize = 2;

/// Triangles of the outer surface, neither joined nor exactly cut: for measuring.
///
/// Facets are at most `size` long and at most a hundredth of that beside the round surface. Whether a facet is seen is
/// asked of the surface itself, not of a flood of the space around it, for a sphere-mesh is often a shell with a hole.
pub(super) fn outer(shape: &Shape, size: f64) -> Vec<Facet> {
    let solids = shape.solids();
    let boxes: Vec<_> = solids.iter().map(Solid::bounds).collect();
    let chord = 0.01 * size;
    let hidden = Hidden {
        tree: Tree::new(&boxes),
        solids: &solids,
        depth: 2.0 * chord,
    };
    let open: Vec<Facet> = facets(shape, size, chord)
        .into_par_iter()
        .flat_map_iter(|facet| {
            let mut kept = Vec::new();
            hidden.cut(facet, CUTS, &mut kept);
            kept
        })
        .collect();
    // Whatever hides is hidden or not: whole solids, coarse, leave no gaps.
    let coarse = facets(shape, f64::INFINITY, 0.1 * size);
    let walls = Walls::new(&coarse);
    let sight = Sight::new(&walls, 0.01 * size);
    let seen = |facet: &Facet| hidden.seen(&sight, facet);
    let patches: Vec<Vec<Facet>> = patches(open, 3.0 * size);
    let kept = patches.into_par_iter().map(|mut patch| {
        match apart(&patch).map(|k| seen(&patch[k])) {
            [true, true, true] => {}
            [false, false, false] => patch.clear(),
            _ => patch.retain(seen),
        }
        patch
    });
    kept.flatten_iter().collect()
}

/// Three facets of a patch. Sight changes slowly: where they agree they decide for all of it. The largest is one, for cuts leave
/// many small facets in the folds between solids, of which few sights are free; the others are as far from it and from each
/// other as can be, for there may be the inside of a shell beside its outside.
fn apart(patch: &[Facet]) -> [usize; 3] {
    let farthest = |measure: &dyn Fn(&Facet) -> f64| {
        let all = patch.iter().map(measure).enumerate();
        all.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(k, _)| k)
    };
    let from = |k: usize| {
        let middle = middle_and_normal(&patch[k]).0;
        move |facet: &Facet| middle_and_normal(facet).0.distance_squared(middle)
    };
    let first = farthest(&doubled_area);
    let second = farthest(&from(first));
    let (one, other) = (from(first), from(second));
    let third = farthest(&|facet| one(facet).min(other(facet)));
    [first, second, third]
}

fn doubled_area([a, b, c]: &Facet) -> f64 {
    (b - a).cross(c - a).length()
}

/// Facets of one place that look the same way.
fn patches(facets: Vec<Facet>, size: f64) -> Vec<Vec<Facet>> {
    let mut patches = BTreeMap::<[i64; 4], Vec<Facet>>::new();
    for facet in facets {
        let [a, b, c] = facet;
        let cell = ((a + b + c) / (3.0 * size)).floor();
        let normal = (b - a).cross(c - a);
        let octant = [normal.x, normal.y, normal.z].map(|x| i64::from(x > 0.0));
        let key = [cell.x as i64, cell.y as i64, cell.z as i64];
        let way = octant[0] + 2 * octant[1] + 4 * octant[2];
        patches
            .entry([key[0], key[1], key[2], way])
            .or_default()
            .push(facet);
    }
    patches.into_values().collect()
}

struct Hidden<'a> {
    tree: Tree,
    solids: &'a [Solid],
    /// Depth from which on a point is inside: facets stand a little inside of the solid that they are of.
    depth: f64,
}

impl Hidden<'_> {
    fn at(&self, p: DVec3) -> bool {
        self.tree
            .any_at(p, |k| self.solids[k].distance(p) < -self.depth)
    }

    /// Keeps of a facet what is in no solid, quartering it where some of its corners are.
    fn cut(&self, facet: Facet, cuts: usize, kept: &mut Vec<Facet>) {
        let [a, b, c] = facet;
        let count = facet.iter().filter(|p| self.at(**p)).count();
        if count == 0 || count == 3 || cuts == 0 {
            if !self.at((a + b + c) / 3.0) {
                kept.push(facet);
            }
            return;
        }
        let (ab, bc, ca) = ((a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5);
        for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            self.cut(part, cuts - 1, kept);
        }
    }

    /// Whether a facet is seen from outside; a sheet without thickness may be from either side.
    fn seen(&self, sight: &Sight<'_>, facet: &Facet) -> bool {
        let (middle, normal) = middle_and_normal(facet);
        let behind = sight.eye(middle, -normal);
        let thin = || {
            !self
                .tree
                .any_at(behind, |k| self.solids[k].distance(behind) < 0.0)
        };
        sight.free(middle, normal) || (thin() && sight.free(middle, -normal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere_mesh::{
        shape::Ball,
        testing::Chance,
        tree::{Bounds, to_triangle},
    };

    /// Balls along an arc, all of whose surface is seen: it is there right up to the seams between them.
    #[test]
    fn nothing_that_is_seen_is_missing() {
        let mut chance = Chance(5);
        let balls: Vec<Ball> = (0..14)
            .map(|k| {
                let angle = 0.2 * f64::from(k);
                let centre = DVec3::new(angle.cos(), angle.sin(), 0.0) + chance.point(0.01);
                let radius = 0.14 + 0.02 * chance.next();
                Ball { centre, radius }
            })
            .collect();
        let shape = Shape {
            balls: balls.clone(),
            edges: Vec::new(),
            triangles: Vec::new(),
        };
        let size = 0.02;
        let surface = outer(&shape, size);
        let boxes: Vec<Bounds> = surface.iter().map(|&t| Bounds::of(t)).collect();
        let tree = Tree::new(&boxes);
        let (mut furthest, mut sum, mut count) = (0.0f64, 0.0, 0);
        for (k, ball) in balls.iter().enumerate() {
            for _ in 0..2000 {
                let at = ball.centre + ball.radius * chance.point(1.0).normalize();
                let holds = |other: &Ball| at.distance(other.centre) < other.radius;
                if balls
                    .iter()
                    .enumerate()
                    .any(|(j, other)| j != k && holds(other))
                {
                    continue;
                }
                let of = |t: usize| to_triangle(at, surface[t]);
                let distance = tree.nearest(at, f64::INFINITY, of).sqrt();
                furthest = furthest.max(distance);
                sum += distance;
                count += 1;
            }
        }
        // Facets are quartered twice at the seams.
        assert!(furthest < 0.3 * size, "{furthest}");
        assert!(sum / f64::from(count) < 0.015 * size, "{sum} {count}");
    }
}
