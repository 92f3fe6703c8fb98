//! Tests of the importer on small files made here.
#![allow(clippy::unwrap_used)]

mod rigid;
mod spine;
mod still;

use std::path::Path;

use glam::{Mat4, Vec3};
use serde_json::{Value, json};

use super::{Document, build};
use crate::asset::{Interpolation, Model};

/// A file in the making: each array has its own buffer and view.
struct File(Value);

fn bytes<T: bytemuck::Pod>(items: &[T]) -> Vec<u8> {
    bytemuck::cast_slice(items).to_vec()
}

impl File {
    /// A triangle bound to joint `a`, with the child `b`; node 2 shows it.
    fn triangle() -> Self {
        let mut file = File(json!({
            "asset": { "version": "2.0" },
            "nodes": [
                { "name": "a", "children": [1] },
                { "name": "b", "translation": [0.0, 1.0, 0.0] },
                { "mesh": 0, "skin": 0 },
            ],
            "skins": [{ "joints": [0, 1] }],
            "meshes": [{ "primitives": [{ "attributes": {} }] }],
            "buffers": [], "bufferViews": [], "accessors": [],
        }));
        let corners = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        file.attribute("POSITION", 5126, "VEC3", 3, &bytes(&corners));
        file.attribute(
            "JOINTS_0",
            5121,
            "VEC4",
            3,
            &[0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0],
        );
        let weights = [
            [1.0_f32, 0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0, 0.0],
            [0.25, 0.75, 0.0, 0.0],
        ];
        file.attribute("WEIGHTS_0", 5126, "VEC4", 3, &bytes(&weights));
        file
    }

    fn push(&mut self, array: &str, item: Value) -> usize {
        let items = self.0[array].as_array_mut().unwrap();
        items.push(item);
        items.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        let body: String = bytes.iter().map(|byte| format!("%{byte:02x}")).collect();
        let uri = format!("data:application/octet-stream,{body}");
        let buffer = self.push("buffers", json!({ "uri": uri, "byteLength": bytes.len() }));
        self.push(
            "bufferViews",
            json!({ "buffer": buffer, "byteLength": bytes.len() }),
        )
    }

    fn accessor(&mut self, component: u32, shape: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "type": shape, "count": count }),
        )
    }

    fn primitive(&mut self) -> &mut Value {
        &mut self.0["meshes"][0]["primitives"][0]
    }

    fn attribute(
        &mut self,
        name: &str,
        component: u32,
        shape: &str,
        count: usize,
        bytes: &[u8],
    ) -> usize {
        let accessor = self.accessor(component, shape, count, bytes);
        self.primitive()["attributes"][name] = accessor.into();
        accessor
    }

    fn clip(&mut self, times: &[f32], values: &[f32], path: &str, interpolation: &str) {
        let shape = if path == "rotation" { "VEC4" } else { "VEC3" };
        let components = if path == "rotation" { 4 } else { 3 };
        let input = self.accessor(5126, "SCALAR", times.len(), &bytes(times));
        let output = self.accessor(5126, shape, values.len() / components, &bytes(values));
        self.0["animations"] = json!([{
            "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
            "channels": [{ "sampler": 0, "target": { "node": 1, "path": path } }],
        }]);
    }

    fn load(&self) -> Result<Model, String> {
        let text = self.0.to_string();
        Document::parse(text.as_bytes(), Path::new("."))
            .and_then(|document| build(&document))
            .map_err(|fault| fault.with_path(Path::new("f")).to_string())
    }

    fn model(&self) -> Model {
        self.load().unwrap()
    }

    #[track_caller]
    fn refused(&self, expected: &str) {
        let message = self.load().unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
}

fn weights(model: &Model, row: usize) -> Vec<(u16, f32)> {
    let list = &model.influences[row];
    list.iter().map(|i| (i.joint, i.weight)).collect()
}

#[test]
fn a_plain_character_loads() {
    let model = File::triangle().model();
    assert_eq!(model.triangles, [[0, 1, 2]]);
    assert_eq!(model.normals, [Vec3::Z; 3]);
    assert_eq!(weights(&model, 0), [(0, 1.0)]);
    assert_eq!(weights(&model, 2), [(1, 0.75), (0, 0.25)]);
    let names: Vec<_> = model
        .joints
        .iter()
        .map(|j| (j.name.as_str(), j.parent))
        .collect();
    assert_eq!(names, [("a", None), ("b", Some(0))]);
    assert_eq!(model.joints[1].inverse_bind, Mat4::IDENTITY);
    assert_eq!(model.primitives[0].name, "mesh_0/0");
}

#[test]
fn sparse_elements_replace_those_of_the_view_or_zeros() {
    let mut file = File::triangle();
    let (indices, values) = (
        file.view(&[0, 2]),
        file.view(&bytes(&[[5.0_f32; 3], [6.0, 7.0, 8.0]])),
    );
    let sparse = json!({
        "count": 2,
        "indices": { "bufferView": indices, "componentType": 5121 },
        "values": { "bufferView": values },
    });
    file.0["accessors"][0]["sparse"] = sparse;
    let expected = [Vec3::splat(5.0), Vec3::X, Vec3::new(6.0, 7.0, 8.0)];
    assert_eq!(file.model().positions, expected);
    file.0["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    assert_eq!(file.model().positions[1], Vec3::ZERO);
    file.0["accessors"][0]["sparse"]["count"] = 4.into();
    file.refused("/accessors/0/sparse/count");
}

#[test]
fn quantized_strided_positions_need_the_extension() {
    let mut file = File::triangle();
    // Two bytes of padding after each position.
    let rows: [[i16; 4]; 3] = [[0; 4], [32767, 0, 0, 9], [0, -32768, 0, 9]];
    let row = file.attribute("POSITION", 5122, "VEC3", 3, &bytes(&rows));
    let view = file.0["accessors"][row]["bufferView"].as_u64().unwrap() as usize;
    file.0["bufferViews"][view]["byteStride"] = 8.into();
    file.0["accessors"][row]["normalized"] = true.into();
    file.refused("cannot be POSITION");
    file.0["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    file.0["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    assert_eq!(file.model().positions, [Vec3::ZERO, Vec3::X, Vec3::NEG_Y]);
    file.0["accessors"][row]["normalized"] = false.into();
    assert_eq!(file.model().positions[2].y, -32768.0);
    file.0["bufferViews"][view]["byteStride"] = 4.into();
    file.refused("elements of 6 bytes every 4");
}

#[test]
fn strips_and_fans_become_triangles() {
    let mut file = File::triangle();
    let indices = file.accessor(5121, "SCALAR", 5, &[0, 1, 2, 2, 0]);
    file.primitive()["indices"] = indices.into();
    file.primitive()["mode"] = 5.into();
    assert_eq!(file.model().triangles, [[0, 1, 2]]);
    file.primitive()["mode"] = 6.into();
    assert_eq!(file.model().triangles, [[0, 1, 2]]);
    file.primitive()["mode"] = 4.into();
    let model = file.model();
    assert_eq!(model.triangles, [[0, 1, 2]]);
    assert!(
        model
            .warnings
            .iter()
            .any(|w| w.contains("2 indices left over"))
    );
    file.primitive()["mode"] = 1.into();
    file.refused("/skins: no node joins a mesh of triangles");
    let indices = file.accessor(5121, "SCALAR", 4, &[0, 1, 2, 1]);
    file.primitive()["indices"] = indices.into();
    file.primitive()["mode"] = 5.into();
    assert_eq!(file.model().triangles, [[0, 1, 2]]);
}

#[test]
fn a_strip_keeps_its_facing() {
    let mut file = File::triangle();
    let corners = [
        [0.0_f32, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ];
    file.primitive()["attributes"] = json!({});
    file.attribute("POSITION", 5126, "VEC3", 4, &bytes(&corners));
    file.primitive()["mode"] = 5.into();
    let model = file.model();
    assert_eq!(model.triangles, [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(model.normals, [Vec3::Z; 4]);
}

#[test]
fn further_sets_and_normalized_weights_are_merged() {
    let mut file = File::triangle();
    file.attribute("JOINTS_1", 5123, "VEC4", 3, &bytes(&[[1_u16, 0, 0, 0]; 3]));
    let row = file.attribute("WEIGHTS_1", 5121, "VEC4", 3, &[[255, 0, 0, 0]; 3].concat());
    file.refused("cannot be WEIGHTS");
    file.0["accessors"][row]["normalized"] = true.into();
    let model = file.model();
    assert_eq!(weights(&model, 0), [(0, 0.5), (1, 0.5)]);
    assert_eq!(weights(&model, 2), [(1, 0.875), (0, 0.125)]);
    assert!(
        model
            .warnings
            .iter()
            .any(|w| w.contains("3 vertices") && w.contains("2.000"))
    );
    file.primitive()["attributes"]["JOINTS_3"] = 1.into();
    file.refused("/meshes/0/primitives/0/attributes/JOINTS_3");
}

#[test]
fn odd_weights_are_mended_or_refused() {
    let mut file = File::triangle();
    let rows = [[0.0_f32; 4], [0.5, 0.5, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]];
    file.attribute("WEIGHTS_0", 5126, "VEC4", 3, &bytes(&rows));
    let model = file.model();
    assert_eq!(weights(&model, 0), [(0, 1.0)]);
    assert!(
        model
            .warnings
            .iter()
            .any(|w| w.starts_with("1 vertices have weights"))
    );
    let row = file.attribute(
        "WEIGHTS_0",
        5126,
        "VEC4",
        3,
        &bytes(&[[-1.0_f32, 0.0, 0.0, 2.0]; 3]),
    );
    file.refused("attributes/WEIGHTS_0: element 0 is negative");
    let mut rows = [[1.0_f32, 0.0, 0.0, 0.0]; 3];
    rows[1][2] = f32::NAN;
    let row = file
        .attribute("WEIGHTS_0", 5126, "VEC4", 3, &bytes(&rows))
        .max(row);
    file.refused(&format!("/accessors/{row}: element 1 is NaN"));
    file.attribute(
        "WEIGHTS_0",
        5126,
        "VEC4",
        3,
        &bytes(&[[1.0_f32, 0.0, 0.0, 0.0]; 3]),
    );
    file.attribute("JOINTS_0", 5121, "VEC4", 3, &[2; 12]);
    file.refused("attributes/JOINTS_0: element 0: joint 2 of 2");
}

#[test]
fn without_weights_the_lists_are_empty() {
    let mut file = File::triangle();
    let attributes = file.primitive()["attributes"].as_object_mut().unwrap();
    attributes.retain(|name, _| name == "POSITION");
    assert!(file.model().influences.iter().all(Vec::is_empty));
}

#[test]
fn inverse_bind_matrices_are_checked_by_joint() {
    let mut file = File::triangle();
    let mut matrices = [Mat4::IDENTITY, Mat4::from_scale(Vec3::new(-2.0, 3.0, 4.0))];
    let mut with = |matrices: [Mat4; 2]| {
        let columns = matrices.map(|m| m.to_cols_array());
        let row = file.accessor(5126, "MAT4", 2, &bytes(&columns));
        file.0["skins"][0]["inverseBindMatrices"] = row.into();
        file.load()
    };
    assert_eq!(with(matrices).unwrap().joints[1].inverse_bind, matrices[1]);
    for bad in [
        Mat4::ZERO,
        Mat4::from_scale(Vec3::new(1.0, 0.0, 1.0)),
        Mat4::from_cols_array(&[1.0; 16]),
        Mat4::IDENTITY.transpose()
            + Mat4::from_cols_array(&std::array::from_fn(|i| f32::from(u8::from(i == 3)))),
    ] {
        matrices[1] = bad;
        let message = with(matrices).unwrap_err();
        assert!(
            message.contains("/skins/0/inverseBindMatrices: joint \"b\""),
            "{message}"
        );
    }
    matrices[1] = Mat4::IDENTITY * f32::NAN;
    assert!(with(matrices).unwrap_err().contains("element 1 is NaN"));
}

#[test]
fn another_skin_is_carried_into_the_first_skins_space() {
    let mut file = File::triangle();
    // The same joints, bound ten times as large and mirrored: the inverse bind matrices scale down.
    let scale = Vec3::new(-0.1, 0.1, 0.1);
    let columns = [Mat4::from_scale(scale); 2].map(|m| m.to_cols_array());
    let row = file.accessor(5126, "MAT4", 2, &bytes(&columns));
    file.push(
        "skins",
        json!({ "joints": [1, 0], "inverseBindMatrices": row }),
    );
    file.push("nodes", json!({ "mesh": 1, "skin": 1 }));
    let primitive = file.primitive().clone();
    file.push("meshes", json!({ "primitives": [primitive] }));
    let model = file.model();
    assert_eq!(model.joints.len(), 2);
    assert_eq!(model.joints[0].inverse_bind, Mat4::IDENTITY);
    assert!(model.positions[4].abs_diff_eq(Vec3::new(-0.1, 0.0, 0.0), 1e-7));
    assert_eq!(model.triangles, [[0, 1, 2], [3, 5, 4]]);
    assert_eq!(model.normals[3..], [Vec3::Z; 3]);
    // Its numbering is turned round.
    assert_eq!(weights(&model, 5), [(0, 0.75), (1, 0.25)]);
    assert_eq!(model.primitives[1].vertices, 3..6);
}

#[test]
fn skins_without_a_common_joint_meet_in_the_pose_of_the_scene() {
    let mut file = File::triangle();
    file.0["skins"][0]["joints"] = json!([0, 0]);
    file.push("skins", json!({ "joints": [1, 1] }));
    file.push("nodes", json!({ "mesh": 0, "skin": 1 }));
    let model = file.model();
    // Joint b stands one above a, its skin is bound at b itself.
    assert!(model.positions[3].abs_diff_eq(Vec3::Y, 1e-6));
    let back = model.joints[1].inverse_bind.transform_point3(Vec3::Y);
    assert!(back.abs_diff_eq(Vec3::ZERO, 1e-6));
    assert_eq!(weights(&model, 2), [(0, 1.0)]);
    assert!(
        model
            .warnings
            .iter()
            .any(|w| w.contains("lists joint \"a\" twice"))
    );
}

#[test]
fn loops_and_second_parents_are_refused() {
    let mut file = File::triangle();
    file.0["nodes"][1]["children"] = json!([0]);
    file.refused("/nodes/0: its ancestors form a loop");
    file.0["nodes"][1]["children"] = json!([2]);
    file.0["nodes"][0]["children"] = json!([1, 2]);
    file.refused("/nodes/1/children/0: node 2 is a child of node 0 already");
}

#[test]
fn long_chains_do_not_overflow_the_stack() {
    let mut file = File::triangle();
    let count = 50_000;
    for row in 3..count {
        file.push("nodes", json!({ "children": [row + 1] }));
    }
    file.push("nodes", json!({ "name": "a" }));
    file.0["skins"][0]["joints"] = json!([0, count]);
    let model = file.model();
    assert_eq!(model.joints[1].name, "a_2");
    assert_eq!(model.nodes.len(), count - 1);
}

#[test]
fn clips_are_read_and_checked() {
    let mut file = File::triangle();
    file.clip(&[0.0, 0.5, 2.0], &[0.5; 9], "translation", "STEP");
    let model = file.model();
    assert_eq!(
        (model.clips[0].name.as_str(), model.clips[0].seconds),
        ("clip_0", 2.0)
    );
    assert_eq!(
        model.clips[0].channels[0].interpolation,
        Interpolation::Step
    );
    assert_eq!(model.clips[0].channels[0].node, 1);

    file.clip(&[0.0, 1.0], &[0.0; 18], "scale", "CUBICSPLINE");
    assert_eq!(file.model().clips[0].channels[0].values.len(), 18);
    file.clip(&[0.0, 1.0], &[0.0; 6], "scale", "CUBICSPLINE");
    file.refused("/animations/0/channels/0/sampler: 2 values for 2 keys, not 6");
    file.clip(&[1.0, 1.0], &[0.0; 6], "scale", "LINEAR");
    file.refused("element 1: key times do not rise");
    file.clip(&[-1.0, 1.0], &[0.0; 6], "scale", "LINEAR");
    file.refused("element 0: a key time below 0");
    file.clip(&[0.0], &[f32::INFINITY; 3], "scale", "LINEAR");
    file.refused("element 0 is infinite");
    file.clip(&[0.0], &[0.0; 4], "rotation", "LINEAR");
    file.refused("element 0 is not a unit quaternion");
    file.clip(&[0.0], &[0.0, 0.0, 0.0, 1.01], "rotation", "LINEAR");
    assert_eq!(
        file.model().clips[0].channels[0].values,
        [0.0, 0.0, 0.0, 1.0]
    );

    let twice = file.0["animations"][0]["channels"][0].clone();
    file.0["animations"][0]["channels"] = json!([twice, twice]);
    file.refused("/animations/0/channels/1/target: another channel");
    file.0["animations"][0]["channels"] = json!([{ "sampler": 0, "target": { "path": "scale" } }]);
    assert!(file.model().clips.is_empty());
    file.0["animations"][0]["channels"][0]["sampler"] = 3.into();
    file.refused("/animations/0/channels/0/sampler: 3, but there are 1 samplers");
}

#[test]
fn a_small_file_cannot_ask_for_more_than_there_is() {
    let mut file = File::triangle();
    file.0["accessors"][0] =
        json!({ "componentType": 5126, "type": "VEC3", "count": 4_000_000_000_u64 });
    file.refused("/accessors/0/count");
    file.0["accessors"][0]["count"] = (1 << 20).into();
    file.primitive()["attributes"] = json!({ "POSITION": 0 });
    let primitive = file.primitive().clone();
    file.0["meshes"][0]["primitives"] = vec![primitive; 1000].into();
    file.refused("the model has more than");
}

#[test]
fn what_is_no_character_says_so() {
    let mut file = File::triangle();
    file.0["nodes"][2].as_object_mut().unwrap().remove("skin");
    file.refused("/skins: no node joins");
    file.0.as_object_mut().unwrap().remove("skins");
    file.refused("/skins: the file has no skin");
}
