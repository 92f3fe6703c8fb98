//! The node tree: each node at most one parent, no loops, parents before children.

use std::{cell::OnceCell, cmp::Reverse, collections::BinaryHeap};

use glam::{DMat4, DQuat, Mat4, Quat, Vec3};
use gltf::json;

use super::{
    document::Document,
    fault::{Checked, refuse},
};

/// A rotation may be off unit length by rounding; by more than this it is wrong.
const UNIT_TOLERANCE: f32 = 0.05;

/// The tree of all nodes of a file.
pub(super) struct Graph {
    /// Parent of each node.
    pub(super) parent: Vec<Option<usize>>,
    /// All nodes, parents before children, else in the file's order.
    pub(super) order: Vec<usize>,
    /// Own transform of each node.
    pub(super) local: Vec<Local>,
    world: OnceCell<Vec<DMat4>>,
}

/// Translation, rotation and scale, or a matrix instead.
#[derive(Clone, Copy)]
pub(super) struct Local {
    pub(super) translation: Vec3,
    pub(super) rotation: Quat,
    pub(super) scale: Vec3,
    pub(super) matrix: Option<Mat4>,
}

impl Local {
    fn matrix(&self) -> DMat4 {
        match self.matrix {
            Some(matrix) => matrix.as_dmat4(),
            None => DMat4::from_scale_rotation_translation(
                self.scale.as_dvec3(),
                DQuat::from_xyzw(
                    self.rotation.x.into(),
                    self.rotation.y.into(),
                    self.rotation.z.into(),
                    self.rotation.w.into(),
                ),
                self.translation.as_dvec3(),
            ),
        }
    }
}

impl Graph {
    /// Checks and orders the nodes of a file.
    pub(super) fn new(document: &Document) -> Checked<Self> {
        let nodes = &document.root.nodes;
        let parent = parents(nodes)?;
        let order = order(nodes, &parent)?;
        let local = (0..nodes.len()).map(|row| local(&nodes[row], row));
        let local = local.collect::<Checked<_>>()?;
        Ok(Self {
            parent,
            order,
            local,
            world: OnceCell::new(),
        })
    }

    /// Node → scene, each node as the file poses it.
    pub(super) fn world(&self) -> &[DMat4] {
        self.world.get_or_init(|| {
            let mut world = vec![DMat4::IDENTITY; self.order.len()];
            for &node in &self.order {
                let above = self.parent[node].map_or(DMat4::IDENTITY, |parent| world[parent]);
                world[node] = above * self.local[node].matrix();
            }
            world
        })
    }
}

fn children(node: &json::Node) -> impl Iterator<Item = usize> {
    node.children.iter().flatten().map(|child| child.value())
}

fn parents(nodes: &[json::Node]) -> Checked<Vec<Option<usize>>> {
    let mut parent = vec![None; nodes.len()];
    for (row, node) in nodes.iter().enumerate() {
        for (number, child) in children(node).enumerate() {
            if let Some(other) = parent[child].replace(row) {
                let element = format!("/nodes/{row}/children/{number}");
                return refuse(
                    element,
                    format!("node {child} is a child of node {other} already"),
                );
            }
        }
    }
    Ok(parent)
}

/// Kahn's algorithm, least row first.
fn order(nodes: &[json::Node], parent: &[Option<usize>]) -> Checked<Vec<usize>> {
    let roots = (0..nodes.len()).filter(|&row| parent[row].is_none());
    let mut ready: BinaryHeap<Reverse<usize>> = roots.map(Reverse).collect();
    let mut order = Vec::with_capacity(nodes.len());
    let mut done = vec![false; nodes.len()];
    while let Some(Reverse(row)) = ready.pop() {
        done[row] = true;
        order.push(row);
        ready.extend(children(&nodes[row]).map(Reverse));
    }
    match done.iter().position(|done| !done) {
        Some(row) => refuse(format!("/nodes/{row}"), "its ancestors form a loop"),
        None => Ok(order),
    }
}

fn local(node: &json::Node, row: usize) -> Checked<Local> {
    let element = |property| format!("/nodes/{row}/{property}");
    let rotation = Quat::from_array(node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |q| q.0));
    let Some(rotation) = unit(rotation) else {
        return refuse(element("rotation"), "not a unit quaternion");
    };
    let given = node.matrix.map(|columns| Mat4::from_cols_array(&columns));
    let others = node.translation.is_some() || node.rotation.is_some() || node.scale.is_some();
    if given.is_some() && others {
        return refuse(element("matrix"), "beside translation, rotation or scale");
    }
    let matrix = given.as_ref().and_then(affine);
    if given.is_some() && matrix.is_none() {
        return refuse(element("matrix"), "its last row is not 0 0 0 1");
    }
    Ok(Local {
        translation: Vec3::from_array(node.translation.unwrap_or_default()),
        rotation,
        scale: Vec3::from_array(node.scale.unwrap_or([1.0; 3])),
        matrix,
    })
}

/// The rotation normalised, bit for bit itself where it is unit up to rounding; `None` where it is no rotation.
pub(super) fn unit(rotation: Quat) -> Option<Quat> {
    let off = (rotation.length() - 1.0).abs();
    if off <= 1e-6 {
        return Some(rotation);
    }
    (off <= UNIT_TOLERANCE).then(|| rotation.normalize())
}

/// The matrix with its last row exactly 0 0 0 1; `None` where that is not its last row up to rounding.
pub(super) fn affine(matrix: &Mat4) -> Option<Mat4> {
    let mut affine = *matrix;
    for (column, last) in [0.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
        affine.col_mut(column).w = last;
    }
    affine.abs_diff_eq(*matrix, 1e-5).then_some(affine)
}
