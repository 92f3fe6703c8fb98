//! Meshes without a skin.

use glam::Vec3;
use serde_json::json;

use super::File;
use crate::asset::load_still;

fn load(file: &File) -> crate::Result<Option<crate::asset::Surface>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("f.gltf");
    std::fs::write(&path, file.0.to_string()).unwrap();
    load_still(&path)
}

#[test]
fn a_mesh_stands_where_its_nodes_put_it_and_a_mirror_turns_it() {
    let mut file = File::triangle();
    assert!(load(&file).unwrap().is_none(), "a character");
    file.0["skins"] = json!([]);
    file.0["nodes"] = json!([
        { "children": [1, 2], "translation": [0.0, 0.0, 5.0] },
        { "mesh": 0, "scale": [2.0, 2.0, 2.0] },
        { "mesh": 0, "scale": [-1.0, 1.0, 1.0] },
    ]);
    let surface = load(&file).unwrap().unwrap();
    let [first, second] = [[0.0, 2.0, 0.0], [0.0, -1.0, 0.0]];
    let xs: Vec<f32> = surface.positions.iter().map(|p| p.x).collect();
    assert_eq!(xs, [first, second].concat());
    assert!(surface.positions.iter().all(|p| p.z == 5.0));
    assert_eq!(surface.triangles, [[0, 1, 2], [3, 5, 4]]);
    for t in surface.triangles {
        let [a, b, c] = t.map(|row| surface.positions[row as usize]);
        assert!((b - a).cross(c - a).dot(Vec3::Z) > 0.0);
    }
    file.0["nodes"] = json!([{ "name": "empty" }]);
    let error = load(&file).unwrap_err().to_string();
    assert!(error.contains("/meshes: no node shows"), "{error}");
    file.0["nodes"] =
        json!([{ "mesh": 0, "scale": [3e38, 3e38, 3e38], "translation": [3e38, 0.0, 0.0] }]);
    let error = load(&file).unwrap_err().to_string();
    assert!(error.contains("too far away"), "{error}");
}
