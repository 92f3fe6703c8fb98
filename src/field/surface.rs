//! The surface of one part against its bone: which samples describe it, and the function through them (2013, section 4.1).

use glam::DVec3;

use super::{
    Field, FieldBox, Hrbf,
    bone::{Bone, Foot, Parts},
    bounds::bounds,
    hrbf::Constraint,
    sample::{SurfacePoint, candidates, poisson},
};
use crate::mesh::TriangleGrid;

/// Fewest samples that describe a surface around a bone.
const FEWEST_SAMPLES: usize = 12;
/// Poisson-disk samples aimed at (2013: "always sufficient").
const SAMPLES: usize = 50;
/// Culling planes of Eq. 2, as a share of the bone.
const H: f64 = 0.05;
/// Share of the vertices that may lie outside [`USABLE`] before another choice of samples is tried.
const MISFITS: f64 = 0.01;
/// Values at a part's own vertices that can be projected to: elsewhere the gradient vanishes.
const USABLE: std::ops::Range<f64> = 0.05..0.95;
/// How far out, in radii, a layer still covers what is below.
const LAYERS: f64 = 0.6;
/// Least cosine between a sample's normal and the direction away from the bone.
const FACING: f64 = 0.1;
/// Values at a part's own vertices near enough to the surface not to be sampled again.
const NEAR: std::ops::Range<f64> = 0.25..0.75;
/// At most so many times.
const REFINEMENTS: usize = 3;
/// Distance from the bone, in radii, at which the field has to be outside.
const SHELL: f64 = 1.3;

/// A point of a part's surface against its bone.
#[derive(Clone, Copy, Debug)]
struct Point {
    surface: SurfacePoint,
    foot: Foot,
    /// Another layer of the mesh lies over it (a tooth, a leg in trousers, the lining of a coat).
    hidden: bool,
}

/// A part's surface against its bone.
pub(super) struct Surface {
    bone: Bone,
    vertices: Vec<Point>,
    candidates: Vec<Point>,
    /// Least and greatest distance of a vertex from the bone.
    least: f64,
    radius: f64,
}

/// Which candidates are dropped before sampling.
#[derive(Clone, Copy, Debug)]
struct Culling {
    /// Those beyond the planes of Eq. 2 at open ends.
    ends: bool,
    /// Those whose normal points back at the bone or hardly away from it, such as caps between shells.
    inward: bool,
    /// Those inside another shell.
    hidden: bool,
}

/// What is tried in turn.
const CULLINGS: [Culling; 4] = [
    Culling {
        ends: true,
        inward: true,
        hidden: true,
    },
    Culling {
        ends: true,
        inward: false,
        hidden: true,
    },
    Culling {
        ends: false,
        inward: false,
        hidden: true,
    },
    Culling {
        ends: false,
        inward: false,
        hidden: false,
    },
];

/// Between the last samples and a closure at the radius itself the function cuts the corner: a bent elbow lost up to 2.3 %
/// of its radius there.
const CLOSURE: f64 = 1.015;

impl Surface {
    pub(super) fn new(parts: &Parts, triangles: &TriangleGrid, joint: usize, own: &[u32]) -> Self {
        let bone = parts.bone(joint, own);
        let distance = |&v: &u32| bone.foot(parts.vertex(v).position).distance;
        let least = own.iter().map(distance).fold(f64::INFINITY, f64::min);
        let radius = own.iter().map(distance).fold(1e-6 * parts.size, f64::max);
        let point = |surface: SurfacePoint| Point {
            surface,
            foot: bone.foot(surface.position),
            hidden: is_hidden(parts, triangles, &bone, surface, radius),
        };
        let vertices: Vec<Point> = own.iter().map(|&v| point(parts.vertex(v))).collect();
        let candidates = candidates(parts, joint, own)
            .into_iter()
            .map(point)
            .collect();
        Self {
            least,
            radius,
            candidates,
            vertices,
            bone,
        }
    }

    /// The part's field: of the ways to choose samples the first that fits nearly all vertices, else the one that fits most.
    pub(super) fn fit(&self, all: &[Option<Surface>]) -> Option<Field> {
        let mut best: Option<(f64, Field)> = None;
        for culling in CULLINGS {
            let samples = self.samples(culling);
            if samples.len() < FEWEST_SAMPLES.min(self.candidates.len()) {
                continue;
            }
            let Some(field) = self.solve(samples, culling, all) else {
                continue;
            };
            let misfits = self.misfits(&field, USABLE);
            if best.as_ref().is_none_or(|(least, _)| misfits < *least) {
                best = Some((misfits, field));
            }
            if misfits <= MISFITS {
                break;
            }
        }
        let points: Vec<DVec3> = self.vertices.iter().map(|p| p.surface.position).collect();
        best.map(|(_, mut field)| {
            field.bounds = bounds(&field, &points);
            field
        })
    }

    /// Poisson-disk samples of what is left after culling; none where that is too little to stand for the part.
    fn samples(&self, culling: Culling) -> Vec<SurfacePoint> {
        let kept: Vec<SurfacePoint> = self
            .candidates
            .iter()
            .filter(|p| self.keeps(culling, p))
            .map(|p| p.surface)
            .collect();
        if kept.len() < self.candidates.len() / 8 {
            return Vec::new();
        }
        // Many samples on few flat triangles fit the facets' edges rather than a smooth surface.
        poisson(&kept, SAMPLES.min(FEWEST_SAMPLES + self.vertices.len()))
    }

    fn keeps(&self, culling: Culling, p: &Point) -> bool {
        let outward = (p.surface.position - p.foot.point).dot(p.surface.normal);
        let inward = outward < FACING * p.foot.distance;
        !(culling.inward && inward
            || culling.ends && self.beyond_planes(&p.foot)
            || culling.hidden && p.hidden)
    }

    /// Eq. 2, at the ends where the mesh goes on into another part.
    fn beyond_planes(&self, foot: &Foot) -> bool {
        let s = &self.bone.segments[foot.segment];
        s.first && self.bone.open && foot.t < H || s.open && foot.t > 1.0 - H
    }

    /// HRBF through samples and closures, sampled again where it misses vertices.
    fn solve(
        &self,
        samples: Vec<SurfacePoint>,
        culling: Culling,
        all: &[Option<Surface>],
    ) -> Option<Field> {
        let constraint = |p: SurfacePoint| Constraint {
            position: p.position,
            value: 0.0,
            normal: p.normal,
        };
        let mut constraints: Vec<Constraint> = samples.into_iter().map(constraint).collect();
        self.close(&mut constraints, all);
        let mut field = self.bounded(constraints.clone())?;
        for _ in 0..REFINEMENTS {
            let missed = self.missed(&field, culling);
            if missed.is_empty() {
                break;
            }
            constraints.extend(missed.into_iter().map(constraint));
            match self.bounded(constraints.clone()) {
                Some(finer) if self.misfits(&finer, NEAR) < self.misfits(&field, NEAR) => {
                    field = finer
                }
                _ => break,
            }
        }
        Some(field)
    }

    /// Solves the constraints, with further ones wherever the function is still inside around the part.
    fn bounded(&self, mut constraints: Vec<Constraint>) -> Option<Field> {
        let segments = self.bone.segments.iter();
        let mut field = Field {
            joint: self.bone.joint as u16,
            segments: segments
                .map(|s| [s.start.as_vec3(), s.end.as_vec3()])
                .collect(),
            radius: self.radius as f32,
            bounds: FieldBox {
                origin: glam::Vec3::ZERO,
                axes: glam::Mat3::IDENTITY,
                size: glam::Vec3::ONE,
            },
            hrbf: Hrbf::solve(&constraints)?,
        };
        for _ in 0..3 {
            let leaks = self.leaks(&field.hrbf);
            if leaks.is_empty() {
                break;
            }
            constraints.extend(leaks);
            let Some(hrbf) = Hrbf::solve(&constraints) else {
                break;
            };
            field.hrbf = hrbf;
        }
        Some(field)
    }

    /// Vertices that sampling would keep and that lie farthest from the surface that was found, some way apart.
    fn missed(&self, field: &Field, culling: Culling) -> Vec<SurfacePoint> {
        let off = |p: &Point| (field.at(p.surface.position).0 - 0.5).abs();
        let mut missed: Vec<(f64, SurfacePoint)> = self
            .vertices
            .iter()
            .filter(|p| self.keeps(culling, p) && p.surface.normal != DVec3::ZERO)
            .map(|p| (off(p), p.surface))
            .filter(|(off, _)| *off > NEAR.end - 0.5)
            .collect();
        missed.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut taken: Vec<SurfacePoint> = Vec::new();
        for (_, p) in missed {
            let apart = |q: &SurfacePoint| q.position.distance(p.position) > 0.15 * self.radius;
            if taken.len() < 8 && taken.iter().all(apart) {
                taken.push(p);
            }
        }
        taken
    }

    /// Adds the closure of each open end, on the bone's line beyond the joint (2013, figure 4d).
    ///
    /// Its distance from the joint is [`CLOSURE`] times the least vertex-to-bone distance, the mean of the parts that meet there, so that they close alike.
    fn close(&self, constraints: &mut Vec<Constraint>, all: &[Option<Surface>]) {
        let with = |other: Option<usize>| {
            let other = other.and_then(|j| all.get(j)).and_then(Option::as_ref);
            let s = other.map_or(self.least, |o| 0.5 * (self.least + o.least));
            CLOSURE * s.clamp(0.05 * self.radius, self.radius)
        };
        let mut add = |joint: DVec3, normal: DVec3, s: f64| {
            let position = joint + s * normal;
            let near = |c: &Constraint| c.position.distance(position) < 0.1 * self.radius;
            if !constraints.iter().any(near) {
                constraints.push(Constraint {
                    position,
                    value: 0.0,
                    normal,
                });
            }
        };
        if self.bone.open {
            let meeting = all.iter().flatten().find(|o| {
                o.bone
                    .segments
                    .iter()
                    .any(|s| s.open && s.child == Some(self.bone.joint))
            });
            if let Some(first) = self.bone.segments.iter().find(|s| s.first) {
                add(
                    first.start,
                    self.bone.outward,
                    with(meeting.map(|o| o.bone.joint)),
                );
            }
        }
        for s in self.bone.segments.iter().filter(|s| s.open) {
            add(s.end, (s.end - s.start).normalize(), with(s.child));
        }
    }

    /// Constraints d = (SHELL - 1) r around the part, wherever on that shell the function is less than half of it.
    fn leaks(&self, hrbf: &Hrbf) -> Vec<Constraint> {
        let outside = (SHELL - 1.0) * self.radius;
        let mut leaking: Vec<(f64, SurfacePoint)> = self
            .shell()
            .into_iter()
            .map(|p| (hrbf.evaluate(p.position).0, p))
            .filter(|(d, _)| *d < 0.5 * outside)
            .collect();
        leaking.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut taken: Vec<Constraint> = Vec::new();
        for (_, p) in leaking {
            let apart = |c: &Constraint| c.position.distance(p.position) > 0.7 * self.radius;
            if taken.len() < 16 && taken.iter().all(apart) {
                taken.push(Constraint {
                    position: p.position,
                    value: outside,
                    normal: p.normal,
                });
            }
        }
        taken
    }

    /// Points at SHELL radii from the bone, their normals away from it.
    fn shell(&self) -> Vec<SurfacePoint> {
        const DIRECTIONS: usize = 60;
        let distance = SHELL * self.radius;
        let mut shell = Vec::new();
        for s in &self.bone.segments {
            let steps = (s.start.distance(s.end) / self.radius)
                .ceil()
                .clamp(1.0, 12.0) as usize;
            for i in 0..=steps {
                let at = s.start.lerp(s.end, i as f64 / steps as f64);
                shell.extend((0..DIRECTIONS).filter_map(|k| {
                    // Fibonacci spiral.
                    let z = 1.0 - (2 * k + 1) as f64 / DIRECTIONS as f64;
                    let (sin, cos) = (2.399_963_229_728_653 * k as f64).sin_cos();
                    let flat = (1.0 - z * z).sqrt();
                    let position = at + distance * DVec3::new(flat * cos, flat * sin, z);
                    let foot = self.bone.foot(position);
                    (foot.distance > 0.95 * distance).then(|| SurfacePoint {
                        position,
                        normal: (position - foot.point) / foot.distance,
                    })
                }));
            }
        }
        shell
    }

    /// Share of the part's visible vertices at which the field is out of a range.
    fn misfits(&self, field: &Field, range: std::ops::Range<f64>) -> f64 {
        let visible = || self.vertices.iter().filter(|p| !p.hidden);
        let bad = visible().filter(|p| !range.contains(&field.at(p.surface.position).0));
        bad.count() as f64 / visible().count().max(1) as f64
    }
}

/// Whether another layer of the mesh lies over a point: the first surface along its normal is met from within, or the last of the
/// part's own within [`LAYERS`] radii, straight out from the bone, is.
fn is_hidden(
    parts: &Parts,
    triangles: &TriangleGrid,
    bone: &Bone,
    p: SurfacePoint,
    radius: f64,
) -> bool {
    let skip = 1e-5 * parts.size;
    let exits = |row: usize, direction: DVec3| {
        let [a, b, c] = parts.mesh.triangles[row].map(|v| parts.vertex(v).position);
        (b - a).cross(c - a).dot(direction) > 0.0
    };
    let first = triangles.first_hit(p.position + skip * p.normal, p.normal, parts.size, |_| true);
    if first.is_some_and(|(_, row)| exits(row, p.normal)) {
        return true;
    }
    let own = |row: usize| {
        parts.mesh.triangles[row]
            .iter()
            .all(|&v| parts.part[v as usize] == Some(bone.joint))
    };
    let Some(out) = (p.position - bone.foot(p.position).point).try_normalize() else {
        return false;
    };
    let (mut at, mut hidden) = (skip, false);
    for _ in 0..8 {
        let left = LAYERS * radius - at;
        let Some((t, row)) = triangles.first_hit(p.position + at * out, out, left, own) else {
            break;
        };
        hidden = exits(row, out);
        at += t + skip;
    }
    hidden
}
