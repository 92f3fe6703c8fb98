//! A character from arrays in memory, without a file.

use glam::{Mat4, Vec3};

use super::{
    Influence, Joint, Model, Node, Primitive,
    import::{
        ROW_LIMIT,
        geometry::unit_normals,
        weights::{Mended, add, finish},
    },
};
use crate::{Error, Result};

/// What a character is made of, all in **rest** space.
#[derive(Clone, Debug, Default)]
pub struct Arrays {
    /// Rest positions.
    pub positions: Vec<Vec3>,
    /// Normals, one a position; computed from the triangles where this is empty or a normal has no direction.
    pub normals: Vec<Vec3>,
    /// Triangles as rows of `positions`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Joints, parents before children.
    pub joints: Vec<ArrayJoint>,
    /// Weights of each position in any order, a joint more than once allowed; empty where there are none.
    pub influences: Vec<Vec<Influence>>,
    /// How rigidly each position follows its joint in tracking, from 0 (free) to 1; empty for 0.
    pub rigid: Vec<f32>,
}

/// A joint of [`Arrays`].
#[derive(Clone, Debug)]
pub struct ArrayJoint {
    /// Unique name.
    pub name: String,
    /// Row of the parent, smaller than the joint's own.
    pub parent: Option<usize>,
    /// Joint space → rest space.
    pub bind: Mat4,
}

impl Model {
    /// A character without a file and without clips. Weights are scaled to sum 1 as those of a file; rest and scene space
    /// are the same.
    ///
    /// # Errors
    /// [`Error::Argument`] naming the array and the row that cannot be used, [`Error::Joint`] naming the joint.
    pub fn from_arrays(arrays: Arrays) -> Result<Self> {
        check_mesh(&arrays)?;
        let mut model = Self {
            joints: joints(&arrays.joints)?,
            nodes: nodes(&arrays.joints),
            ..Self::default()
        };
        let given = (!arrays.normals.is_empty()).then_some(arrays.normals);
        let had_normals = given.is_some();
        let (normals, computed) = unit_normals(given, &arrays.positions, &arrays.triangles);
        if had_normals && computed > 0 {
            let what = format!("{computed} normals are 0 and were computed");
            model.warnings.push(what);
        }
        model.normals = normals;
        let mut mended = Mended::default();
        for (row, list) in arrays.influences.iter().enumerate() {
            let list = influences(row, list, arrays.joints.len(), &mut mended)?;
            model.influences.push(list);
        }
        model.warnings.extend(mended.warnings());
        model.primitives = vec![Primitive {
            name: "mesh/0".into(),
            vertices: 0..arrays.positions.len(),
            triangles: 0..arrays.triangles.len(),
            base_color: [1.0; 4],
        }];
        model.rigid = arrays.rigid;
        model.positions = arrays.positions;
        model.triangles = arrays.triangles;
        Ok(model)
    }
}

fn check_mesh(arrays: &Arrays) -> Result<()> {
    let rows = arrays.positions.len();
    for (name, count) in [("positions", rows), ("triangles", arrays.triangles.len())] {
        if count == 0 || count > ROW_LIMIT {
            let reason = format!("{count} given; 1 to {ROW_LIMIT} can be used");
            return Err(Error::argument(name, reason));
        }
    }
    one_a_vertex("normals", arrays.normals.len(), rows)?;
    one_a_vertex("influences", arrays.influences.len(), rows)?;
    one_a_vertex("rigid", arrays.rigid.len(), rows)?;
    let outside = |x: &f32| !(0.0..=1.0).contains(x);
    if let Some(bad) = arrays.rigid.iter().position(outside) {
        let reason = format!("row {bad} is {}, not in 0 to 1", arrays.rigid[bad]);
        return Err(Error::argument("rigid", reason));
    }
    finite("positions", &arrays.positions)?;
    finite("normals", &arrays.normals)?;
    let outside = |t: &[u32; 3]| t.iter().any(|v| *v as usize >= rows);
    if let Some(bad) = arrays.triangles.iter().position(outside) {
        let reason = format!(
            "triangle {bad} is {:?}, there are {rows} vertices",
            arrays.triangles[bad]
        );
        return Err(Error::argument("triangles", reason));
    }
    Ok(())
}

fn one_a_vertex(name: &str, count: usize, rows: usize) -> Result<()> {
    if count == 0 || count == rows {
        return Ok(());
    }
    let reason = format!("{count} given for {rows} positions");
    Err(Error::argument(name, reason))
}

fn finite(name: &str, rows: &[Vec3]) -> Result<()> {
    match rows.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(bad) => Err(Error::argument(name, format!("row {bad} is not finite"))),
    }
}

/// Joints as a file has them; names and parents are checked with the skeleton.
fn joints(given: &[ArrayJoint]) -> Result<Vec<Joint>> {
    let joint = |(node, joint): (usize, &ArrayJoint)| {
        let inverse_bind = joint.bind.inverse();
        let bottom = joint.bind.row(3);
        let refuse = |reason: &str| {
            Err(Error::Joint {
                joint: joint.name.clone(),
                reason: reason.into(),
            })
        };
        if joint.parent.is_some_and(|parent| parent >= node) {
            return refuse("its parent does not precede it");
        }
        if !joint.bind.is_finite() || !inverse_bind.is_finite() {
            return refuse("its bind matrix is not finite or has no inverse");
        }
        if bottom.truncate().abs().max_element() > 1e-4 || (bottom.w - 1.0).abs() > 1e-4 {
            return refuse("the last row of its bind matrix is not 0 0 0 1");
        }
        Ok(Joint {
            name: joint.name.clone(),
            node,
            parent: joint.parent,
            inverse_bind,
        })
    };
    given.iter().enumerate().map(joint).collect()
}

/// One node a joint, where its joint is bound; of joints that have been checked.
fn nodes(given: &[ArrayJoint]) -> Vec<Node> {
    let node = |joint: &ArrayJoint| Node {
        name: joint.name.clone(),
        parent: joint.parent,
        translation: Vec3::ZERO,
        rotation: glam::Quat::IDENTITY,
        scale: Vec3::ONE,
        matrix: Some(match joint.parent {
            Some(parent) => given[parent].bind.inverse() * joint.bind,
            None => joint.bind,
        }),
    };
    given.iter().map(node).collect()
}

/// The influences of one vertex as a file's: positive, each joint once, sum 1, greatest first.
fn influences(
    row: usize,
    given: &[Influence],
    joints: usize,
    mended: &mut Mended,
) -> Result<Vec<Influence>> {
    let refuse = |reason| {
        Err(Error::argument(
            format!("influences of vertex {row}"),
            reason,
        ))
    };
    let mut list = Vec::with_capacity(given.len());
    for influence in given {
        if usize::from(influence.joint) >= joints {
            return refuse(format!("joint {} of {joints}", influence.joint));
        }
        if !influence.weight.is_finite() || influence.weight < 0.0 {
            return refuse(format!("a weight is {}", influence.weight));
        }
        if influence.weight > 0.0 || list.is_empty() {
            add(&mut list, influence.joint, influence.weight);
        }
    }
    if !list.is_empty() {
        finish(&mut list, mended);
    }
    Ok(list)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::rig::Skeleton;

    fn triangle() -> Arrays {
        let joint = |name: &str, parent, x| ArrayJoint {
            name: name.into(),
            parent,
            bind: Mat4::from_translation(Vec3::X * x),
        };
        let influence = |joint, weight| Influence { joint, weight };
        Arrays {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: Vec::new(),
            triangles: vec![[0, 1, 2]],
            joints: vec![joint("a", None, 0.0), joint("b", Some(0), 1.0)],
            influences: vec![
                vec![influence(1, 0.25), influence(0, 0.75)],
                vec![influence(1, 1.0), influence(1, 1.0), influence(0, 0.0)],
                vec![influence(0, 0.0)],
            ],
            rigid: Vec::new(),
        }
    }

    fn refusal(change: impl FnOnce(&mut Arrays)) -> String {
        let mut arrays = triangle();
        change(&mut arrays);
        Model::from_arrays(arrays).unwrap_err().to_string()
    }

    #[test]
    fn arrays_become_a_model() {
        let model = Model::from_arrays(triangle()).unwrap();
        assert_eq!(model.normals, [Vec3::Z; 3]);
        let weights: Vec<Vec<f32>> = model
            .influences
            .iter()
            .map(|list| list.iter().map(|i| i.weight).collect())
            .collect();
        assert_eq!(weights, [vec![0.75, 0.25], vec![1.0], vec![1.0]]);
        assert_eq!(model.warnings.len(), 2, "{:?}", model.warnings);
        let skeleton = Skeleton::from_model(&model).unwrap();
        assert_eq!(skeleton.joints[1].parent, Some(0));
        let scene = crate::rig::scene_from_rest(&model);
        assert_eq!(scene, Mat4::IDENTITY);
    }

    #[test]
    fn what_cannot_be_used_is_named() {
        for (message, named) in [
            (refusal(|a| a.positions.clear()), "positions"),
            (refusal(|a| a.triangles.clear()), "triangles"),
            (refusal(|a| a.positions[1].y = f32::NAN), "positions: row 1"),
            (refusal(|a| a.normals = vec![Vec3::Z; 2]), "normals"),
            (
                refusal(|a| a.normals = vec![Vec3::INFINITY; 3]),
                "normals: row 0",
            ),
            (refusal(|a| a.triangles[0][2] = 3), "triangle 0"),
            (refusal(|a| a.joints[0].parent = Some(0)), "joint \"a\""),
            (refusal(|a| a.joints[1].bind = Mat4::ZERO), "joint \"b\""),
            (refusal(|a| a.joints[1].bind.x_axis.w = 1.0), "joint \"b\""),
            (refusal(|a| a.influences[2][0].joint = 2), "vertex 2"),
            (refusal(|a| a.influences[0][0].weight = -1.0), "vertex 0"),
            (
                refusal(|a| a.influences[0][0].weight = f32::NAN),
                "vertex 0",
            ),
            (
                refusal(|a| {
                    a.influences.pop();
                }),
                "influences",
            ),
        ] {
            assert!(message.contains(named), "{named}: {message}");
        }
    }
}
