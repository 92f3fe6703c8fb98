//! What of a surface can be seen from outside: the rule for what is outer surface, of a mesh and of a sphere-mesh.

use glam::DVec3;
use rayon::prelude::*;

use super::{facets::Facet, tree::Bounds};
use crate::mesh::{Mesh, TriangleGrid};

/// Directions of sight, over the whole sphere.
const SIGHTS: usize = 96;
/// Sights that must be free: a shell open at mouth or eyes lets a few out.
const FREE: usize = 3;

/// What hides, about its own middle: far from the origin single precision holds too little of it.
pub(super) struct Walls {
    mesh: Mesh,
    middle: DVec3,
}

impl Walls {
    pub(super) fn new(facets: &[Facet]) -> Self {
        let bounds = Bounds::of(facets.iter().flatten().copied());
        let middle = bounds.middle();
        let corners = facets.iter().flatten().map(|p| (p - middle).as_vec3());
        let rows = (0..facets.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
        Self {
            mesh: Mesh::new(corners.collect(), rows.collect()),
            middle,
        }
    }
}

/// Looks from a surface past walls.
pub(super) struct Sight<'a> {
    grid: TriangleGrid<'a>,
    middle: DVec3,
    directions: Vec<DVec3>,
    reach: f64,
    /// Distance of the eye from the surface.
    lift: f64,
}

impl<'a> Sight<'a> {
    pub(super) fn new(walls: &'a Walls, lift: f64) -> Self {
        Self {
            grid: TriangleGrid::new(&walls.mesh),
            middle: walls.middle,
            directions: directions(),
            reach: 4.0 * f64::from(walls.mesh.diagonal()),
            lift,
        }
    }

    /// The eye before a surface.
    pub(super) fn eye(&self, at: DVec3, normal: DVec3) -> DVec3 {
        at + normal * self.lift
    }

    /// Whether enough sights from before a surface are free; of a wire, which has no normal, from all around it.
    pub(super) fn free(&self, at: DVec3, normal: DVec3) -> bool {
        let origin = self.eye(at, normal) - self.middle;
        let ahead = |s: &&DVec3| normal == DVec3::ZERO || s.dot(normal) > 0.1;
        let open = |s: &&DVec3| {
            let hit = self.grid.first_hit(origin, **s, self.reach, |_| true);
            hit.is_none()
        };
        let free = self.directions.iter().filter(ahead).filter(open);
        free.take(FREE).count() == FREE
    }
}

/// Middle and unit normal of a facet; no normal where it has no area.
pub(super) fn middle_and_normal([a, b, c]: &Facet) -> (DVec3, DVec3) {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    ((a + b + c) / 3.0, normal)
}

/// The facets of a surface that are seen, from whichever side: what lies inside of the body is none of its outer surface.
pub(super) fn seen(surface: Vec<Facet>, lift: f64) -> Vec<Facet> {
    let walls = Walls::new(&surface);
    let sight = Sight::new(&walls, lift);
    let seen = surface.into_par_iter().filter(|facet| {
        let (middle, normal) = middle_and_normal(facet);
        sight.free(middle, normal) || sight.free(middle, -normal)
    });
    seen.collect()
}

fn directions() -> Vec<DVec3> {
    let golden = std::f64::consts::PI * (1.0 + 5f64.sqrt());
    let direction = |i: usize| {
        // A prime stride: neighbours in the list are far from each other in direction.
        let i = (i * 37 % SIGHTS) as f64 + 0.5;
        let z = 1.0 - 2.0 * i / SIGHTS as f64;
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * (golden * i).cos(), r * (golden * i).sin(), z)
    };
    (0..SIGHTS).map(direction).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere_mesh::{
        facets::facets,
        shape::{Ball, Shape},
    };

    /// Two balls that cross: of each what is inside of the other is not seen, and all else is; whichever side is called
    /// the front, and however far they are from the origin.
    #[test]
    fn what_is_inside_of_a_body_is_not_seen() {
        let ball = |x: f64, radius: f64| Ball {
            centre: DVec3::X * x,
            radius,
        };
        let balls = vec![ball(0.0, 1.0), ball(1.2, 0.8)];
        let shape = Shape {
            balls: balls.clone(),
            edges: Vec::new(),
            triangles: Vec::new(),
        };
        let surface = facets(&shape, 0.1, 0.01);
        let way = DVec3::new(1e6, -2e6, 3e6);
        let turned = surface.iter().map(|&[a, b, c]| [a, c, b]);
        let moved = surface.iter().map(|t| t.map(|p| p + way));
        for (surface, way) in [
            (surface.clone(), DVec3::ZERO),
            (turned.collect(), DVec3::ZERO),
            (moved.collect(), way),
        ] {
            let depth = |facet: &Facet| {
                let at = middle_and_normal(facet).0 - way;
                let depths = balls.iter().map(|b| b.radius - at.distance(b.centre));
                depths.fold(f64::NEG_INFINITY, f64::max)
            };
            // Facets are at most .01 inside of the ball that they are of.
            let inside = surface.iter().filter(|facet| depth(facet) > 0.02).count();
            let at_seams = surface.iter().filter(|facet| depth(facet) > 0.011);
            let at_seams = at_seams.count() - inside;
            let kept = seen(surface.clone(), 1e-4);
            assert!(kept.iter().all(|facet| depth(facet) <= 0.02));
            let hidden = surface.len() - kept.len();
            assert!(
                (inside..=inside + at_seams + 40).contains(&hidden),
                "{hidden} {inside} {at_seams}"
            );
            assert!(inside > surface.len() / 10);
        }
    }

    #[test]
    fn a_sheet_is_seen_from_either_side_and_a_wire_from_all() {
        let sheet = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let wire = [DVec3::Z, DVec3::Z + DVec3::X, DVec3::Z];
        assert_eq!(seen(vec![sheet, wire], 1e-4), [sheet, wire]);
        assert_eq!(seen(Vec::new(), 1e-4), [[DVec3::ZERO; 3]; 0]);
    }
}
