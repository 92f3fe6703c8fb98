//! From a partitioned mesh to one field a part (2013, section 4.1).

use rayon::prelude::*;

use super::{Field, bone::Parts, surface::Surface};
use crate::{
    Error, Result,
    mesh::{Mesh, TriangleGrid},
    rig::Skeleton,
};

/// Fewest vertices of a part that has a field of its own.
const FEWEST_VERTICES: usize = 8;

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
    let triangles = TriangleGrid::new(mesh);
    let surfaces: Vec<Option<Surface>> = (0..own.len())
        .into_par_iter()
        .map(|joint| {
            (!own[joint].is_empty()).then(|| Surface::new(&parts, &triangles, joint, &own[joint]))
        })
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
