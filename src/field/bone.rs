//! Bone segments of a part: which they are, which of their ends are cut, and how far a point is from them.

use glam::DVec3;

use super::sample::SurfacePoint;
use crate::{mesh::Mesh, rig::Skeleton};

/// Segments shorter than this share of the character's size are none.
const COINCIDENT: f64 = 1e-4;

/// A bone segment in rest space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    pub(super) start: DVec3,
    pub(super) end: DVec3,
    /// Joint at the end, where that joint is no member of the part.
    pub(super) child: Option<usize>,
    /// It begins at the part's own joint.
    pub(super) first: bool,
    /// The mesh goes on into another part beyond the end.
    pub(super) open: bool,
}

/// The bone of one part: all segments from its joints to their children.
#[derive(Clone, Debug)]
pub(super) struct Bone {
    pub(super) joint: usize,
    pub(super) segments: Vec<Segment>,
    /// The mesh goes on into another part at the joint itself.
    pub(super) open: bool,
    /// Unit direction out of the part at the joint.
    pub(super) outward: DVec3,
}

/// The nearest point of a bone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    pub(super) segment: usize,
    /// Parameter on the segment's line, not clamped.
    pub(super) t: f64,
    pub(super) point: DVec3,
    pub(super) distance: f64,
}

/// Nearest point of a segment and its parameter before clamping.
pub(super) fn project(x: DVec3, start: DVec3, end: DVec3) -> (f64, DVec3) {
    let axis = end - start;
    let t = (x - start).dot(axis) / axis.length_squared().max(f64::MIN_POSITIVE);
    (t, start + t.clamp(0.0, 1.0) * axis)
}

impl Bone {
    /// Nearest point to `x`.
    pub(super) fn foot(&self, x: DVec3) -> Foot {
        let mut best = Foot {
            segment: 0,
            t: 0.0,
            point: DVec3::ZERO,
            distance: f64::INFINITY,
        };
        for (segment, s) in self.segments.iter().enumerate() {
            let (t, point) = project(x, s.start, s.end);
            let distance = x.distance(point);
            if distance < best.distance {
                best = Foot {
                    segment,
                    t,
                    point,
                    distance,
                };
            }
        }
        best
    }
}

/// Which joint's field carries each joint's vertices, and the mesh they are on.
pub(super) struct Parts<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) skeleton: &'a Skeleton,
    /// Diagonal of the mesh's bounding box.
    pub(super) size: f64,
    /// Joint whose part each joint belongs to.
    pub(super) carrier: Vec<Option<usize>>,
    /// Joint whose part each vertex belongs to.
    pub(super) part: Vec<Option<usize>>,
}

impl Parts<'_> {
    /// Origin of a joint in rest space.
    pub(super) fn origin(&self, joint: usize) -> DVec3 {
        self.skeleton.joints[joint]
            .bind
            .w_axis
            .truncate()
            .as_dvec3()
    }

    /// A vertex with its normal.
    pub(super) fn vertex(&self, v: u32) -> SurfacePoint {
        SurfacePoint {
            position: self.mesh.positions[v as usize].as_dvec3(),
            normal: self.mesh.normals[v as usize].as_dvec3(),
        }
    }

    /// The bone of a joint's part, given the part's vertices.
    pub(super) fn bone(&self, joint: usize, own: &[u32]) -> Bone {
        let mut bone = Bone {
            joint,
            segments: self.segments(joint),
            open: false,
            outward: DVec3::ZERO,
        };
        self.open_ends(&mut bone, own);
        self.fit_to_part(&mut bone, own);
        bone.outward = self.outward(&bone);
        bone
    }

    /// Segments from the joints of the part to their children; a child at the joint's own place is passed through.
    fn segments(&self, joint: usize) -> Vec<Segment> {
        let (mut segments, mut open) = (Vec::new(), vec![joint]);
        while let Some(at) = open.pop() {
            for &child in &self.skeleton.children[at] {
                let (start, end) = (self.origin(at), self.origin(child));
                let member = self.carrier[child] == Some(joint);
                let apart = start.distance(end) > COINCIDENT * self.size;
                if apart {
                    segments.push(Segment {
                        start,
                        end,
                        child: (!member).then_some(child),
                        first: start.distance(self.origin(joint)) <= COINCIDENT * self.size,
                        open: false,
                    });
                }
                if member || !apart {
                    open.push(child);
                }
            }
        }
        segments
    }

    /// Finds the ends where edges of the mesh leave the part.
    fn open_ends(&self, bone: &mut Bone, own: &[u32]) {
        let mut across = vec![false; self.skeleton.joints.len()];
        for &v in own {
            for &u in self.mesh.one_ring.row(v as usize) {
                match self.part[u as usize] {
                    Some(other) if other != bone.joint => across[other] = true,
                    _ => {}
                }
            }
        }
        for other in (0..across.len()).filter(|&j| across[j]) {
            let mut at = Some(other);
            let mut found = false;
            while let (Some(joint), false) = (at, found) {
                for s in bone.segments.iter_mut().filter(|s| s.child == Some(joint)) {
                    s.open = true;
                    found = true;
                }
                at = self.skeleton.joints[joint].parent;
            }
            bone.open |= !found;
        }
    }

    /// Drops segments that no vertex is near, draws closed ends back into the part and gives a leaf a segment of its own.
    fn fit_to_part(&self, bone: &mut Bone, own: &[u32]) {
        let points: Vec<DVec3> = own
            .iter()
            .map(|&v| self.mesh.positions[v as usize].as_dvec3())
            .collect();
        let mut near = vec![Vec::new(); bone.segments.len()];
        if !bone.segments.is_empty() {
            for &x in &points {
                near[bone.foot(x).segment].push(x);
            }
        }
        for (s, near) in bone.segments.iter_mut().zip(&near) {
            if s.open || s.child.is_none() && !near.is_empty() {
                // An open end is a joint; an inner one belongs to the part.
                continue;
            }
            let length = s.start.distance(s.end);
            let reach = reach(s.start, (s.end - s.start) / length, near).min(length);
            s.end = s.start + reach / length * (s.end - s.start);
        }
        let least = COINCIDENT * self.size;
        let mut row = 0;
        bone.segments.retain(|s| {
            row += 1;
            s.open || !near[row - 1].is_empty() && s.start.distance(s.end) > least
        });
        if bone.segments.is_empty() {
            bone.segments.push(self.leaf(bone.joint, &points));
        }
    }

    /// The segment of a joint without children: towards the middle of its part, ending inside.
    fn leaf(&self, joint: usize, points: &[DVec3]) -> Segment {
        let start = self.origin(joint);
        let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64 - start;
        let far = points.iter().map(|x| x.distance(start)).fold(0.0, f64::max);
        let from_parent = self.skeleton.joints[joint]
            .parent
            .map_or(DVec3::ZERO, |p| start - self.origin(p));
        let axis = if middle.length() > 0.1 * far {
            middle
        } else {
            from_parent
        };
        let axis = axis.try_normalize().unwrap_or(DVec3::Y);
        let length = reach(start, axis, points).max(2.0 * COINCIDENT * self.size);
        Segment {
            start,
            end: start + length * axis,
            child: None,
            first: true,
            open: false,
        }
    }

    /// Direction out of the part at its joint: against its segments, or towards the parent where these cancel.
    fn outward(&self, bone: &Bone) -> DVec3 {
        let along: Vec<DVec3> = bone
            .segments
            .iter()
            .filter(|s| s.first)
            .map(|s| (s.end - s.start).normalize_or_zero())
            .collect();
        let mean = along.iter().sum::<DVec3>() / along.len().max(1) as f64;
        let to_parent = self.skeleton.joints[bone.joint]
            .parent
            .map_or(DVec3::ZERO, |p| self.origin(p) - self.origin(bone.joint));
        if mean.length() > 0.5 || to_parent.length() <= COINCIDENT * self.size {
            -mean.normalize_or(DVec3::NEG_Y)
        } else {
            to_parent.normalize()
        }
    }
}

/// How far a segment that ends inside a closed part goes along a unit `axis`: to the far end less the part's usual half width.
fn reach(start: DVec3, axis: DVec3, points: &[DVec3]) -> f64 {
    let far = points
        .iter()
        .map(|x| (x - start).dot(axis))
        .fold(0.0, f64::max);
    let mut widths: Vec<f64> = points
        .iter()
        .map(|x| (x - start).reject_from_normalized(axis).length())
        .collect();
    widths.sort_by(f64::total_cmp);
    let width = widths.get(widths.len() / 2).copied().unwrap_or(0.0);
    (far - width).max(0.5 * far)
}
