//! Tracked skins: rigid regions, controllers, profile curves, random poses.
#![allow(clippy::unwrap_used)]

mod common;

use std::{
    fs,
    path::{Path, PathBuf},
};

use common::{asset, good};
use glam::Vec3;
use serde_json::{Value, json};

/// Bytes of a vertex of a PLY: eight floats, a state, a bone.
const ROW: usize = 35;

/// What follows the header of a PLY, vertices first.
fn body(path: &Path) -> Vec<u8> {
    let bytes = fs::read(path).unwrap();
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    bytes[at..].to_vec()
}

fn float(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

/// A skin of the arm, a row a vertex.
struct Arm {
    bytes: Vec<u8>,
    positions: Vec<Vec3>,
    bone: Vec<u8>,
    triangles: Vec<[usize; 3]>,
}

impl Arm {
    /// Bakes `file`, the arm twisted and bent at its elbow unless `more` says otherwise.
    fn bake(file: &str, folder: &Path, name: &str, more: &[&str]) -> Self {
        let (pose, out) = (folder.join("pose.json"), folder.join(name));
        fs::write(&pose, r#"{"lower": {"axis": [1, 0, 0.5], "degrees": 70}}"#).unwrap();
        let mut args = vec!["bake", file, "-o", out.to_str().unwrap(), "--quiet"];
        args.extend(["--method", "tracking"]);
        args.extend(more);
        if !more.contains(&"--random") && !more.contains(&"--pose") {
            args.extend(["--pose", pose.to_str().unwrap()]);
        }
        good(&args);
        let vertices = 7042;
        let bytes = body(&out.join("frame_0000.ply"));
        let at = |v: usize| [0, 4, 8].map(|i| float(&bytes, v * ROW + i));
        let (faces, _) = bytes[vertices * ROW..].as_chunks::<13>();
        let corner = |f: &[u8; 13], k: usize| {
            u32::from_le_bytes(f[1 + 4 * k..5 + 4 * k].try_into().unwrap()) as usize
        };
        Self {
            positions: (0..vertices).map(|v| at(v).into()).collect(),
            bone: (0..vertices).map(|v| bytes[v * ROW + 33]).collect(),
            triangles: faces
                .iter()
                .map(|f| [0, 1, 2].map(|k| corner(f, k)))
                .collect(),
            bytes,
        }
    }

    /// Root mean square of how much the edges inside the lower part have changed their length, as a share of it.
    fn strain(&self, rest: &Arm) -> f32 {
        let inside = |t: &&[usize; 3]| t.iter().all(|v| self.bone[*v] == 1);
        let edges = self.triangles.iter().filter(inside);
        let edges = edges.flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
        let length = |arm: &Arm, [a, b]: [usize; 2]| arm.positions[a].distance(arm.positions[b]);
        let changes = edges.map(|e| (length(self, e) / length(rest, e) - 1.0).powi(2));
        let (sum, count) = changes.fold((0.0, 0), |(sum, n), x| (sum + x, n + 1));
        (sum / count as f32).sqrt()
    }

    /// Greatest distance to the same vertex of another skin, of the vertices that `which` picks by their place at rest.
    fn away(&self, other: &Arm, rest: &Arm, which: impl Fn(Vec3) -> bool) -> f32 {
        let rows = (0..rest.positions.len()).filter(|v| which(rest.positions[*v]));
        let distances = rows.map(|v| self.positions[v].distance(other.positions[v]));
        distances.fold(0.0, f32::max)
    }
}

/// A copy of the arm whose vertices are as rigid as `rigid` says.
fn painted(folder: &Path, rigid: &[f32]) -> PathBuf {
    let bytes = fs::read(asset("arm.glb")).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut gltf: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let mut binary = bytes[28 + length..].to_vec();
    let (start, size) = (binary.len(), 4 * rigid.len());
    binary.extend(rigid.iter().flat_map(|x| x.to_le_bytes()));
    gltf["buffers"][0]["byteLength"] = binary.len().into();
    let views = gltf["bufferViews"].as_array_mut().unwrap();
    views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": size }));
    let view = views.len() - 1;
    let accessors = gltf["accessors"].as_array_mut().unwrap();
    let count = rigid.len();
    accessors.push(
        json!({ "bufferView": view, "componentType": 5126, "type": "SCALAR", "count": count }),
    );
    let accessor = accessors.len() - 1;
    gltf["meshes"][0]["primitives"][0]["attributes"]["_RIGID"] = accessor.into();
    let mut text = gltf.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 28 + text.len() + binary.len();
    let word = |x: usize| (x as u32).to_le_bytes().to_vec();
    let header = [b"glTF".to_vec(), word(2), word(total)].concat();
    let json = [word(text.len()), b"JSON".to_vec(), text].concat();
    let bin = [word(binary.len()), b"BIN\0".to_vec(), binary].concat();
    let path = folder.join("painted.glb");
    fs::write(&path, [header, json, bin].concat()).unwrap();
    path
}

#[test]
fn a_rigid_part_keeps_its_shape_and_the_rest_its_freedom() {
    let folder = tempfile::tempdir().unwrap();
    let (folder, file) = (folder.path(), asset("arm.glb"));
    let free = Arm::bake(&file, folder, "free", &[]);
    let rigid = Arm::bake(&file, folder, "rigid", &["--rigid", "lower"]);
    let rest = Arm::bake(&file, folder, "rest", &["--random", "1", "--degrees", "0"]);
    let strains = [free.strain(&rest), rigid.strain(&rest)];
    let far = rigid.away(&free, &rest, |p| p.x < -0.2);
    let near = rigid.away(&free, &rest, |p| p.x > 0.0);
    assert!(far == 0.0 && near > 0.0, "{far} {near}");
    assert!(strains[1] < 0.5 * strains[0], "{strains:?}");
    // Painted in the file, it is the same.
    let rows: Vec<f32> = free.bone.iter().map(|b| f32::from(*b)).collect();
    let file = painted(folder, &rows);
    let file = file.to_str().unwrap();
    let info: Value = serde_json::from_str(&good(&["info", file, "--json", "-"])).unwrap();
    let count = rows.iter().filter(|x| **x > 0.0).count();
    assert_eq!(info["rigid_vertices"], count);
    assert!(good(&["info", file]).contains("vertices are painted rigid"));
    let again = Arm::bake(file, folder, "painted", &[]);
    assert!(again.bytes == rigid.bytes);
}

#[test]
fn controllers_and_profiles_change_a_contact() {
    let folder = tempfile::tempdir().unwrap();
    let (folder, file) = (folder.path(), asset("arm.glb"));
    let pose = folder.join("bent.json");
    fs::write(&pose, r#"{"lower": {"axis": [0, 0, 1], "degrees": 100}}"#).unwrap();
    let bent = ["--pose", pose.to_str().unwrap()];
    let bake =
        |name: &str, more: &[&str]| Arm::bake(&file, folder, name, &[&bent[..], more].concat());
    let bulge = bake("bulge", &["--joint", "lower=bulge"]);
    let curve = asset("profile.json");
    let profile = bake(
        "profile",
        &["--joint", "lower=profile", "--profile", &curve],
    );
    let never = bake(
        "never",
        &["--joint", "lower=bulge", "--controller", "lower=never"],
    );
    let [more, less] = [&profile, &never].map(|arm| arm.away(&bulge, &bulge, |_| true));
    assert!(more > 1e-3 && less > 1e-3, "{more} {less}");
}

#[test]
fn random_poses_do_not_depend_on_those_before_them() {
    let folder = tempfile::tempdir().unwrap();
    let bake = |name: &str, count: &str, seed: &str| {
        let more = ["--random", count, "--seed", seed];
        Arm::bake(&asset("arm.glb"), folder.path(), name, &more);
    };
    // The second pose of seed 5 is the first of seed 6.
    bake("two", "2", "5");
    bake("one", "1", "6");
    let [two, one] =
        ["two/frame_0001.ply", "one/frame_0000.ply"].map(|name| body(&folder.path().join(name)));
    assert!(two == one);
}
