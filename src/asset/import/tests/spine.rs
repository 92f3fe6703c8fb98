//! Spines marked in a file.

use serde_json::json;

use super::File;

#[test]
fn a_joint_may_begin_a_spine() {
    let mut file = File::triangle();
    let names = file
        .model()
        .joints
        .iter()
        .map(|j| j.name.clone())
        .collect::<Vec<_>>();
    assert!(file.model().spines.is_empty());
    let node = file.0["skins"][0]["joints"][0].as_u64().unwrap() as usize;
    let element = format!("f: /nodes/{node}/extras/dermis_spine: ");
    for (mark, map) in [
        ("", "radial"),
        ("=normal", "normal"),
        ("=binormal", "binormal"),
    ] {
        let text = format!("{}{mark}", names[0]);
        file.0["nodes"][node]["extras"] = json!({ "dermis_spine": text, "other": [1, 2] });
        let spine = &file.model().spines[0];
        assert_eq!(
            (spine.root.as_str(), spine.tip.as_str()),
            (&*names[0], &*names[0])
        );
        assert_eq!(spine.map, map);
    }
    for (mark, reason) in [
        (json!("wing"), "there is no joint \"wing\""),
        (json!(7), "expected the name"),
        (json!(format!("{}=flat", names[0])), "\"flat\" is no map"),
    ] {
        file.0["nodes"][node]["extras"] = json!({ "dermis_spine": mark });
        file.refused(&format!("{element}{reason}"));
    }
    file.0["nodes"][node]["extras"] = json!(["no", "object"]);
    assert!(file.model().spines.is_empty());
}
