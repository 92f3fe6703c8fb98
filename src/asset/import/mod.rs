//! glTF 2.0 in: a `.glb` or `.gltf` file to a [`Model`], everything validated on the way.
//!
//! [`container`] splits the file, [`schema`] sieves its JSON so that only what dermis reads is left, [`document`] turns
//! that into the `gltf` crate's types and loads buffers, [`accessor`] reads arrays; [`graph`], [`skeleton`],
//! [`geometry`], [`weights`], [`rigid`] and [`clip`] build the model.

mod accessor;
mod clip;
mod container;
mod document;
mod fault;
pub(super) mod geometry;
mod graph;
mod morph;
mod names;
mod rigid;
mod schema;
mod skeleton;
mod spine;
mod still;
#[cfg(test)]
mod tests;
mod uri;
pub(super) mod weights;

pub use morph::load_morph;
pub use still::load_still;

use std::{collections::BTreeSet, path::Path};

use document::Document;
use fault::{Checked, refuse};
use geometry::{Attributes, Geometry};
use gltf::json::mesh;
use graph::Graph;
use skeleton::{Skeleton, Skin};
use weights::Mended;

use super::{Model, Primitive};
use crate::Result;

/// Greatest number of vertices, triangles and joints' influences of a model.
pub const ROW_LIMIT: usize = 1 << 23;

/// Reads a rigged character from a `.glb` or `.gltf` file.
///
/// All skinned meshes come in the file's order, carried into the bind space of the first skin. Morph targets, points
/// and lines, rigid meshes and nodes outside of the skeleton are left out; [`Model::warnings`] says so.
///
/// # Errors
/// [`Error::File`](crate::Error) where the file cannot be read; [`Error::Asset`](crate::Error) with a JSON pointer where its content is wrong
/// (including an extension that it requires and dermis lacks), or `/skins` where it has no skinned mesh.
pub fn load(path: &Path) -> Result<Model> {
    let document = Document::open(path)?;
    let mut model = build(&document).map_err(|fault| fault.with_path(path))?;
    model.path = path.to_owned();
    Ok(model)
}

fn build(document: &Document) -> Checked<Model> {
    accessor::check_all(document)?;
    let graph = Graph::new(document)?;
    let pairs = skinned_meshes(document);
    let used: BTreeSet<usize> = pairs.iter().map(|&(_, skin)| skin).collect();
    let mut warnings = Vec::new();
    let skeleton = Skeleton::new(document, &graph, &used, &mut warnings)?;
    let clips = clip::read(document, &skeleton.row, &mut warnings)?;
    let mut model = Model {
        clips,
        extensions: document.root.extensions_used.clone(),
        warnings,
        ..Model::default()
    };
    let mut mended = Mended::default();
    for &(mesh, skin) in &pairs {
        if let Some(skin) = &skeleton.skins[skin] {
            add_mesh(document, mesh, skin, &mut model, &mut mended)?;
        }
    }
    check_rigid(document, &pairs, &mut model)?;
    if model.triangles.is_empty() {
        return refuse("/skins", no_character(document));
    }
    if !model.rigid.is_empty() {
        model.rigid.resize(model.positions.len(), 0.0);
    }
    model.warnings.extend(mended.warnings());
    model.spines = spine::read(document, &skeleton)?;
    model.nodes = skeleton.nodes;
    model.joints = skeleton.joints;
    Ok(model)
}

/// Rows of mesh and skin that some node joins, in the order of the meshes.
fn skinned_meshes(document: &Document) -> Vec<(usize, usize)> {
    let nodes = document.root.nodes.iter();
    let pairs = nodes.filter_map(|node| Some((node.mesh?.value(), node.skin?.value())));
    let pairs: BTreeSet<_> = pairs.collect();
    pairs.into_iter().collect()
}

fn no_character(document: &Document) -> &'static str {
    if document.root.skins.is_empty() {
        "the file has no skin; dermis needs a rigged character"
    } else {
        "no node joins a mesh of triangles with a skin; dermis needs a rigged character"
    }
}

fn add_mesh(
    document: &Document,
    mesh: usize,
    skin: &Skin,
    model: &mut Model,
    mended: &mut Mended,
) -> Checked<()> {
    let raw = &document.root.meshes[mesh];
    let name = raw.name.clone().filter(|name| !name.is_empty());
    let name = name.unwrap_or_else(|| format!("mesh_{mesh}"));
    if raw.primitives.iter().any(|p| p.targets.is_some()) {
        model
            .warnings
            .push(format!("morph targets of mesh {name} are left out"));
    }
    for (number, primitive) in raw.primitives.iter().enumerate() {
        let element = format!("/meshes/{mesh}/primitives/{number}");
        let geometry = geometry::read(document, primitive, &element, &mut model.warnings)?;
        let mut geometry = match geometry {
            Ok(geometry) => geometry,
            Err(left_out) => {
                model.warnings.push(left_out);
                continue;
            }
        };
        if model.positions.len() + geometry.positions.len() > ROW_LIMIT
            || model.triangles.len() + geometry.triangles.len() > ROW_LIMIT
        {
            return refuse(element, format!("the model has more than {ROW_LIMIT} rows"));
        }
        let attributes = Attributes::new(primitive, &element);
        let count = geometry.positions.len();
        let influences = weights::read(document, &attributes, &skin.joints, count, mended)?;
        model.influences.extend(influences);
        if let Some(rigid) = rigid::read(document, &attributes, count)? {
            // Primitives before this one have none.
            model.rigid.resize(model.positions.len(), 0.0);
            model.rigid.extend(rigid);
        }
        if let Some(carry) = &skin.carry {
            geometry.carry(carry);
        }
        append(
            model,
            geometry,
            format!("{name}/{number}"),
            base_color(document, primitive),
        );
    }
    Ok(())
}

fn append(model: &mut Model, geometry: Geometry, name: String, base_color: [f32; 4]) {
    let (vertex, triangle) = (model.positions.len(), model.triangles.len());
    let offset = vertex as u32;
    model.positions.extend(geometry.positions);
    model.normals.extend(geometry.normals);
    let moved = geometry.triangles.iter().map(|t| t.map(|row| row + offset));
    model.triangles.extend(moved);
    model.primitives.push(Primitive {
        name,
        vertices: vertex..model.positions.len(),
        triangles: triangle..model.triangles.len(),
        base_color,
    });
}

fn base_color(document: &Document, primitive: &mesh::Primitive) -> [f32; 4] {
    primitive.material.map_or([1.0; 4], |material| {
        let material = &document.root.materials[material.value()];
        let factor = material.pbr_metallic_roughness.base_color_factor.0;
        factor.map(|x| x.clamp(0.0, 1.0))
    })
}

/// Meshes without a skin are left out, but their geometry is checked all the same where the file has its data.
fn check_rigid(document: &Document, pairs: &[(usize, usize)], model: &mut Model) -> Checked<()> {
    let skinned: BTreeSet<usize> = pairs.iter().map(|&(mesh, _)| mesh).collect();
    let mut count = 0;
    for (mesh, raw) in document.root.meshes.iter().enumerate() {
        if skinned.contains(&mesh) {
            continue;
        }
        count += 1;
        if document.buffers.contains(&None) {
            continue;
        }
        for (number, primitive) in raw.primitives.iter().enumerate() {
            let element = format!("/meshes/{mesh}/primitives/{number}");
            let _ = geometry::read(document, primitive, &element, &mut Vec::new())?;
            weights::sets(&Attributes::new(primitive, &element))?;
        }
    }
    if count > 0 {
        let what = format!("{count} meshes have no skin and are left out");
        model.warnings.push(what);
    }
    Ok(())
}
