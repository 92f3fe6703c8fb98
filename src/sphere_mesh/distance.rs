//! How far a level is from the mesh that it stands for: sampled distances between the two outer surfaces, as Metro measures
//! them (Cignoni, Rocchini & Scopigno 1998). What of either cannot be seen from outside, as skin in a fold that the body closes
//! over, is none of its outer surface.

use glam::DVec3;
use rayon::prelude::*;

use super::{
    facets::Facet,
    hierarchy::Hierarchy,
    level::Level,
    outer::outer,
    shape::{Shape, gradient},
    sight::seen,
    tree::{Bounds, Tree, to_triangle},
};

/// Samples of the mesh, at least.
const SAMPLES: usize = 50_000;

/// Facets of the surface are this much smaller than the diagonal.
const FINENESS: f64 = 160.0;

/// Distance of the eye from a surface of which is asked whether it is seen, against the diagonal.
const LIFT: f64 = 1.0 / 16_000.0;

/// Distances between outer surfaces, in % of the bounding box's diagonal of the frame; of the sequence where the frame is a single point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distances {
    /// Greatest of all, in both directions.
    pub hausdorff: f64,
    /// Mean from the mesh to the level.
    pub m12: f64,
    /// Mean from the level to the mesh.
    pub m21: f64,
}

/// What of a level is its surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sheets {
    /// The outer surface of the interpolated spheres.
    Outer,
    /// The triangles between the centres, and wires where there are none, as far as they are seen: of the classic quadric.
    Flat,
}

impl Distances {
    /// Means over frames.
    pub fn mean(all: &[Self]) -> Self {
        let share = 1.0 / all.len().max(1) as f64;
        all.iter().fold(Self::default(), |sum, d| Self {
            hausdorff: sum.hausdorff + share * d.hausdorff,
            m12: sum.m12 + share * d.m12,
            m21: sum.m21 + share * d.m21,
        })
    }
}

/// The surface of a level in a frame, as loose triangles of at most 1/160 of the diagonal, in the sequence's units; its
/// centres, as triangles without extent, where all that there is are points.
pub fn surface_facets(
    hierarchy: &Hierarchy,
    level: &Level,
    sheets: Sheets,
    frame: usize,
) -> Vec<[DVec3; 3]> {
    let shape = Shape::new(hierarchy, level, frame);
    let size = hierarchy.diagonal / FINENESS;
    let points: Vec<Facet> = shape.balls.iter().map(|ball| [ball.centre; 3]).collect();
    let surface = match sheets {
        Sheets::Outer => outer(&shape, size),
        Sheets::Flat => seen(flat(shape, size), LIFT * hierarchy.diagonal),
    };
    if surface.is_empty() { points } else { surface }
}

fn flat(mut shape: Shape, size: f64) -> Vec<Facet> {
    shape.balls.iter_mut().for_each(|ball| ball.radius = 0.0);
    // A triangle without area is no face; its sides are wires then, as facets makes them.
    debug_assert!(shape.triangles.iter().all(|t| {
        gradient(&t.map(|k| shape.balls[k as usize])).is_none_or(|(g, _)| g == DVec3::ZERO)
    }));
    super::facets::facets(&shape, size, size)
}

/// Distances of one frame.
pub fn distances(hierarchy: &Hierarchy, level: &Level, sheets: Sheets, frame: usize) -> Distances {
    let position = |v: u32| hierarchy.position(v as usize, frame).as_dvec3();
    let mesh = hierarchy.triangles.iter().map(|t| t.map(position));
    let mesh = seen(mesh.collect(), LIFT * hierarchy.diagonal);
    let surface = surface_facets(hierarchy, level, sheets, frame);
    let points = (0..hierarchy.vertices as u32).map(position);
    let bounds = Bounds::of(points);
    let diagonal = (bounds.high - bounds.low).length();
    let percent = 100.0
        / if diagonal > 0.0 {
            diagonal
        } else {
            hierarchy.diagonal
        };
    let there = Target::new(&surface).measure(&samples(&mesh));
    let back = Target::new(&mesh).measure(&middles(&surface));
    Distances {
        hausdorff: percent * there.greatest.max(back.greatest),
        m12: percent * there.mean,
        m21: percent * back.mean,
    }
}

/// A point that stands for some area.
struct Sample {
    at: DVec3,
    area: f64,
}

fn area([a, b, c]: &Facet) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// Points spread evenly over large triangles, one at least in each; and the corners, which stand for no area.
fn samples(mesh: &[Facet]) -> Vec<Sample> {
    let total: f64 = mesh.iter().map(area).sum();
    let of = |facet: &Facet| {
        let [a, b, c] = *facet;
        let area = area(facet);
        let share = if total > 0.0 { area / total } else { 0.0 };
        let count = (share * SAMPLES as f64).ceil().clamp(1.0, SAMPLES as f64) as usize;
        let inner = (0..count).map(move |k| {
            // The R2 sequence, folded into the triangle; a single point is its centre.
            let (mut u, mut v) = (1.0 / 3.0, 1.0 / 3.0);
            if count > 1 {
                u = (0.5 + 0.754_877_666_246_692_7 * k as f64).fract();
                v = (0.5 + 0.569_840_290_998_053_2 * k as f64).fract();
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
            }
            let at = a + (b - a) * u + (c - a) * v;
            let area = area / count as f64;
            Sample { at, area }
        });
        let corner = |at| Sample { at, area: 0.0 };
        inner.chain([a, b, c].map(corner))
    };
    mesh.iter().flat_map(of).collect()
}

/// The middle of each small triangle.
fn middles(surface: &[Facet]) -> Vec<Sample> {
    let of = |facet: &Facet| {
        let [a, b, c] = facet;
        let at = (a + b + c) / 3.0;
        let area = area(facet);
        Sample { at, area }
    };
    surface.iter().map(of).collect()
}

struct Target<'a> {
    facets: &'a [Facet],
    tree: Tree,
}

struct Measured {
    greatest: f64,
    mean: f64,
}

impl<'a> Target<'a> {
    fn new(facets: &'a [Facet]) -> Self {
        let boxes: Vec<Bounds> = facets.iter().map(|&t| Bounds::of(t)).collect();
        let tree = Tree::new(&boxes);
        Self { facets, tree }
    }

    fn measure(&self, samples: &[Sample]) -> Measured {
        // In order, so that neighbours tell each other where to look and the sum does not depend on threads.
        let parts: Vec<[f64; 4]> = samples
            .par_chunks(1024)
            .map(|part| {
                let mut sums = [0.0f64; 4];
                let (mut before, mut reach) = (None, f64::INFINITY);
                for sample in part {
                    if let Some((at, distance)) = before {
                        reach = sample.at.distance(at) + distance;
                    }
                    let limit = (reach * reach) * (1.0 + 1e-9) + f64::MIN_POSITIVE;
                    let of = |k: usize| to_triangle(sample.at, self.facets[k]);
                    let distance = self.tree.nearest(sample.at, limit, of).sqrt();
                    before = Some((sample.at, distance));
                    sums[0] = sums[0].max(distance);
                    sums[1] += sample.area * distance;
                    sums[2] += sample.area;
                    sums[3] += distance;
                }
                sums
            })
            .collect();
        let sum = parts
            .iter()
            .fold([0.0f64; 4], |[a, b, c, d], [x, y, z, w]| {
                [a.max(*x), b + y, c + z, d + w]
            });
        Measured {
            greatest: if self.facets.is_empty() || samples.is_empty() {
                0.0
            } else {
                sum[0]
            },
            // Points and lines have no area: all samples count alike then.
            mean: if sum[2] > 0.0 {
                sum[1] / sum[2]
            } else {
                sum[3] / samples.len().max(1) as f64
            },
        }
    }
}
