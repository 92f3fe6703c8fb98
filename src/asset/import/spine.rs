//! Spines that a file marks: `"extras": {"dermis_spine": "TIP"}` at a joint says that the chain from it to the joint TIP bends by
//! fleshing, `"TIP=normal"` or `"TIP=binormal"` by another map than the radial.

use serde_json::Value;

use super::{
    document::Document,
    fault::{Checked, refuse},
    skeleton::Skeleton,
};
use crate::asset::{Joint, Spine};

const KEY: &str = "dermis_spine";
const MAPS: [&str; 3] = ["radial", "normal", "binormal"];

/// The spines of all joints, in the order of the file's nodes.
pub(super) fn read(document: &Document, skeleton: &Skeleton) -> Checked<Vec<Spine>> {
    let mut spines = Vec::new();
    for (node, raw) in document.root.nodes.iter().enumerate() {
        let element = format!("/nodes/{node}/extras/{KEY}");
        let Some(extras) = &raw.extras else { continue };
        // Any JSON may stand in extras; what is no object has no key.
        let extras: Value = serde_json::from_str(extras.get()).unwrap_or_default();
        let Some(mark) = extras.get(KEY) else {
            continue;
        };
        let row = skeleton.row[node];
        let joint = skeleton.joints.iter().position(|j| Some(j.node) == row);
        let Some(root) = joint else {
            return refuse(element, "the node is no joint of a skin in use");
        };
        let Some(mark) = mark.as_str() else {
            return refuse(element, "expected the name of the chain's last joint");
        };
        match spine(&skeleton.joints, root, mark) {
            Ok(spine) => spines.push(spine),
            Err(reason) => return refuse(element, reason),
        }
    }
    Ok(spines)
}

fn spine(joints: &[Joint], root: usize, mark: &str) -> Result<Spine, String> {
    let find = |name: &str| joints.iter().position(|joint| joint.name == name);
    // A name may have an equals sign of its own.
    let (tip, map) = match mark.rsplit_once('=') {
        Some((tip, map)) if find(mark).is_none() => (tip, map),
        _ => (mark, MAPS[0]),
    };
    if !MAPS.contains(&map) {
        return Err(format!("{map:?} is no map: radial, normal or binormal"));
    }
    let Some(row) = find(tip) else {
        return Err(format!("there is no joint {tip:?}"));
    };
    let mut above = std::iter::successors(Some(row), |joint| joints[*joint].parent);
    if !above.any(|joint| joint == root) {
        let root = &joints[root].name;
        return Err(format!("joint {tip:?} does not descend from {root:?}"));
    }
    Ok(Spine {
        root: joints[root].name.clone(),
        tip: tip.into(),
        map: map.into(),
    })
}
