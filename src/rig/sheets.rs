//! Which vertices follow geometric skinning only: small rigid shells, and sheets too thin for a field's grid.

use std::{collections::BTreeMap, f64::consts::TAU};

use rayon::prelude::*;

use super::{Skeleton, Weights};
use crate::{
    field::{Field, GRID},
    mesh::{Mesh, TriangleGrid},
};

/// Weight from which a vertex counts as rigid.
const RIGID: f32 = 0.999;
/// Share of the vertices below which a rigid component is a small shell.
const SMALL: f64 = 0.05;

/// Flags components all of whose vertices belong to one joint (weight ≥ .999) and that are small (under 5 % of the
/// vertices) or lie within another component, such as eyes, teeth and buttons: their geometric position is right.
pub(super) fn rigid_shells(mesh: &Mesh, weights: &Weights) -> Vec<bool> {
    let mut components: Vec<Vec<usize>> = vec![Vec::new(); mesh.component_count()];
    for (v, &c) in mesh.components.iter().enumerate() {
        components[c as usize].push(v);
    }
    let small = SMALL * mesh.positions.len() as f64;
    let shells: Vec<bool> = components
        .par_iter()
        .map(|vertices| {
            let joint = weights.dominant(vertices[0]);
            let rigid = |&v: &usize| weights.dominant(v) == joint && weights.greatest(v) >= RIGID;
            vertices.iter().all(rigid)
                && ((vertices.len() as f64) < small || enclosed(mesh, vertices[0]))
        })
        .collect();
    // A character of one component has no shells, however few vertices it has.
    mesh.components
        .iter()
        .map(|&c| components.len() > 1 && shells[c as usize])
        .collect()
}

/// Whether some other component winds around a vertex (generalised winding number above one half).
fn enclosed(mesh: &Mesh, v: usize) -> bool {
    let p = mesh.positions[v].as_dvec3();
    let mut winding = vec![0.0; mesh.component_count()];
    for t in &mesh.triangles {
        let component = mesh.components[t[0] as usize];
        if component != mesh.components[v] {
            // Solid angle of a triangle: van Oosterom & Strackee 1983.
            let [a, b, c] = t.map(|u| mesh.positions[u as usize].as_dvec3() - p);
            let (x, y, z) = (a.length(), b.length(), c.length());
            let under = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
            winding[component as usize] += 2.0 * a.dot(b.cross(c)).atan2(under) / (2.0 * TAU);
        }
    }
    winding.iter().any(|w| *w > 0.5)
}

/// Flags vertices where the skin is a sheet thinner than the voxels of its part's field and the field turns round within
/// it: its grid cannot tell the sheet's two sides apart.
///
/// The thickness is the way from the vertex against its normal to the same component's other side. Where the field's
/// gradients on both sides agree, as in the two layers of a garment around a limb, each vertex has its own iso-surface
/// and nothing is wrong.
pub(super) fn thin_sheets(mesh: &Mesh, part: &[u16], fields: &[Field]) -> Vec<bool> {
    let grid = TriangleGrid::new(mesh);
    let field_of: BTreeMap<u16, &Field> = fields.iter().map(|f| (f.joint, f)).collect();
    (0..mesh.positions.len())
        .into_par_iter()
        .map(|v| {
            field_of
                .get(&part[v])
                .is_some_and(|field| is_thin(mesh, &grid, field, v))
        })
        .collect()
}

fn is_thin(mesh: &Mesh, grid: &TriangleGrid, field: &Field, v: usize) -> bool {
    let normal = mesh.normals[v];
    let along = field.bounds.axes.transpose() * normal;
    let voxel = (along * field.bounds.size).length() / (GRID - 1) as f32;
    let inward = -normal.as_dvec3();
    let other_side = |t: usize| {
        let corners = mesh.triangles[t];
        mesh.components[corners[0] as usize] == mesh.components[v]
            && !corners.contains(&(v as u32))
            && faces(mesh, corners, inward)
    };
    let origin = mesh.positions[v];
    grid.first_hit(origin.as_dvec3(), inward, f64::from(voxel), other_side)
        .is_some_and(|(thickness, _)| {
            let here = field.evaluate(origin).1;
            let there = field.evaluate(origin - normal * thickness as f32).1;
            here.dot(there) <= 0.0
        })
}

/// Whether a triangle's front looks along `direction`: a ray from inside leaves through it.
fn faces(mesh: &Mesh, corners: [u32; 3], direction: glam::DVec3) -> bool {
    let [a, b, c] = corners.map(|v| mesh.positions[v as usize].as_dvec3());
    (b - a).cross(c - a).dot(direction) > 0.0
}

/// One sentence that counts flagged vertices by joint, most first; none where nothing is flagged.
pub(super) fn warning(
    what: &str,
    flags: &[bool],
    part: &[u16],
    skeleton: &Skeleton,
) -> Option<String> {
    let mut counts: BTreeMap<u16, usize> = BTreeMap::new();
    for (flag, joint) in flags.iter().zip(part) {
        if *flag {
            *counts.entry(*joint).or_default() += 1;
        }
    }
    if counts.is_empty() {
        return None;
    }
    let mut counts: Vec<(u16, usize)> = counts.into_iter().collect();
    counts.sort_by_key(|c| std::cmp::Reverse(c.1));
    let names: Vec<String> = counts
        .iter()
        .map(|(j, n)| format!("{} {n}", skeleton.joints[usize::from(*j)].name))
        .collect();
    let total: usize = counts.iter().map(|c| c.1).sum();
    Some(format!(
        "{total} vertices {what} follow geometric skinning only ({})",
        names.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        asset::Influence,
        field::{FieldBox, Hrbf},
        rig::{bones::tests::cuboid, skeleton::tests::skeleton},
    };
    use glam::{DVec3, Mat3, Vec3};

    fn join(parts: &[Mesh]) -> Mesh {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for m in parts {
            let base = positions.len() as u32;
            positions.extend(&m.positions);
            triangles.extend(m.triangles.iter().map(|t| t.map(|v| v + base)));
        }
        Mesh::new(positions, triangles)
    }

    fn weights(n: usize, weight: impl Fn(usize) -> f32) -> Weights {
        let list = |v| {
            let (joint, weight) = (1, weight(v));
            let rest = Influence {
                joint: 0,
                weight: 1.0 - weight,
            };
            vec![Influence { joint, weight }, rest]
        };
        Weights::from_lists(&(0..n).map(list).collect::<Vec<_>>())
    }

    #[test]
    fn a_rigid_shell_inside_is_flagged_and_one_beside_is_not() {
        let mesh = join(&[
            cuboid(Vec3::ZERO, Vec3::splat(3.0)),
            cuboid(Vec3::ONE, Vec3::splat(2.0)),
            cuboid(Vec3::splat(4.0), Vec3::splat(5.0)),
        ]);
        let flags = rigid_shells(&mesh, &weights(24, |v| if v < 8 { 0.7 } else { 1.0 }));
        let wanted: Vec<bool> = (0..24).map(|v| (8..16).contains(&v)).collect();
        assert_eq!(flags, wanted);
        let soft = rigid_shells(&mesh, &weights(24, |_| 0.9));
        assert!(soft.iter().all(|f| !f));
    }

    #[test]
    fn small_rigid_shells_are_flagged_wherever_they_lie() {
        let far = |k: usize| Vec3::splat(10.0 * k as f32);
        let boxes: Vec<Mesh> = (0..25).map(|k| cuboid(far(k), far(k) + 1.0)).collect();
        let mesh = join(&boxes);
        let flags = rigid_shells(&mesh, &weights(200, |v| if v == 0 { 0.5 } else { 1.0 }));
        assert_eq!(flags.iter().filter(|f| **f).count(), 192);
    }

    /// A plate of `n` × `n` cells around the origin, `thickness` high.
    fn plate(n: u32, thickness: f32) -> Mesh {
        let mut sides = Vec::new();
        for z in [-0.5f32, 0.5] {
            let at = |i: u32| i as f32 / n as f32 * 2.0 - 1.0;
            let cell = |i: u32, j: u32| j * (n + 1) + i;
            let points = (0..(n + 1) * (n + 1))
                .map(|k| Vec3::new(at(k % (n + 1)), at(k / (n + 1)), z * thickness));
            let triangles = (0..n * n).flat_map(|k| {
                let (i, j) = (k % n, k / n);
                let q = [
                    cell(i, j),
                    cell(i + 1, j),
                    cell(i + 1, j + 1),
                    cell(i, j + 1),
                ];
                let [a, b, c, d] = if z > 0.0 { q } else { [q[3], q[2], q[1], q[0]] };
                [[a, b, c], [a, c, d]]
            });
            sides.push(Mesh::new(points.collect(), triangles.collect()));
        }
        // The two sides count as one component, as if joined at the rim.
        let mut mesh = join(&sides);
        mesh.components.fill(0);
        mesh
    }

    /// A field around the plate's middle with one centre a side, so that d ≈ |z| or d ≈ z.
    fn field(one_sided: bool) -> Field {
        let up = if one_sided { DVec3::NEG_Z } else { DVec3::Z };
        Field {
            joint: 1,
            segments: vec![[Vec3::NEG_X, Vec3::X]],
            radius: 2.0,
            bounds: FieldBox {
                origin: Vec3::splat(-1.55),
                axes: Mat3::IDENTITY,
                size: Vec3::splat(31.0 * 0.1),
            },
            // d = 3 |x - c| (β · (x - c)) summed over both centres.
            hrbf: Hrbf {
                origin: DVec3::ZERO,
                scale: 1.0,
                centers: vec![DVec3::Z, DVec3::NEG_Z],
                lambda: vec![0.0; 2],
                beta: vec![up, DVec3::NEG_Z],
            },
        }
    }

    #[test]
    fn a_sheet_is_flagged_where_it_is_thin_and_the_field_turns_round_in_it() {
        let count = |thickness, one_sided| {
            let mesh = plate(6, thickness);
            let part = vec![1; mesh.positions.len()];
            let flags = thin_sheets(&mesh, &part, &[field(one_sided)]);
            flags.iter().filter(|f| **f).count()
        };
        assert_eq!(count(0.05, false), 2 * 49);
        assert_eq!(count(0.2, false), 0, "thicker than a voxel");
        assert_eq!(count(0.05, true), 0, "the field runs through");
        let mesh = plate(6, 0.05);
        assert!(
            thin_sheets(&mesh, &[0; 98], &[field(false)])
                .iter()
                .all(|f| !f)
        );
    }

    #[test]
    fn the_warning_counts_by_joint() {
        let s = skeleton();
        let line = warning(
            "of thin sheets",
            &[true, false, true, true],
            &[1, 1, 0, 0],
            &s,
        );
        let wanted = "3 vertices of thin sheets follow geometric skinning only (root 2, elbow 1)";
        assert_eq!(line.as_deref(), Some(wanted));
        assert_eq!(warning("x", &[false], &[0], &s), None);
    }
}
