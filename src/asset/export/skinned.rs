//! A rigged character as GLB: what [`load`](crate::asset::load) reads, written back.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::glb::{Builder, Shape, Use, materials};
use crate::{
    Error, Result,
    asset::{Channel, Clip, Influence, Interpolation, Joint, Model, Node, Primitive, Property},
};

/// Writes a rigged character with its clips; reading it gives the same model but for path, extensions and warnings.
///
/// # Errors
/// [`Error::Argument`] where the model is empty or its rows do not fit together; [`Error::Asset`] where the file would
/// pass 4 GiB; [`Error::File`] where it cannot be written.
pub fn write_glb_skinned(path: &Path, model: &Model) -> Result<()> {
    check(model)?;
    let mut builder = Builder::default();
    let mut nodes: Vec<Value> = model.nodes.iter().map(node).collect();
    for (row, children) in children(&model.nodes).into_iter().enumerate() {
        // glTF forbids an empty list.
        if !children.is_empty() {
            nodes[row]["children"] = children.into();
        }
    }
    let roots = model.nodes.iter().enumerate();
    let roots = roots.filter(|(_, node)| node.parent.is_none());
    let mut roots: Vec<usize> = roots.map(|(row, _)| row).collect();
    let meshes = meshes(&mut builder, model);
    for (mesh, entry) in meshes.iter().enumerate() {
        roots.push(nodes.len());
        nodes.push(json!({ "name": entry["name"], "mesh": mesh, "skin": 0 }));
    }
    let mut root = Map::new();
    root.insert("scene".into(), 0.into());
    root.insert("scenes".into(), json!([{ "nodes": roots }]));
    root.insert("nodes".into(), nodes.into());
    root.insert("meshes".into(), meshes.into());
    root.insert("materials".into(), materials(&model.primitives));
    root.insert("skins".into(), json!([skin(&mut builder, &model.joints)]));
    let clips = model.clips.iter().map(|clip| animation(&mut builder, clip));
    let clips: Vec<Value> = clips.collect();
    if !clips.is_empty() {
        root.insert("animations".into(), clips.into());
    }
    builder.write(path, root)
}

fn check(model: &Model) -> Result<()> {
    let count = model.positions.len();
    let fail = |argument, reason: &str| Err(Error::argument(argument, reason));
    if model.primitives.is_empty() || model.joints.is_empty() {
        return fail("model", "no primitives or no joints");
    }
    if model.normals.len() != count || model.influences.len() != count {
        return fail(
            "model",
            "positions, normals and influences differ in length",
        );
    }
    let empty = |p: &Primitive| p.vertices.is_empty() || p.triangles.is_empty();
    let outside = |p: &Primitive| {
        let triangles = model.triangles.get(p.triangles.clone());
        let inside = |row: &u32| p.vertices.contains(&(*row as usize));
        p.vertices.end > count || !triangles.is_some_and(|t| t.iter().flatten().all(inside))
    };
    if model.primitives.iter().any(|p| empty(p) || outside(p)) {
        return fail("primitives", "one is empty or leaves its rows");
    }
    let (joints, nodes) = (model.joints.len(), model.nodes.len());
    let mut influences = model.influences.iter().flatten();
    if influences.any(|influence| usize::from(influence.joint) >= joints) {
        return fail("influences", "a joint that does not exist");
    }
    let mut used = model.joints.iter().map(|joint| joint.node);
    let mut driven = model.clips.iter().flat_map(|clip| &clip.channels);
    if used.any(|node| node >= nodes) || driven.any(|channel| channel.node >= nodes) {
        return fail("nodes", "a node that does not exist");
    }
    let mut driven = model.clips.iter().flat_map(|clip| &clip.channels);
    if driven.any(|c| c.times.is_empty() || c.values.len() != values(c)) {
        return fail(
            "clips",
            "a channel without keys, or with a wrong number of values",
        );
    }
    let tree = model.nodes.iter().enumerate();
    if { tree }.any(|(row, node)| node.parent.is_some_and(|parent| parent >= row)) {
        return fail("nodes", "a parent after its child");
    }
    Ok(())
}

/// Number of floats that a channel's keys come to.
fn values(channel: &Channel) -> usize {
    let components = match channel.property {
        Property::Rotation => 4,
        Property::Translation | Property::Scale => 3,
    };
    let each = match channel.interpolation {
        Interpolation::CubicSpline => 3,
        Interpolation::Step | Interpolation::Linear => 1,
    };
    components * each * channel.times.len()
}

fn children(nodes: &[Node]) -> Vec<Vec<usize>> {
    let mut children = vec![Vec::new(); nodes.len()];
    for (row, node) in nodes.iter().enumerate() {
        if let Some(parent) = node.parent {
            children[parent].push(row);
        }
    }
    children
}

fn node(node: &Node) -> Value {
    let mut entry = json!({ "name": node.name });
    if let Some(matrix) = node.matrix {
        entry["matrix"] = json!(matrix.to_cols_array());
    } else {
        entry["translation"] = json!(node.translation.to_array());
        entry["rotation"] = json!(node.rotation.to_array());
        entry["scale"] = json!(node.scale.to_array());
    }
    entry
}

/// Primitives `name/0`, `name/1`, … that follow each other are one mesh.
fn meshes(builder: &mut Builder, model: &Model) -> Vec<Value> {
    let mut meshes: Vec<(String, Vec<Value>)> = Vec::new();
    for (row, primitive) in model.primitives.iter().enumerate() {
        let (name, number) = match primitive.name.rsplit_once('/') {
            Some((name, number)) => (name, number.parse().unwrap_or(0)),
            None => (primitive.name.as_str(), 0),
        };
        let entry = build_primitive(builder, model, row, primitive);
        match meshes.last_mut() {
            Some((last, entries)) if last == name && entries.len() == number => entries.push(entry),
            _ => meshes.push((name.to_owned(), vec![entry])),
        }
    }
    let value =
        |(name, primitives)| json!({ "name": name, "primitives": Value::Array(primitives) });
    meshes.into_iter().map(value).collect()
}

fn build_primitive(
    builder: &mut Builder,
    model: &Model,
    row: usize,
    primitive: &Primitive,
) -> Value {
    let range = primitive.vertices.clone();
    let mut attributes = json!({
        "POSITION": builder.positions(&model.positions[range.clone()]),
        "NORMAL": builder.vectors(&model.normals[range.clone()]),
    });
    let influences = &model.influences[range.clone()];
    let width = influences.iter().map(Vec::len).max().unwrap_or(0);
    for set in 0..width.div_ceil(4) {
        let (joints, weights) = slots(influences, 4 * set);
        let joints = if joints.iter().all(|&joint| joint <= 0xFF) {
            let joints: Vec<u8> = joints.iter().map(|&joint| joint as u8).collect();
            builder.array(Shape::Vec4, Use::Vertices, &joints)
        } else {
            builder.array(Shape::Vec4, Use::Vertices, &joints)
        };
        attributes[format!("JOINTS_{set}")] = joints.into();
        attributes[format!("WEIGHTS_{set}")] =
            builder.array(Shape::Vec4, Use::Vertices, &weights).into();
    }
    let triangles = &model.triangles[primitive.triangles.clone()];
    json!({
        "attributes": attributes,
        "indices": builder.triangles(triangles, range.start as u32),
        "material": row,
    })
}

/// Four influences a vertex from the `first` on, padded with weight 0.
fn slots(influences: &[Vec<Influence>], first: usize) -> (Vec<u16>, Vec<f32>) {
    let none = Influence {
        joint: 0,
        weight: 0.0,
    };
    let four = influences
        .iter()
        .flat_map(|list| (first..first + 4).map(|slot| list.get(slot).copied().unwrap_or(none)));
    four.map(|influence| (influence.joint, influence.weight))
        .unzip()
}

fn skin(builder: &mut Builder, joints: &[Joint]) -> Value {
    let matrices = joints
        .iter()
        .flat_map(|joint| joint.inverse_bind.to_cols_array());
    let matrices: Vec<f32> = matrices.collect();
    let nodes: Vec<usize> = joints.iter().map(|joint| joint.node).collect();
    json!({
        "joints": nodes,
        "inverseBindMatrices": builder.array(Shape::Mat4, Use::Other, &matrices),
    })
}

fn animation(builder: &mut Builder, clip: &Clip) -> Value {
    let (mut samplers, mut channels) = (Vec::new(), Vec::new());
    for channel in &clip.channels {
        channels.push(json!({
            "sampler": samplers.len(),
            "target": { "node": channel.node, "path": path(channel.property) },
        }));
        samplers.push(sampler(builder, channel));
    }
    json!({ "name": clip.name, "samplers": samplers, "channels": channels })
}

fn sampler(builder: &mut Builder, channel: &Channel) -> Value {
    let shape = match channel.property {
        Property::Rotation => Shape::Vec4,
        Property::Translation | Property::Scale => Shape::Vec3,
    };
    let interpolation = match channel.interpolation {
        Interpolation::Step => "STEP",
        Interpolation::Linear => "LINEAR",
        Interpolation::CubicSpline => "CUBICSPLINE",
    };
    json!({
        "input": builder.times(&channel.times),
        "output": builder.array(shape, Use::Other, &channel.values),
        "interpolation": interpolation,
    })
}

fn path(property: Property) -> &'static str {
    match property {
        Property::Translation => "translation",
        Property::Rotation => "rotation",
        Property::Scale => "scale",
    }
}
