//! Bones as segments and what can be seen of them from the skin.

use glam::DVec3;

use super::Skeleton;
use crate::mesh::{Mesh, TriangleGrid};

/// Share of the way to the skin that a leaf's bone reaches.
const LEAF_REACH: f64 = 0.9;
/// Bones within this factor of the nearest one count as equally near (Baran & Popović 2007).
const TIE: f64 = 1.0001;
/// Bones tried for visibility, nearest first.
const TRIES: usize = 8;

/// A bone in rest space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bone {
    pub(super) joint: u16,
    ends: [DVec3; 2],
}

/// The bones from joint to child; a leaf goes on in its parent's direction nearly up to the skin.
pub(super) fn bones(skeleton: &Skeleton, grid: &TriangleGrid) -> Vec<Bone> {
    let mut bones = Vec::new();
    for j in 0..skeleton.joints.len() {
        let mut segments = skeleton.segments(j);
        segments.dedup();
        let joint = j as u16;
        if segments.is_empty() {
            let ends = leaf(skeleton, grid, j);
            bones.push(Bone { joint, ends });
        }
        bones.extend(segments.iter().map(|s| Bone {
            joint,
            ends: s.map(|p| p.as_dvec3()),
        }));
    }
    bones
}

fn leaf(skeleton: &Skeleton, grid: &TriangleGrid, j: usize) -> [DVec3; 2] {
    let origin = skeleton.origin(j).as_dvec3();
    // Coincident joints give no direction: climb on.
    let ancestors =
        std::iter::successors(skeleton.joints[j].parent, |p| skeleton.joints[*p].parent);
    let direction = ancestors
        .map(|p| origin - skeleton.origin(p).as_dvec3())
        .find_map(DVec3::try_normalize);
    let reach = direction
        .and_then(|d| grid.first_hit(origin, d, f64::INFINITY, |_| true))
        .map_or(0.0, |hit| LEAF_REACH * hit.0);
    [origin, origin + direction.unwrap_or_default() * reach]
}

impl Bone {
    /// Nearest point to `p`.
    fn nearest(&self, p: DVec3) -> DVec3 {
        let [a, b] = self.ends;
        let along = b - a;
        let t = (p - a).dot(along) / along.length_squared();
        a + along * if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) }
    }
}

/// Joints whose bones are nearest to a vertex, equally near ones together, and their distance.
#[derive(Clone, Debug, Default)]
pub(super) struct Nearest {
    pub(super) joints: Vec<u16>,
    pub(super) distance: f64,
}

/// The nearest bones regardless of what lies between.
pub(super) fn nearest(mesh: &Mesh, bones: &[Bone], v: usize) -> Nearest {
    gather(&ranked(mesh, bones, v), |_| true).unwrap_or_default()
}

/// The nearest bones that the vertex sees through the inside of its component: the line to the bone's nearest point sets
/// out against the normal and meets no triangle of the component.
pub(super) fn nearest_visible(
    mesh: &Mesh,
    grid: &TriangleGrid,
    bones: &[Bone],
    v: usize,
) -> Option<Nearest> {
    let p = mesh.positions[v].as_dvec3();
    let component = mesh.components[v];
    let visible = |to: DVec3| {
        let way = to - p;
        let blocks = |t: usize| {
            let corners = mesh.triangles[t];
            mesh.components[corners[0] as usize] == component && !corners.contains(&(v as u32))
        };
        way.dot(mesh.normals[v].as_dvec3()) <= 0.0 && grid.first_hit(p, way, 1.0, blocks).is_none()
    };
    gather(&ranked(mesh, bones, v), visible)
}

/// Joints by distance: (distance, joint, nearest point), each joint once.
fn ranked(mesh: &Mesh, bones: &[Bone], v: usize) -> Vec<(f64, u16, DVec3)> {
    let p = mesh.positions[v].as_dvec3();
    let mut all: Vec<_> = bones
        .iter()
        .map(|b| {
            let to = b.nearest(p);
            (p.distance(to), b.joint, to)
        })
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut seen = std::collections::HashSet::new();
    all.retain(|x| seen.insert(x.1));
    all
}

fn gather(ranked: &[(f64, u16, DVec3)], visible: impl Fn(DVec3) -> bool) -> Option<Nearest> {
    let tried = &ranked[..ranked.len().min(TRIES)];
    let first = tried.iter().position(|x| visible(x.2))?;
    let distance = tried[first].0;
    let near = |x: &&(f64, u16, DVec3)| x.0 <= distance * TIE;
    Some(Nearest {
        joints: ranked[first..]
            .iter()
            .take_while(near)
            .filter(|x| x.1 == tried[first].1 || visible(x.2))
            .map(|x| x.1)
            .collect(),
        distance,
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use glam::Vec3;

    /// A closed box from `low` to `high`.
    pub(crate) fn cuboid(low: Vec3, high: Vec3) -> Mesh {
        let p = (0..8).map(|i| {
            let pick = Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32);
            low + pick * (high - low)
        });
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let triangles = quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect();
        Mesh::new(p.collect(), triangles)
    }

    #[test]
    fn the_leaf_reaches_nearly_to_the_skin() {
        let skeleton = crate::rig::skeleton::tests::skeleton();
        let mesh = cuboid(Vec3::new(-3.0, -1.0, -1.0), Vec3::new(4.0, 1.0, 1.0));
        let grid = TriangleGrid::new(&mesh);
        let bones = bones(&skeleton, &grid);
        assert_eq!(bones.len(), 5);
        assert!(bones[3].ends[1].distance(DVec3::new(3.8, 0.0, 0.0)) < 1e-5);
        assert!(bones[4].ends[1].distance(DVec3::new(-2.8, 0.0, 0.0)) < 1e-5);
    }

    #[test]
    fn a_bone_outside_is_near_but_not_visible() {
        let mesh = cuboid(Vec3::ZERO, Vec3::ONE);
        let grid = TriangleGrid::new(&mesh);
        let bone = |joint, x: f64| Bone {
            joint,
            ends: [DVec3::new(x, 0.05, 0.05), DVec3::new(x, 0.7, 0.7)],
        };
        let bones = [bone(0, -0.4), bone(1, 0.5), bone(2, 0.5)];
        let v = mesh.positions.iter().position(|p| *p == Vec3::ZERO);
        let v = v.unwrap_or_default();
        assert_eq!(nearest(&mesh, &bones, v).joints, [0]);
        let seen = nearest_visible(&mesh, &grid, &bones, v);
        assert_eq!(seen.map(|n| n.joints), Some(vec![1, 2]));
        assert!(nearest_visible(&mesh, &grid, &bones[..1], 7).is_none());
    }
}
