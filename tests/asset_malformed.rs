//! Broken and odd files: each ends in a model or in an error that names file and element, quickly, without a panic.
#![allow(clippy::unwrap_used)]

use std::{
    fs,
    panic::catch_unwind,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use dermis::{Error, asset};
use serde_json::Value;

fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("DERMIS_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"),
        PathBuf::from,
    );
    if !folder.exists() {
        println!("skipped: no folder {}", folder.display());
        return None;
    }
    Some(folder)
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path
            .extension()
            .is_some_and(|end| end == "gltf" || end == "glb")
        {
            found.push(path);
        }
    }
}

/// The element an error names; `None` where the file loads. Panics where the error names no file or element.
fn element(path: &Path) -> Option<String> {
    let start = Instant::now();
    let result = catch_unwind(|| asset::load(path));
    let took = start.elapsed();
    assert!(took < Duration::from_secs(2), "{path:?} took {took:?}");
    match result.unwrap_or_else(|_| panic!("{path:?} panicked")) {
        Ok(model) => {
            check(&model);
            None
        }
        Err(Error::Asset {
            path: named,
            element,
            reason,
        }) => {
            assert_eq!(named, path);
            let pointer = element.starts_with('/') || element.starts_with("GLB ");
            assert!(
                pointer && !reason.is_empty(),
                "{path:?}: {element}: {reason}"
            );
            Some(element)
        }
        Err(other) => panic!("{path:?}: {other}"),
    }
}

/// What the documentation of `Model` promises.
fn check(model: &asset::Model) {
    let rows = model.positions.len();
    assert!(model.normals.len() == rows && model.influences.len() == rows);
    assert!(model.positions.iter().all(|p| p.is_finite()));
    assert!(
        model
            .normals
            .iter()
            .all(|n| (n.length() - 1.0).abs() < 1e-4)
    );
    assert!(
        model
            .triangles
            .iter()
            .flatten()
            .all(|&v| (v as usize) < rows)
    );
    for list in model.influences.iter().filter(|list| !list.is_empty()) {
        let sum: f32 = list.iter().map(|i| i.weight).sum();
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        assert!(list.iter().all(|i| (i.joint as usize) < model.joints.len()));
        assert!(list.is_sorted_by(|a, b| a.weight >= b.weight));
    }
    for (row, joint) in model.joints.iter().enumerate() {
        assert!(joint.node < model.nodes.len() && joint.parent.is_none_or(|p| p < row));
        assert!(joint.inverse_bind.inverse().is_finite());
    }
    assert!(
        model
            .nodes
            .iter()
            .enumerate()
            .all(|(row, n)| n.parent.is_none_or(|p| p < row))
    );
    for clip in &model.clips {
        for channel in &clip.channels {
            assert!(channel.node < model.nodes.len());
            assert!(channel.times.windows(2).all(|pair| pair[0] < pair[1]));
            assert!(channel.values.iter().all(|value| value.is_finite()));
        }
    }
}

/// Errors of the reference validator that dermis has no reason to refuse: they concern what it does not read (images,
/// cameras, textures, extensions' own properties, bounds that it computes itself) or cannot misread.
const TOLERATED: &[&str] = &[
    "ACCESSOR_ELEMENT_OUT_OF_",
    "ACCESSOR_INVALID_SIGN",
    "ACCESSOR_MATRIX_ALIGNMENT",
    "ACCESSOR_MAX_MISMATCH",
    "ACCESSOR_MIN_MISMATCH",
    "ACCESSOR_NON_CLAMPED",
    "ACCESSOR_VECTOR3_NON_UNIT",
    "ACCESSOR_WEIGHTS_NON_NORMALIZED",
    "ACCESSOR_JOINTS_INDEX_DUPLICATE",
    "ACCESSOR_TOTAL_OFFSET_ALIGNMENT",
    "ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS",
    "ANIMATION_SAMPLER_ACCESSOR_WITH_BYTESTRIDE",
    "ANIMATION_SAMPLER_INPUT_ACCESSOR_WITHOUT_BOUNDS",
    "BUFFER_DATA_URI_MIME_TYPE_INVALID",
    "BUFFER_VIEW_INVALID_BYTE_STRIDE",
    "BUFFER_VIEW_TARGET_OVERRIDE",
    "CAMERA_",
    "DUPLICATE_ELEMENTS",
    "EMPTY_ENTITY",
    "IMAGE_",
    "KHR_",
    "MESH_INVALID_WEIGHTS_COUNT",
    "MESH_PRIMITIVE_ACCESSOR_UNALIGNED",
    "MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE",
    "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT",
    "MESH_PRIMITIVE_INDICES_ACCESSOR_WITH_BYTESTRIDE",
    "MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY",
    "MESH_PRIMITIVE_INVALID_ATTRIBUTE",
    "MESH_PRIMITIVE_MORPH",
    "MESH_PRIMITIVE_NO_TANGENT_SPACE",
    "MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS",
    "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS",
    "MESH_PRIMITIVES_UNEQUAL_TARGETS_COUNT",
    "NODE_MATRIX_NON_TRS",
    "NODE_SKIN_",
    "NODE_WEIGHTS_INVALID",
    "NON_REQUIRED_EXTENSION",
    "ONE_OF_MISMATCH",
    "SCENE_NON_ROOT_NODE",
    "SKIN_IBM_ACCESSOR_WITH_BYTESTRIDE",
    "SKIN_NO_COMMON_ROOT",
    "SKIN_SKELETON_INVALID",
    "TEXTURE_",
    "UNDECLARED_EXTENSION",
    "UNEXPECTED_EXTENSION_OBJECT",
    "UNSATISFIED_DEPENDENCY",
];

/// Files that the reference validator finds no error in and dermis refuses all the same.
const REFUSED_THOUGH_RIGHT: &[(&str, &str)] = &[
    ("min_version_valid.gltf", "needs glTF 2.1"),
    ("non_relative_uri.gltf", "its buffer is on the network"),
    ("unknown_type.gltf", "an accessor of no known type"),
    ("named_objects.gltf", "its only buffer has no data"),
    ("animation/valid.gltf", "key times without data are all 0"),
    ("skin/ignored_animated_transform.gltf", "the same"),
    (
        "skin/valid.gltf",
        "inverse bind matrices without data are all 0",
    ),
];

/// Parts of a file that dermis reads, as the start of a JSON pointer.
const READ: &[&str] = &[
    "/asset",
    "/buffers",
    "/bufferViews",
    "/accessors",
    "/meshes",
    "/skins",
    "/nodes",
    "/animations",
];

/// Whether a report names an error in what dermis reads.
fn expects_refusal(report: &Value) -> bool {
    let messages = report["issues"]["messages"].as_array().unwrap();
    messages
        .iter()
        .filter(|m| m["severity"] == 0)
        .any(|message| {
            let code = message["code"].as_str().unwrap();
            let pointer = message["pointer"].as_str().unwrap_or("");
            let read = pointer.is_empty() || READ.iter().any(|part| pointer.starts_with(part));
            let foreign = [
                "/extensions/",
                "/extras",
                "COLOR",
                "TEXCOORD",
                "TANGENT",
                "_CUSTOM",
                "/targets",
                "/weights",
                "camera",
            ];
            read && !foreign.iter().any(|part| pointer.contains(part))
                && !TOLERATED.iter().any(|start| code.starts_with(start))
        })
}

#[test]
fn every_file_of_the_validator_ends_in_a_model_or_a_named_element() {
    let Some(data) = data() else { return };
    let mut paths = Vec::new();
    files(
        &data.join("malformed/khronos-gltf-validator/test"),
        &mut paths,
    );
    assert_eq!(paths.len(), 372);
    let (mut wrong, mut refused, mut right, mut kept) = (0, 0, 0, 0);
    for path in paths {
        let name = path.file_name().unwrap().to_str().unwrap();
        let report = fs::read(path.with_file_name(format!("{name}.report.json"))).unwrap();
        let report: Value = serde_json::from_slice(&report).unwrap();
        // These files are no characters: a sound one is refused for its missing skin, a broken one for what is broken.
        let found = element(&path);
        let broken = found.as_ref().is_some_and(|element| element != "/skins");
        if report["issues"]["numErrors"] == 0 {
            right += 1;
            kept += usize::from(!broken);
            let known = REFUSED_THOUGH_RIGHT
                .iter()
                .any(|(name, _)| path.ends_with(name));
            assert!(
                !broken || known,
                "refused although right: {path:?} {found:?}"
            );
        } else if expects_refusal(&report) {
            wrong += 1;
            refused += usize::from(broken);
            if !broken {
                println!(
                    "accepted although wrong: {path:?} {}",
                    report["issues"]["messages"][0]
                );
            }
        }
    }
    println!("{refused} of {wrong} files with errors in what is read are refused");
    println!("{kept} of {right} files without errors are accepted");
    assert!(
        refused * 100 >= wrong * 95 && wrong > 80,
        "{refused} of {wrong}"
    );
    assert_eq!(kept + REFUSED_THOUGH_RIGHT.len(), right);
}

#[test]
fn a_truncated_file_is_refused() {
    let Some(data) = data() else { return };
    let bytes = fs::read(data.join("characters/khronos/CesiumMan.glb")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.glb");
    for length in (0..bytes.len()).step_by(97) {
        fs::write(&path, &bytes[..length]).unwrap();
        assert!(element(&path).is_some(), "{length} bytes load");
    }
}

/// xorshift64*, so that a failure can be repeated.
fn random(state: &mut u64) -> usize {
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    (state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize
}

#[test]
fn a_changed_byte_never_panics() {
    let Some(data) = data() else { return };
    let bytes = fs::read(data.join("characters/khronos/CesiumMan.glb")).unwrap();
    let json = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("changed.glb");
    let (mut state, mut loads, mut refusals) = (7, 0, 0);
    for round in 0..600 {
        // Two of three in the header and the JSON, where the structure is.
        let span = if round % 3 == 0 {
            bytes.len()
        } else {
            20 + json
        };
        let (place, value) = (random(&mut state) % span, random(&mut state) as u8);
        let mut changed = bytes.clone();
        changed[place] = value;
        fs::write(&path, &changed).unwrap();
        match element(&path) {
            Some(_) => refusals += 1,
            None => loads += 1,
        }
    }
    println!("{loads} load, {refusals} are refused");
    assert!(loads > 0 && refusals > 0);
}

/// A random value somewhere below `value`.
fn somewhere<'a>(value: &'a mut Value, state: &mut u64) -> &'a mut Value {
    let size = match &*value {
        Value::Array(items) => items.len(),
        Value::Object(items) => items.len(),
        _ => 0,
    };
    if size == 0 || random(state).is_multiple_of(8) {
        return value;
    }
    let row = random(state) % size;
    let child = match value {
        Value::Array(items) => items.get_mut(row),
        Value::Object(items) => items.values_mut().nth(row),
        _ => None,
    };
    somewhere(child.unwrap(), state)
}

/// A GLB of this JSON and the rest of another.
fn with_json(bytes: &[u8], json: &Value) -> Vec<u8> {
    let old = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 20 + text.len() + bytes.len() - old;
    let mut changed = bytes[..20].to_vec();
    changed[8..12].copy_from_slice(&(total as u32).to_le_bytes());
    changed[12..16].copy_from_slice(&(text.len() as u32).to_le_bytes());
    changed.extend(text);
    changed.extend(&bytes[old..]);
    changed
}

#[test]
fn a_changed_value_never_panics() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("changed.glb");
    let (mut state, mut loads, mut refusals) = (11, 0, 0);
    for file in ["CesiumMan", "RiggedSimple", "Fox"] {
        let bytes = fs::read(data.join(format!("characters/khronos/{file}.glb"))).unwrap();
        let end = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let json: Value = serde_json::from_slice(&bytes[20..end]).unwrap();
        for round in 0..250 {
            let mut json = json.clone();
            let place = somewhere(&mut json, &mut state);
            *place = match round % 10 {
                0 => Value::Null,
                1 => 0.into(),
                2 => 1.into(),
                3 => (-1).into(),
                4 => u32::MAX.into(),
                5 => u64::MAX.into(),
                6 => (1_u32 << 22).into(),
                7 => 1e300.into(),
                8 => "x".into(),
                _ => Value::Array(Vec::new()),
            };
            fs::write(&path, with_json(&bytes, &json)).unwrap();
            match element(&path) {
                Some(_) => refusals += 1,
                None => loads += 1,
            }
        }
    }
    println!("{loads} load, {refusals} are refused");
    assert!(loads > 0 && refusals > 0);
}

#[test]
fn characters_load_with_the_counts_of_their_notices() {
    let Some(data) = data() else { return };
    let table = [
        ("khronos/CesiumMan.glb", 3273, 4672, 19, 1),
        ("khronos/Fox.glb", 1728, 576, 24, 3),
        ("khronos/RiggedFigure.glb", 370, 256, 19, 1),
        ("khronos/RiggedSimple.glb", 96, 188, 2, 1),
        ("khronos/SimpleSkin.gltf", 10, 8, 2, 1),
        ("mesh2motion/horse-animations.glb", 2146, 3414, 56, 14),
        ("mesh2motion/shark-animations.glb", 3514, 6576, 33, 7),
        ("mesh2motion/human-male.glb", 7399, 13757, 66, 0),
        ("mesh2motion/human-sintel.glb", 25413, 41306, 66, 0),
    ];
    for (file, vertices, triangles, joints, clips) in table {
        let model = asset::load(&data.join("characters").join(file)).unwrap();
        check(&model);
        println!("{file}: {:?} {:?}", model.extensions, model.warnings);
        let counts = (
            model.positions.len(),
            model.triangles.len(),
            model.joints.len(),
            model.clips.len(),
        );
        assert_eq!(counts, (vertices, triangles, joints, clips), "{file}");
        assert!(
            model.influences.iter().all(|list| !list.is_empty()),
            "{file}"
        );
        assert!(model.clips.iter().all(|clip| clip.seconds > 0.0), "{file}");
        if file.ends_with("CesiumMan.glb") {
            assert!(model.warnings.iter().any(|w| w.contains("least sum 0.185")));
        }
    }
}
