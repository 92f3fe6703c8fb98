//! Skins to joints: one list keyed by node, bound in the space of the file's first skin.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat4, Mat4};
use gltf::json::accessor::Type;

use super::{
    accessor::{Accessor, Format},
    document::Document,
    fault::{Checked, Fault, refuse},
    graph::{Graph, affine},
    names::Names,
};
use crate::asset::{Joint, Node};

/// What the skins of a file come to.
pub(super) struct Skeleton {
    /// Joints and their ancestors.
    pub(super) nodes: Vec<Node>,
    /// Row in `nodes` of each node of the file, where it has one.
    pub(super) row: Vec<Option<usize>>,
    pub(super) joints: Vec<Joint>,
    /// By row of the file; `None` where no mesh uses the skin.
    pub(super) skins: Vec<Option<Skin>>,
}

/// How a skin's own numbering and space relate to the skeleton's.
pub(super) struct Skin {
    /// Rows of joints.
    pub(super) joints: Vec<u16>,
    /// Bind space of the skin → rest space; `None` is the identity.
    pub(super) carry: Option<DMat4>,
}

/// Inverse bind matrices of a skin and the nodes they belong to.
struct Binding {
    skin: usize,
    nodes: Vec<usize>,
    matrices: Vec<Mat4>,
}

impl Skeleton {
    /// Merges the skins `used`, rows of the file.
    pub(super) fn new(
        document: &Document,
        graph: &Graph,
        used: &BTreeSet<usize>,
        warnings: &mut Vec<String>,
    ) -> Checked<Self> {
        // All are read, so that a broken skin is refused whether a mesh uses it or not.
        let all = 0..document.root.skins.len();
        let all = all.map(|skin| Binding::read(document, skin));
        let mut bindings = all.collect::<Checked<Vec<_>>>()?;
        bindings.retain(|binding| used.contains(&binding.skin));
        let mut bound = BTreeMap::new();
        let mut carry = Vec::new();
        for binding in &bindings {
            carry.push(binding.merge(document, graph, &mut bound, warnings)?);
        }
        if bound.len() > usize::from(u16::MAX) {
            return refuse("/skins", format!("{} joints are too many", bound.len()));
        }
        let (nodes, row) = keep_nodes(document, graph, &bound);
        let joints = joints(graph, &nodes, &row, &bound);
        let mut joint_of_row = vec![0; nodes.len()];
        for (joint, entry) in joints.iter().enumerate() {
            joint_of_row[entry.node] = joint as u16;
        }
        let mut skins: Vec<_> = document.root.skins.iter().map(|_| None).collect();
        for (binding, carry) in bindings.into_iter().zip(carry) {
            let rows = binding.nodes.iter().filter_map(|&node| row[node]);
            let joints = rows.map(|row| joint_of_row[row]).collect();
            skins[binding.skin] = Some(Skin { joints, carry });
        }
        Ok(Self {
            nodes,
            row,
            joints,
            skins,
        })
    }
}

impl Binding {
    fn read(document: &Document, skin: usize) -> Checked<Self> {
        let raw = &document.root.skins[skin];
        let nodes: Vec<usize> = raw.joints.iter().map(|node| node.value()).collect();
        let matrices = match raw.inverse_bind_matrices {
            None => vec![Mat4::IDENTITY; nodes.len()],
            Some(accessor) => {
                let accessor = Accessor::new(document, accessor.value())?
                    .expect(&[Format::float(Type::Mat4)], "inverse bind matrices")?;
                let element = format!("/skins/{skin}/inverseBindMatrices");
                if accessor.count < nodes.len() {
                    let (count, joints) = (accessor.count, nodes.len());
                    return refuse(element, format!("{count} matrices for {joints} joints"));
                }
                let matrices = accessor.rows::<16>()?;
                let check = |(row, &node): (usize, &usize)| {
                    let matrix = Mat4::from_cols_array(&matrices[row]);
                    let name = node_name(document, node);
                    check_matrix(&matrix)
                        .map_err(|reason| Fault::new(&element, format!("joint {name}: {reason}")))
                };
                nodes
                    .iter()
                    .enumerate()
                    .map(check)
                    .collect::<Checked<_>>()?
            }
        };
        Ok(Self {
            skin,
            nodes,
            matrices,
        })
    }

    /// Adds what this skin binds to `bound` (node → rest to joint space); returns its bind space → rest space.
    fn merge(
        &self,
        document: &Document,
        graph: &Graph,
        bound: &mut BTreeMap<usize, Mat4>,
        warnings: &mut Vec<String>,
    ) -> Checked<Option<DMat4>> {
        let carry = self.carry(document, graph, bound, warnings);
        let back = carry.map(|carry| carry.inverse());
        let mut own = BTreeMap::new();
        for (&node, &matrix) in self.nodes.iter().zip(&self.matrices) {
            let name = node_name(document, node);
            if let Some(other) = own.insert(node, matrix) {
                if other != matrix {
                    let reason = format!("joint {name} repeats with another inverse bind matrix");
                    return refuse(format!("/skins/{}/joints", self.skin), reason);
                }
                warnings.push(format!("skin {} lists joint {name} twice", self.skin));
            }
            let moved = back.map_or(matrix, |back| (matrix.as_dmat4() * back).as_mat4());
            bound.entry(node).or_insert(moved);
        }
        Ok(carry)
    }

    /// Bind space of this skin → rest space.
    ///
    /// A vertex v of this skin and its image r in rest space must agree under a shared joint: IBM_rest r = IBM v.
    /// Without a shared joint both skins are taken to be bound in the pose that the file's nodes show.
    fn carry(
        &self,
        document: &Document,
        graph: &Graph,
        bound: &BTreeMap<usize, Mat4>,
        warnings: &mut Vec<String>,
    ) -> Option<DMat4> {
        let (&first, &rest) = bound.iter().next()?;
        let pairs = self.nodes.iter().zip(&self.matrices);
        let shared: Vec<_> = pairs
            .filter_map(|(&node, own)| bound.get(&node).map(|rest| (node, rest, own)))
            .collect();
        if !shared.is_empty() && shared.iter().all(|(_, rest, own)| rest == own) {
            return None;
        }
        let carry = match shared[..] {
            [(_, rest, own), ..] => rest.as_dmat4().inverse() * own.as_dmat4(),
            [] => {
                let world = graph.world();
                let scene_to_rest = (world[first] * rest.as_dmat4()).inverse();
                scene_to_rest * world[self.nodes[0]] * self.matrices[0].as_dmat4()
            }
        };
        if !carry.is_finite() || carry.determinant() == 0.0 {
            let skin = self.skin;
            warnings.push(format!(
                "skin {skin} cannot be carried into the first skin's space"
            ));
            return None;
        }
        let differs = |(_, rest, own): &(usize, &Mat4, &Mat4)| {
            let other = rest.as_dmat4().inverse() * own.as_dmat4();
            !nearly(&other, &carry, 1e-3)
        };
        if let Some((node, ..)) = shared.iter().find(|pair| differs(pair)) {
            let (name, skin) = (node_name(document, *node), self.skin);
            warnings.push(format!(
                "skin {skin} binds joint {name} otherwise than an earlier skin"
            ));
        }
        (!nearly(&carry, &DMat4::IDENTITY, 1e-6)).then_some(carry)
    }
}

/// Equality of every element up to a share of the largest.
fn nearly(a: &DMat4, b: &DMat4, tolerance: f64) -> bool {
    let largest = |m: &DMat4| {
        m.to_cols_array()
            .iter()
            .fold(0.0_f64, |x, y| x.max(y.abs()))
    };
    a.abs_diff_eq(*b, tolerance * largest(a).max(largest(b)))
}

/// Invertible, affine: volume of the unit cube's image against its edges' lengths.
fn check_matrix(matrix: &Mat4) -> Result<Mat4, &'static str> {
    let affine = affine(matrix).ok_or("the last row of its inverse bind matrix is not 0 0 0 1")?;
    let m = affine.as_dmat4();
    let (x, y, z) = (
        m.x_axis.truncate(),
        m.y_axis.truncate(),
        m.z_axis.truncate(),
    );
    let volume = x.dot(y.cross(z)).abs();
    let edges = x.length() * y.length() * z.length();
    if edges < 1e-30 || volume < 1e-6 * edges || !m.inverse().as_mat4().is_finite() {
        return Err("its inverse bind matrix is singular");
    }
    Ok(affine)
}

fn node_name(document: &Document, node: usize) -> String {
    let name = document.root.nodes[node].name.as_deref();
    name.filter(|name| !name.is_empty())
        .map_or_else(|| format!("/nodes/{node}"), |name| format!("{name:?}"))
}

/// Joints and their ancestors, in order, and the row of each node of the file.
fn keep_nodes(
    document: &Document,
    graph: &Graph,
    bound: &BTreeMap<usize, Mat4>,
) -> (Vec<Node>, Vec<Option<usize>>) {
    let mut keep = vec![false; graph.order.len()];
    for &node in graph.order.iter().rev() {
        keep[node] |= bound.contains_key(&node);
        if let (true, Some(parent)) = (keep[node], graph.parent[node]) {
            keep[parent] = true;
        }
    }
    let mut row = vec![None; graph.order.len()];
    let mut nodes: Vec<Node> = Vec::new();
    let mut names = Names::default();
    let mut joints = 0;
    for &node in graph.order.iter().filter(|&&node| keep[node]) {
        let is_joint = bound.contains_key(&node);
        let fallback = || match is_joint {
            true => format!("joint_{joints}"),
            false => format!("node_{}", nodes.len()),
        };
        let name = names.unique(document.root.nodes[node].name.as_deref(), fallback);
        joints += usize::from(is_joint);
        row[node] = Some(nodes.len());
        let local = graph.local[node];
        nodes.push(Node {
            name,
            parent: graph.parent[node].and_then(|parent| row[parent]),
            translation: local.translation,
            rotation: local.rotation,
            scale: local.scale,
            matrix: local.matrix,
        });
    }
    (nodes, row)
}

fn joints(
    graph: &Graph,
    nodes: &[Node],
    row: &[Option<usize>],
    bound: &BTreeMap<usize, Mat4>,
) -> Vec<Joint> {
    let mut joints: Vec<Joint> = Vec::with_capacity(bound.len());
    // The joint at or above each kept node.
    let mut nearest: Vec<Option<usize>> = vec![None; nodes.len()];
    for &node in &graph.order {
        let Some(row) = row[node] else { continue };
        let parent = nodes[row].parent.and_then(|parent| nearest[parent]);
        nearest[row] = parent;
        if let Some(&inverse_bind) = bound.get(&node) {
            nearest[row] = Some(joints.len());
            joints.push(Joint {
                name: nodes[row].name.clone(),
                node: row,
                parent,
                inverse_bind,
            });
        }
    }
    joints
}
