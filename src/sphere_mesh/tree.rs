//! Boxes in a tree: which of them hold a point, and what in them is nearest.

use glam::DVec3;

/// Boxes of a leaf.
const LEAF: usize = 4;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) low: DVec3,
    pub(super) high: DVec3,
}

impl Bounds {
    pub(super) fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        let none = Self {
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
        };
        points.into_iter().fold(none, |b, p| Self {
            low: b.low.min(p),
            high: b.high.max(p),
        })
    }

    fn join(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    pub(super) fn middle(&self) -> DVec3 {
        (self.low + self.high) * 0.5
    }

    /// Square of the distance, 0 inside.
    fn distance(&self, p: DVec3) -> f64 {
        (p - p.clamp(self.low, self.high)).length_squared()
    }
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// First item of a leaf, or the second child of an inner node; the first follows it.
    at: u32,
    /// Items of a leaf, 0 in an inner node.
    count: u32,
}

/// A binary tree over boxes, halved at the median of the longest axis.
#[derive(Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    items: Vec<u32>,
}

impl Tree {
    pub(super) fn new(boxes: &[Bounds]) -> Self {
        let mut tree = Self {
            nodes: Vec::with_capacity(boxes.len()),
            items: (0..boxes.len() as u32).collect(),
        };
        if !boxes.is_empty() {
            tree.split(boxes, 0, boxes.len());
        }
        tree
    }

    fn split(&mut self, boxes: &[Bounds], from: usize, to: usize) {
        let items = &mut self.items[from..to];
        let of = |&i: &u32| boxes[i as usize];
        let all = items.iter().map(of).reduce(Bounds::join);
        let bounds = all.unwrap_or(boxes[0]);
        let leaf = items.len() <= LEAF;
        let row = self.nodes.len();
        self.nodes.push(Node {
            bounds,
            at: from as u32,
            count: if leaf { items.len() as u32 } else { 0 },
        });
        if leaf {
            return;
        }
        let middles = Bounds::of(items.iter().map(|i| of(i).middle()));
        let size = middles.high - middles.low;
        let axis = (0..3)
            .max_by(|&a, &b| size[a].total_cmp(&size[b]))
            .unwrap_or(0);
        let half = items.len() / 2;
        items.select_nth_unstable_by(half, |a, b| {
            let order = of(a).middle()[axis].total_cmp(&of(b).middle()[axis]);
            order.then_with(|| a.cmp(b))
        });
        self.split(boxes, from, from + half);
        self.nodes[row].at = self.nodes.len() as u32;
        self.split(boxes, from + half, to);
    }

    /// Least of `of` over the items, where that is the square of a distance and never less than that to the item's box;
    /// `limit` where nothing is nearer.
    pub(super) fn nearest(&self, p: DVec3, limit: f64, of: impl Fn(usize) -> f64) -> f64 {
        let mut best = limit;
        // Depth is at most log2 of 2³², and a step leaves one node behind.
        let mut stack = [(0u32, 0.0f64); 64];
        let mut top = usize::from(!self.nodes.is_empty());
        while top > 0 {
            top -= 1;
            let (row, near) = stack[top];
            if near >= best {
                continue;
            }
            let node = &self.nodes[row as usize];
            if node.count > 0 {
                for &item in &self.items[node.at as usize..][..node.count as usize] {
                    best = best.min(of(item as usize));
                }
                continue;
            }
            let pair = [row + 1, node.at].map(|r| (r, self.nodes[r as usize].bounds.distance(p)));
            let [near, far] = if pair[0].1 <= pair[1].1 {
                pair
            } else {
                [pair[1], pair[0]]
            };
            stack[top] = far;
            stack[top + 1] = near;
            top += 2;
        }
        best
    }

    /// Whether `of` holds for an item whose box has the point.
    pub(super) fn any_at(&self, p: DVec3, of: impl Fn(usize) -> bool) -> bool {
        let mut stack = [0u32; 64];
        let mut top = usize::from(!self.nodes.is_empty());
        while top > 0 {
            top -= 1;
            let row = stack[top];
            let node = &self.nodes[row as usize];
            if node.bounds.distance(p) > 0.0 {
                continue;
            }
            if node.count > 0 {
                let items = &self.items[node.at as usize..][..node.count as usize];
                if items.iter().any(|&item| of(item as usize)) {
                    return true;
                }
                continue;
            }
            stack[top] = node.at;
            stack[top + 1] = row + 1;
            top += 2;
        }
        false
    }
}

/// Square of the distance of a point to a triangle, which may be degenerate (Ericson, Real-Time Collision Detection, 5.1.5).
pub(super) fn to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if va > 0.0 && vb > 0.0 && vc > 0.0 {
        let inside = a + (ab * vb + ac * vc) / (va + vb + vc);
        return inside.distance_squared(p);
    }
    let side = |a: DVec3, b: DVec3| {
        let ab = b - a;
        let t = (p - a).dot(ab) / ab.length_squared().max(f64::MIN_POSITIVE);
        (a + ab * t.clamp(0.0, 1.0)).distance_squared(p)
    };
    side(a, b).min(side(b, c)).min(side(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(count: usize) -> Vec<DVec3> {
        let mut seed = 1u64;
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 40) as f64 / f64::from(1 << 24)
        };
        (0..count)
            .map(|_| DVec3::new(next(), next(), next()))
            .collect()
    }

    #[test]
    fn the_nearest_triangle_is_that_of_trying_all() {
        let corners = points(300);
        let triangles: Vec<[DVec3; 3]> = corners
            .windows(3)
            .map(|w| [w[0], w[0] + 0.1 * w[1], w[0] + 0.1 * w[2]])
            .collect();
        let boxes: Vec<Bounds> = triangles.iter().map(|&t| Bounds::of(t)).collect();
        let tree = Tree::new(&boxes);
        for p in points(200) {
            let all = triangles.iter().map(|&t| to_triangle(p, t));
            let best = all.fold(f64::INFINITY, f64::min);
            assert_eq!(
                tree.nearest(p, f64::INFINITY, |k| to_triangle(p, triangles[k])),
                best
            );
            let held = boxes.iter().any(|b| b.distance(p) == 0.0);
            assert_eq!(tree.any_at(p, |_| true), held);
        }
        assert_eq!(Tree::new(&[]).nearest(DVec3::ZERO, 7.0, |_| 0.0), 7.0);
    }

    #[test]
    fn distances_to_a_triangle_agree_with_dense_samples() {
        let flat = [DVec3::ZERO, DVec3::X, DVec3::X * 0.5];
        for t in [
            [DVec3::ZERO, DVec3::X, DVec3::new(0.3, 0.8, 0.1)],
            flat,
            [DVec3::ONE; 3],
        ] {
            for p in points(60).into_iter().map(|p| 3.0 * p - 1.0) {
                let mut best = f64::INFINITY;
                for i in 0..=100 {
                    for j in 0..=100 - i {
                        let (u, v) = (f64::from(i) / 100.0, f64::from(j) / 100.0);
                        let q = t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
                        best = best.min(q.distance(p));
                    }
                }
                let exact = to_triangle(p, t).sqrt();
                assert!(
                    exact <= best + 1e-12 && best - exact < 0.01,
                    "{t:?} {p} {exact} {best}"
                );
            }
        }
    }
}
