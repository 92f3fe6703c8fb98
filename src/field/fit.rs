//! From a partitioned mesh to one field a part (2013, section 4.1).

use glam::DVec3;
use rayon::prelude::*;

use super::{
    Field, FieldBox, Hrbf,
    bone::{Bone, Foot, Parts},
    bounds::bounds,
    hrbf::Constraint,
    sample::{SurfacePoint, candidates, poisson},
};
use crate::{Error, Result, mesh::Mesh, rig::Skeleton};

/// Fewest vertices of a part that has a field of its own.
const FEWEST_VERTICES: usize = 8;
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
/// Distance from the bone, in radii, at which the field has to be outside.
const SHELL: f64 = 1.3;

/// The fields of a character.
#[derive(Clone, Debug, Default)]
pub struct Fitted {
    /// Fields, ascending by joint.
    pub fields: Vec<Field>,
    /// For each vertex the joint whose field carries it: the given one where that joint has a field, else the nearest ancestor that
    /// has, else the joint of the field whose bone is nearest. As given where there is no field at all.
    pub part: Vec<u16>,
    /// For each joint the radius r of the field that carries its vertices, in rest units; positive.
    pub radius: Vec<f32>,
    /// Parts without a field, a sentence each.
    pub warnings: Vec<String>,
}

/// Fits an HRBF to every part with at least 8 vertices; smaller parts join the nearest ancestor's.
///
/// `part` is the joint (row of the skeleton) that each vertex belongs to. The result depends on nothing but the arguments.
///
/// # Errors
/// [`Error::Argument`] where `part` has not a row a vertex or names a joint that does not exist.
pub fn fit(mesh: &Mesh, skeleton: &Skeleton, part: Vec<u16>) -> Result<Fitted> {
    check(mesh, skeleton, &part)?;
    let carrier = carriers(skeleton, &part);
    let parts = Parts {
        mesh,
        skeleton,
        size: mesh.diagonal() as f64,
        part: part.iter().map(|&j| carrier[j as usize]).collect(),
        carrier,
    };
    let mut own = vec![Vec::new(); skeleton.joints.len()];
    for (v, part) in parts.part.iter().enumerate() {
        if let Some(joint) = part {
            own[*joint].push(v as u32);
        }
    }
    let surfaces: Vec<Option<Surface>> = (0..own.len())
        .into_par_iter()
        .map(|joint| (!own[joint].is_empty()).then(|| Surface::new(&parts, joint, &own[joint])))
        .collect();
    let fields: Vec<Field> = surfaces
        .par_iter()
        .flatten()
        .filter_map(|surface| surface.fit(&surfaces))
        .collect();
    Ok(assign(mesh, skeleton, part, fields))
}

fn check(mesh: &Mesh, skeleton: &Skeleton, part: &[u16]) -> Result<()> {
    if part.len() != mesh.positions.len() {
        let reason = format!("{} rows for {} vertices", part.len(), mesh.positions.len());
        return Err(Error::argument("part", reason));
    }
    match part
        .iter()
        .position(|&j| j as usize >= skeleton.joints.len())
    {
        Some(v) => Err(Error::argument(
            "part",
            format!("vertex {v}: joint {} of {}", part[v], skeleton.joints.len()),
        )),
        None => Ok(()),
    }
}

/// The joint whose part each joint's vertices join: itself, or the nearest ancestor with enough vertices, those of merged joints counted.
fn carriers(skeleton: &Skeleton, part: &[u16]) -> Vec<Option<usize>> {
    let mut count = vec![0; skeleton.joints.len()];
    for &joint in part {
        count[joint as usize] += 1;
    }
    for joint in (0..count.len()).rev() {
        if let (Some(parent), true) = (
            skeleton.joints[joint].parent,
            count[joint] < FEWEST_VERTICES,
        ) {
            count[parent] += count[joint];
        }
    }
    let mut carrier = vec![None; count.len()];
    for joint in 0..count.len() {
        carrier[joint] = if count[joint] >= FEWEST_VERTICES {
            Some(joint)
        } else {
            skeleton.joints[joint].parent.and_then(|p| carrier[p])
        };
    }
    carrier
}

/// A part's surface against its bone.
struct Surface {
    bone: Bone,
    points: Vec<DVec3>,
    candidates: Vec<(SurfacePoint, Foot)>,
    /// Least and greatest distance of a vertex from the bone.
    least: f64,
    radius: f64,
}

/// Which candidates are dropped before sampling.
#[derive(Clone, Copy, Debug)]
struct Culling {
    /// Those beyond the planes of Eq. 2 at open ends.
    ends: bool,
    /// Those whose normal points back at the bone.
    inward: bool,
}

/// What is tried in turn.
const CULLINGS: [Culling; 3] = [
    Culling {
        ends: true,
        inward: true,
    },
    Culling {
        ends: true,
        inward: false,
    },
    Culling {
        ends: false,
        inward: false,
    },
];

impl Surface {
    fn new(parts: &Parts, joint: usize, own: &[u32]) -> Self {
        let bone = parts.bone(joint, own);
        let points: Vec<DVec3> = own
            .iter()
            .map(|&v| parts.mesh.positions[v as usize].as_dvec3())
            .collect();
        let distance = |x: &DVec3| bone.foot(*x).distance;
        let least = points.iter().map(distance).fold(f64::INFINITY, f64::min);
        let radius = points.iter().map(distance).fold(0.0, f64::max);
        let candidates = candidates(parts, joint, own)
            .into_iter()
            .map(|p| (p, bone.foot(p.position)))
            .collect();
        Self {
            bone,
            points,
            candidates,
            least,
            radius: radius.max(1e-6 * parts.size),
        }
    }

    /// The part's field: of the ways to choose samples the first that fits nearly all vertices, else the one that fits most.
    fn fit(&self, all: &[Option<Surface>]) -> Option<Field> {
        let mut best: Option<(f64, Field)> = None;
        for culling in CULLINGS {
            let samples = self.samples(culling);
            if samples.len() < FEWEST_SAMPLES.min(self.candidates.len()) {
                continue;
            }
            let Some(mut field) = self.solve(&samples, all) else {
                continue;
            };
            let misfits = self.misfits(&field);
            if best.as_ref().is_none_or(|(least, _)| misfits < *least) {
                field.bounds = bounds(&field, &self.points);
                best = Some((misfits, field));
            }
            if misfits <= MISFITS {
                break;
            }
        }
        best.map(|(_, field)| field)
    }

    fn samples(&self, culling: Culling) -> Vec<SurfacePoint> {
        let kept: Vec<SurfacePoint> = self
            .candidates
            .iter()
            .filter(|(p, foot)| {
                !(culling.inward && (p.position - foot.point).dot(p.normal) < 0.0
                    || culling.ends && self.beyond_planes(foot))
            })
            .map(|(p, _)| *p)
            .collect();
        poisson(&kept, SAMPLES)
    }

    /// Eq. 2, at the ends where the mesh goes on into another part.
    fn beyond_planes(&self, foot: &Foot) -> bool {
        let s = &self.bone.segments[foot.segment];
        s.first && self.bone.open && foot.t < H || s.open && foot.t > 1.0 - H
    }

    /// HRBF through samples, closures and, where it is still inside around the part, points that bound it.
    fn solve(&self, samples: &[SurfacePoint], all: &[Option<Surface>]) -> Option<Field> {
        let mut constraints: Vec<Constraint> = samples
            .iter()
            .map(|p| Constraint {
                position: p.position,
                value: 0.0,
                normal: p.normal,
            })
            .collect();
        self.close(&mut constraints, all);
        let mut field = Field {
            joint: self.bone.joint as u16,
            segments: self
                .bone
                .segments
                .iter()
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

    /// Adds the closure of each open end, on the bone's line beyond the joint (2013, figure 4d).
    ///
    /// Its distance from the joint is the least vertex-to-bone distance, the mean of the parts that meet there, so that they close alike.
    fn close(&self, constraints: &mut Vec<Constraint>, all: &[Option<Surface>]) {
        let with = |other: Option<usize>| {
            let other = other.and_then(|j| all.get(j)).and_then(Option::as_ref);
            let s = other.map_or(self.least, |o| 0.5 * (self.least + o.least));
            s.clamp(0.05 * self.radius, self.radius)
        };
        let mut add = |joint: DVec3, normal: DVec3, s: f64| {
            let position = joint + s * normal;
            let near = |c: &Constraint| c.position.distance(position) < 0.02 * self.radius;
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

    /// Share of the part's vertices at which the field cannot be used.
    fn misfits(&self, field: &Field) -> f64 {
        let bad = self
            .points
            .iter()
            .filter(|x| !USABLE.contains(&field.at(**x).0));
        bad.count() as f64 / self.points.len() as f64
    }
}

/// Gives every vertex a field and every joint a radius.
fn assign(mesh: &Mesh, skeleton: &Skeleton, mut part: Vec<u16>, fields: Vec<Field>) -> Fitted {
    let joints = skeleton.joints.len();
    let mut row = vec![None; joints];
    for (i, field) in fields.iter().enumerate() {
        row[field.joint as usize] = Some(i);
    }
    let mut lost = vec![0; joints];
    for joint in 0..joints {
        let parent = skeleton.joints[joint].parent;
        row[joint] = row[joint].or_else(|| parent.and_then(|p| row[p]));
    }
    for (v, joint) in part.iter_mut().enumerate() {
        let x = mesh.positions[v].as_dvec3();
        let nearest = || {
            (0..fields.len())
                .min_by(|&a, &b| fields[a].to_bone(x).0.total_cmp(&fields[b].to_bone(x).0))
        };
        if let Some(i) = row[*joint as usize].or_else(nearest) {
            if fields[i].joint != *joint {
                lost[*joint as usize] += 1;
            }
            *joint = fields[i].joint;
        }
    }
    let fallback = 0.02 * mesh.diagonal().max(f32::MIN_POSITIVE);
    let mut warnings: Vec<String> = (0..joints)
        .filter(|&j| lost[j] > 0)
        .map(|j| {
            let name = &skeleton.joints[j].name;
            format!(
                "joint {name:?} has no field of its own: its {} vertices use another's",
                lost[j]
            )
        })
        .collect();
    if fields.is_empty() {
        warnings.push("no part is large enough for an implicit field".into());
    }
    Fitted {
        radius: row
            .iter()
            .map(|i| i.map_or(fallback, |i: usize| fields[i].radius))
            .collect(),
        fields,
        part,
        warnings,
    }
}
