//! Meshes without a skin as one static mesh, in the space of the scene.

use std::path::Path;

use glam::DMat4;

use super::{
    ROW_LIMIT,
    document::Document,
    fault::{Checked, refuse},
    geometry,
    graph::Graph,
};
use crate::{Result, asset::Surface};

/// Reads the triangles of a `.glb` or `.gltf` file without a skin: all meshes one after the other where the nodes put them, as
/// often as they do. Morph targets are left out. `None` where a node joins a mesh with a skin: that is a character.
///
/// # Errors
/// [`Error::File`](crate::Error) where the file cannot be read; [`Error::Asset`](crate::Error) with a JSON pointer where its content is wrong, or `/meshes`
/// where no node shows a triangle.
pub fn load_still(path: &Path) -> Result<Option<Surface>> {
    let document = Document::open(path)?;
    read(&document).map_err(|fault| fault.with_path(path))
}

fn read(document: &Document) -> Checked<Option<Surface>> {
    let nodes = &document.root.nodes;
    if nodes.iter().any(|n| n.mesh.is_some() && n.skin.is_some()) {
        return Ok(None);
    }
    let graph = Graph::new(document)?;
    let mut surface = Surface::default();
    for (node, world) in nodes.iter().zip(graph.world()) {
        if let Some(mesh) = node.mesh {
            add(document, mesh.value(), world, &mut surface)?;
        }
    }
    if surface.triangles.is_empty() {
        return refuse("/meshes", "no node shows a triangle");
    }
    Ok(Some(surface))
}

fn add(document: &Document, mesh: usize, world: &DMat4, surface: &mut Surface) -> Checked<()> {
    for (number, primitive) in document.root.meshes[mesh].primitives.iter().enumerate() {
        let element = format!("/meshes/{mesh}/primitives/{number}");
        // Points and lines have no triangles.
        let Ok(part) = geometry::read(document, primitive, &element, &mut Vec::new())? else {
            continue;
        };
        let from = surface.positions.len();
        if from + part.positions.len() > ROW_LIMIT
            || surface.triangles.len() + part.triangles.len() > ROW_LIMIT
        {
            return refuse(element, format!("the mesh has more than {ROW_LIMIT} rows"));
        }
        let placed = part.positions.iter();
        let placed = placed.map(|p| world.transform_point3(p.as_dvec3()).as_vec3());
        surface.positions.extend(placed);
        if surface.positions[from..].iter().any(|p| !p.is_finite()) {
            return refuse(element, "its node puts it too far away");
        }
        // A mirror turns triangles inside out.
        let turn = |[a, b, c]: [u32; 3]| match world.determinant() < 0.0 {
            true => [a, c, b],
            false => [a, b, c],
        };
        let rows = part.triangles.iter();
        let rows = rows.map(|t| turn(t.map(|row| row + from as u32)));
        surface.triangles.extend(rows);
    }
    Ok(())
}
