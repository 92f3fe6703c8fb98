//! The attribute _RIGID.

use serde_json::json;

use super::{File, bytes};

#[test]
fn floats_and_integers_say_how_rigid_a_vertex_is() {
    let mut file = File::triangle();
    assert!(file.model().rigid.is_empty());
    file.attribute("_RIGID", 5126, "SCALAR", 3, &bytes(&[0.0_f32, 0.25, 1.0]));
    assert_eq!(file.model().rigid, [0.0, 0.25, 1.0]);
    let padded = |values: [u8; 3]| values.map(|x| [x, 0, 0, 0]).concat();
    for (component, normalized, raw) in [
        (5121, false, padded([0, 1, 1])),
        (5121, true, padded([0, 255, 255])),
        (5123, false, bytes(&[0_u16, 0, 1, 0, 1, 0])),
        (5123, true, bytes(&[0_u16, 0, 65535, 0, 65535, 0])),
    ] {
        let row = file.attribute("_RIGID", component, "SCALAR", 3, &raw);
        let view = file.0["accessors"][row]["bufferView"].as_u64().unwrap() as usize;
        file.0["bufferViews"][view]["byteStride"] = 4.into();
        file.0["accessors"][row]["normalized"] = normalized.into();
        assert_eq!(file.model().rigid, [0.0, 1.0, 1.0], "{component}");
    }
}

#[test]
fn primitives_without_it_are_free() {
    let mut file = File::triangle();
    let plain = file.primitive().clone();
    file.attribute("_RIGID", 5126, "SCALAR", 3, &bytes(&[1.0_f32; 3]));
    let painted = file.primitive().clone();
    file.0["meshes"][0]["primitives"] = json!([plain, painted, plain]);
    let expected = [[0.0; 3], [1.0; 3], [0.0; 3]].concat();
    assert_eq!(file.model().rigid, expected);
}

#[test]
fn bad_values_are_refused_by_primitive_and_vertex() {
    let mut file = File::triangle();
    let element = "f: /meshes/0/primitives/0/attributes/_RIGID: ";
    for (values, culprit) in [
        ([0.0_f32, 1.5, 1.0], "element 1: 1.5 is not in 0 to 1"),
        ([0.0, 1.0, -0.25], "element 2: -0.25 is not in 0 to 1"),
    ] {
        file.attribute("_RIGID", 5126, "SCALAR", 3, &bytes(&values));
        file.refused(&format!("{element}{culprit}"));
    }
    file.attribute("_RIGID", 5126, "SCALAR", 2, &bytes(&[0.0_f32; 2]));
    file.refused(&format!("{element}2 elements for 3 positions"));
    let nan = [0.0, f32::NAN, 0.0];
    let row = file.attribute("_RIGID", 5126, "SCALAR", 3, &bytes(&nan));
    file.refused(&format!("/accessors/{row}: element 1 is NaN"));
    file.attribute("_RIGID", 5126, "VEC3", 3, &bytes(&[[0.0_f32; 3]; 3]));
    file.refused("cannot be _RIGID");
}

#[test]
fn rounding_is_mended() {
    let mut file = File::triangle();
    let values = [1.0 + f32::EPSILON, -1e-7, 0.5];
    file.attribute("_RIGID", 5126, "SCALAR", 3, &bytes(&values));
    assert_eq!(file.model().rigid, [1.0, 0.0, 0.5]);
}
