//! Moving spheres as GLB: a node a sphere, all with one mesh, and a surface beside them.

use std::path::Path;

use glam::Vec3;
use serde_json::{Map, Value, json};

use super::glb::{Builder, Shape, Use};
use crate::{Error, Result};

/// Pieces along a quarter of a sphere's equator.
const QUARTER: u32 = 6;

/// A sphere and its way.
#[derive(Clone, Debug)]
pub struct SpherePath {
    /// Radius; 0 becomes a point that is not seen.
    pub radius: f32,
    /// Centres, one a time.
    pub centres: Vec<Vec3>,
}

/// A static mesh.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceMesh<'a> {
    /// Positions.
    pub positions: &'a [Vec3],
    /// Unit normals.
    pub normals: &'a [Vec3],
    /// Triangles as rows.
    pub triangles: &'a [[u32; 3]],
}

/// Spheres over time.
#[derive(Clone, Copy, Debug)]
pub struct SphereAnimation<'a> {
    /// Seconds of the keys, rising.
    pub times: &'a [f32],
    /// Spheres, named `sphere_0` and so on.
    pub spheres: &'a [SpherePath],
    /// A surface that does not move.
    pub surface: Option<SurfaceMesh<'a>>,
}

/// Writes spheres as nodes with animated translations, in the first key's place where nothing plays, and the surface as a
/// mesh of its own.
///
/// # Errors
/// [`Error::Argument`] where a sphere has not one centre a key, a number is not finite or times do not rise;
/// [`Error::Asset`] where the file would pass 4 GiB; [`Error::File`] where it cannot be written.
pub fn write_glb_spheres(path: &Path, animation: &SphereAnimation<'_>) -> Result<()> {
    check(animation)?;
    let mut builder = Builder::default();
    let ball = ball();
    let mut meshes = vec![mesh(
        &mut builder,
        "sphere",
        &ball,
        &ball,
        &octahedron_faces(),
        0,
    )];
    let input = builder.times(animation.times);
    let (mut nodes, mut samplers, mut channels) = (Vec::new(), Vec::new(), Vec::new());
    for (row, sphere) in animation.spheres.iter().enumerate() {
        let flat: Vec<f32> = sphere.centres.iter().flat_map(|c| c.to_array()).collect();
        let output = builder.array(Shape::Vec3, Use::Other, &flat);
        samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        channels.push(json!({ "sampler": row, "target": { "node": row, "path": "translation" } }));
        nodes.push(json!({
            "name": format!("sphere_{row}"),
            "mesh": 0,
            "translation": sphere.centres[0].to_array(),
            "scale": vec![sphere.radius; 3],
        }));
    }
    if let Some(surface) = animation.surface {
        let (p, n, t) = (surface.positions, surface.normals, surface.triangles);
        nodes.push(json!({ "name": "surface", "mesh": 1 }));
        meshes.push(mesh(&mut builder, "surface", p, n, t, 1));
    }
    let mut root = Map::new();
    root.insert("scene".into(), 0.into());
    let all: Vec<usize> = (0..nodes.len()).collect();
    root.insert("scenes".into(), json!([{ "nodes": all }]));
    root.insert("nodes".into(), nodes.into());
    root.insert("meshes".into(), meshes.into());
    let colour = |rgba: [f32; 4]| {
        json!({ "pbrMetallicRoughness": {
            "baseColorFactor": rgba, "metallicFactor": 0.0, "roughnessFactor": 0.8 } })
    };
    let red = colour([0.75, 0.2, 0.15, 1.0]);
    let mut veil = colour([0.6, 0.65, 0.75, 0.5]);
    veil["alphaMode"] = "BLEND".into();
    root.insert("materials".into(), json!([red, veil]));
    let clip = json!({ "name": "spheres", "samplers": samplers, "channels": channels });
    root.insert("animations".into(), json!([clip]));
    builder.write(path, root)
}

fn check(animation: &SphereAnimation<'_>) -> Result<()> {
    let fail = |argument: String, reason: &str| Err(Error::argument(argument, reason));
    let times = animation.times;
    if times.is_empty() || animation.spheres.is_empty() {
        return fail("spheres".into(), "nothing to write");
    }
    if times.iter().any(|t| !t.is_finite()) || times.windows(2).any(|w| w[0] >= w[1]) {
        return fail("times".into(), "they do not rise");
    }
    for (row, sphere) in animation.spheres.iter().enumerate() {
        let finite = sphere.radius.is_finite() && sphere.centres.iter().all(|c| c.is_finite());
        if !finite || sphere.centres.len() != times.len() {
            return fail(format!("sphere {row}"), "not one finite centre a time");
        }
    }
    let Some(surface) = animation.surface else {
        return Ok(());
    };
    let rows = surface.positions.len();
    let outside = |v: &u32| *v as usize >= rows;
    let empty = surface.triangles.is_empty() || surface.normals.len() != rows;
    if empty || surface.triangles.iter().flatten().any(outside) {
        return fail("surface".into(), "its rows do not fit together");
    }
    Ok(())
}

fn mesh(
    builder: &mut Builder,
    name: &str,
    positions: &[Vec3],
    normals: &[Vec3],
    triangles: &[[u32; 3]],
    material: usize,
) -> Value {
    json!({ "name": name, "primitives": [{
        "attributes": {
            "POSITION": builder.positions(positions),
            "NORMAL": builder.vectors(normals),
        },
        "indices": builder.triangles(triangles, 0),
        "material": material,
    }] })
}

/// Vertices of a unit sphere: each octant's grid for itself.
fn ball() -> Vec<Vec3> {
    let mut points = Vec::new();
    for sign in 0..8u32 {
        let s = |bit: u32| if sign >> bit & 1 == 0 { 1.0 } else { -1.0 };
        for i in 0..=QUARTER {
            for j in 0..=QUARTER - i {
                let (x, y) = (i as f32, j as f32);
                let z = QUARTER as f32 - x - y;
                points.push(Vec3::new(s(0) * x, s(1) * y, s(2) * z).normalize());
            }
        }
    }
    points
}

fn octahedron_faces() -> Vec<[u32; 3]> {
    let mut faces = Vec::new();
    let octant = (QUARTER + 1) * (QUARTER + 2) / 2;
    for sign in 0..8u32 {
        let row = |i: u32| i * (QUARTER + 1) - i * i.saturating_sub(1) / 2;
        let at = |i: u32, j: u32| sign * octant + row(i) + j;
        let mut face = |a, b, c| {
            let even = sign.count_ones() % 2 == 0;
            faces.push(if even { [a, b, c] } else { [a, c, b] });
        };
        for i in 0..QUARTER {
            for j in 0..QUARTER - i {
                face(at(i, j), at(i + 1, j), at(i, j + 1));
                if i + j + 1 < QUARTER {
                    face(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                }
            }
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_ball_is_closed_and_faces_outwards() {
        let points = ball();
        let mut volume = 0.0;
        for t in octahedron_faces() {
            let [a, b, c] = t.map(|v| points[v as usize]);
            assert!((b - a).cross(c - a).dot(a + b + c) > 0.0);
            volume += a.dot(b.cross(c)) / 6.0;
        }
        // Inscribed: a little less than 4 π / 3.
        assert!((3.95..4.19).contains(&volume), "{volume}");
    }

    #[test]
    fn spheres_are_nodes_with_animation() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.glb");
        let sphere = SpherePath {
            radius: 0.5,
            centres: vec![Vec3::X, Vec3::Y],
        };
        let mut animation = SphereAnimation {
            times: &[0.0, 1.0],
            spheres: &[sphere.clone(), sphere],
            surface: Some(SurfaceMesh {
                positions: &[Vec3::ZERO, Vec3::X, Vec3::Y],
                normals: &[Vec3::Z; 3],
                triangles: &[[0, 1, 2]],
            }),
        };
        write_glb_spheres(&path, &animation).unwrap();
        let file = gltf::Gltf::open(&path).unwrap();
        assert_eq!(file.nodes().count(), 3);
        assert_eq!(file.animations().next().unwrap().channels().count(), 2);
        assert_eq!(
            file.nodes().next().unwrap().transform().decomposed().0,
            [1.0, 0.0, 0.0]
        );
        animation.times = &[1.0, 0.0];
        assert!(write_glb_spheres(&path, &animation).is_err());
        animation.times = &[0.0];
        assert!(write_glb_spheres(&path, &animation).is_err());
    }
}
