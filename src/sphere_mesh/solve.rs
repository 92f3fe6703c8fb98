//! The best animated sphere for the union of two regions (2016, Eq. 9 and appendix A).

use multiversion::multiversion;

use super::{
    lanes::{Points, S4, V4, X4},
    quadric::Sum,
    region::Region,
};

/// A block is degenerate where det M is less than this share of (trace M)³.
const DEGENERATE: f64 = 1e-6;

/// The radius is 0 where its coefficient is less than this share of W.
const FLAT: f64 = 1e-9;

/// The adjugate, and the factor that makes it the inverse: 0 in the lanes that are degenerate.
#[inline(always)]
fn inverse(m: &S4) -> (S4, X4) {
    let (adjugate, det) = m.adjugate();
    let trace = m.trace();
    let floor = trace * trace * trace * X4::splat(DEGENERATE);
    let factor = det.zip(floor, |d, f| if d > f { 1.0 / d } else { 0.0 });
    (adjugate, factor)
}

/// The unknowns that all frames share, and what they cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sphere {
    /// Value of the quadric; not finite where nothing could be found.
    pub(super) cost: f64,
    pub(super) radius: f64,
    /// Place on the edge from `u` to `v`, in frames whose block is degenerate.
    lambda: f64,
}

/// Two regions to merge and the centres of their spheres, a group after the other.
#[derive(Clone, Copy)]
pub(super) struct Edge<'a> {
    pub(super) regions: [&'a Region<'a>; 2],
    pub(super) centres: [&'a [Points]; 2],
}

impl Edge<'_> {
    fn groups(&self) -> usize {
        self.regions[0].quadric.groups()
    }

    #[inline(always)]
    fn sum(&self, group: usize) -> Sum {
        let [u, v] = self.regions;
        u.quadric.sum(&v.quadric, group)
    }

    /// Where it begins, and the way to its end.
    #[inline(always)]
    fn line(&self, group: usize) -> (V4, V4) {
        let [from, to] = self.centres.map(|c| V4::widen(&c[group]));
        (from, to - from)
    }
}

/// The quadric with the centres of all regular frames eliminated:
/// ½ μ λ² + ν λ r + ½ w r² - β λ - γ r + base.
#[derive(Clone, Copy, Debug, Default)]
struct Reduced {
    mu: f64,
    nu: f64,
    w: f64,
    beta: f64,
    gamma: f64,
    base: f64,
    /// W, against which w is judged.
    whole: f64,
}

#[multiversion(targets("x86_64+avx2"))]
fn reduce(edge: Edge<'_>) -> Reduced {
    let zero = X4::default();
    let (mut nmn, mut nmb, mut bmb, mut c) = (zero, zero, zero, zero);
    let (mut mu, mut nu, mut beta, mut gamma, mut base) = (zero, zero, zero, zero, zero);
    for group in 0..edge.groups() {
        let block = edge.sum(group);
        let (adjugate, inverse) = inverse(&block.m);
        let mn = adjugate.times(block.n).times(inverse);
        nmn += block.n.dot(mn);
        nmb += block.b.dot(mn);
        bmb += block.b.dot(adjugate.times(block.b)) * inverse;
        c += block.c;
        // In degenerate frames the centre is on the edge; the others are blanked out.
        if inverse.0.iter().all(|&i| i != 0.0) {
            continue;
        }
        let bad = inverse.map(|i| f64::from(u8::from(i == 0.0)));
        let (from, along) = edge.line(group);
        let (m_from, m_along) = (block.m.times(from), block.m.times(along));
        mu += m_along.dot(along) * bad;
        nu += block.n.dot(along) * bad;
        beta += (block.b - m_from).dot(along) * bad;
        gamma += block.n.dot(from) * bad;
        let half = m_from.times(X4::splat(0.5));
        base += (half - block.b).dot(from) * bad;
    }
    let [a, b] = edge.regions.map(|r| r.quadric.sums);
    Reduced {
        mu: mu.sum(),
        nu: nu.sum(),
        w: a.weight + b.weight - nmn.sum(),
        beta: beta.sum(),
        gamma: a.offset + b.offset - gamma.sum() - nmb.sum(),
        base: a.constant + b.constant + c.sum() - 0.5 * bmb.sum() + base.sum(),
        whole: a.weight + b.weight,
    }
}

impl Reduced {
    fn cost(&self, lambda: f64, r: f64) -> f64 {
        0.5 * self.mu * lambda * lambda + self.nu * lambda * r + 0.5 * self.w * r * r
            - self.beta * lambda
            - self.gamma * r
            + self.base
    }

    /// The least cost over λ in [0, 1] and r in [0, `bound`]: inside, on the sides, at the corners (appendix A). Of equal
    /// costs the first is taken, so that a quadric that says nothing gives the middle of the edge and r = 0.
    fn least(&self, bound: f64) -> Sphere {
        // Planes that say nothing about the radius leave rounding errors in w.
        let bound = if self.w > FLAT * self.whole {
            bound
        } else {
            0.0
        };
        let mut best = Sphere {
            cost: f64::INFINITY,
            radius: 0.0,
            lambda: 0.5,
        };
        let mut offer = |lambda: f64, radius: f64| {
            // Not a number is not inside.
            if (0.0..=1.0).contains(&lambda) && (0.0..=bound).contains(&radius) {
                let cost = self.cost(lambda, radius);
                if cost < best.cost {
                    best = Sphere {
                        cost,
                        radius,
                        lambda,
                    };
                }
            }
        };
        let edgeless = self.mu <= 1e-12 * self.w.abs().max(f64::MIN_POSITIVE);
        let straight = self.gamma / self.w;
        if edgeless {
            offer(0.5, 0.0);
            offer(0.5, (straight - 0.5 * self.nu / self.w).clamp(0.0, bound));
        } else {
            let det = self.mu * self.w - self.nu * self.nu;
            let lambda = (self.beta * self.w - self.nu * self.gamma) / det;
            let radius = (self.mu * self.gamma - self.nu * self.beta) / det;
            offer(0.5, 0.0);
            offer(lambda, radius);
            for r in [0.0, bound] {
                offer(((self.beta - self.nu * r) / self.mu).clamp(0.0, 1.0), r);
            }
        }
        for lambda in [0.0, 1.0] {
            let radius = (self.gamma - lambda * self.nu) / self.w;
            offer(lambda, radius.clamp(0.0, bound));
            offer(lambda, 0.0);
            offer(lambda, bound);
        }
        best
    }
}

/// The sphere of least cost for the union of two regions. The radius is bound by the width of the union, or 0 without
/// extents (the classic quadric).
pub(super) fn sphere(edge: Edge<'_>) -> Sphere {
    let reduced = reduce(edge);
    let mut sphere = match edge.regions.map(|r| r.extent.as_ref()) {
        [Some(u), Some(v)] => {
            // The exact bound is dear; where the best sphere of all is below what is known of it, it is not asked for.
            let sphere = reduced.least(f64::MAX);
            if sphere.radius <= u.bound_from_below(v) {
                sphere
            } else {
                reduced.least(u.bound(v))
            }
        }
        _ => reduced.least(0.0),
    };
    sphere.cost = if sphere.cost.is_finite() {
        sphere.cost.max(0.0)
    } else {
        f64::INFINITY
    };
    sphere
}

/// The centres of a sphere that [`sphere`] found, a group after the other.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn centres(edge: Edge<'_>, sphere: &Sphere, out: &mut Vec<Points>) {
    let centres = (0..edge.groups()).map(|group| {
        let block = edge.sum(group);
        let (adjugate, inverse) = inverse(&block.m);
        let pull = block.b - block.n.times(X4::splat(sphere.radius));
        let free = adjugate.times(pull).times(inverse);
        let (from, along) = edge.line(group);
        let bound = from + along.times(X4::splat(sphere.lambda));
        let good = |lane: usize| inverse.0[lane] != 0.0;
        let axis = |k: usize| {
            let (free, bound) = (free.0[k].0, bound.0[k].0);
            let centre = |lane: usize| if good(lane) { free[lane] } else { bound[lane] };
            X4(std::array::from_fn(centre)).narrow()
        };
        [axis(0), axis(1), axis(2)]
    });
    out.clear();
    out.extend(centres);
}
