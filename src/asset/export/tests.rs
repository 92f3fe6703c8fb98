//! Tests of the writers: what they write is read back by other code.
#![allow(clippy::unwrap_used)]

use std::{fs, io, path::Path};

use glam::{Mat4, Quat, Vec3};

use super::*;
use crate::{
    Error,
    asset::{
        Channel, Clip, Influence, Interpolation, Joint, Model, Node, Primitive, Property, load,
    },
};

/// Two quads of two primitives, ten joints, nine influences on one vertex, a mirrored and scaled skeleton, two clips.
fn model() -> Model {
    let node = |row: usize| Node {
        name: format!("joint {row}"),
        parent: row.checked_sub(1),
        translation: Vec3::new(0.1, row as f32, 1.0 / 3.0),
        rotation: Quat::from_rotation_x(0.3 * row as f32),
        scale: Vec3::new(1.0, -2.0, 0.7),
        matrix: (row == 4).then(|| Mat4::from_rotation_y(0.4)),
    };
    let node = |row| {
        let node = node(row);
        match node.matrix {
            Some(_) => Node {
                translation: Vec3::ZERO,
                rotation: Quat::IDENTITY,
                scale: Vec3::ONE,
                ..node
            },
            None => node,
        }
    };
    let joint = |row: usize| Joint {
        name: format!("joint {}", row + 1),
        node: row + 1,
        parent: row.checked_sub(1),
        inverse_bind: Mat4::from_scale(Vec3::new(-1.0, 2.0, 0.3 + row as f32)),
    };
    let channel = |node, property, interpolation, values: usize| Channel {
        node,
        property,
        interpolation,
        times: vec![0.0, 0.1, 2.5],
        values: match property {
            Property::Rotation => [0.0, 0.6, 0.0, 0.8].repeat(values / 4),
            _ => (0..values).map(|i| i as f32 / 7.0).collect(),
        },
    };
    let clip = |name: &str, channels| Clip {
        name: name.into(),
        seconds: 2.5,
        channels,
    };
    let primitive = |name: &str, vertex, triangle| Primitive {
        name: name.into(),
        vertices: vertex..vertex + 4,
        triangles: triangle..triangle + 2,
        base_color: [0.1, 0.2, 0.3, 1.0],
    };
    let corner = |i: usize| Vec3::new((i % 2) as f32, (i / 2) as f32 / 3.0, 0.1);
    let even = (0..9).map(|joint| Influence {
        joint,
        weight: 1.0 / 9.0,
    });
    let mut influences = vec![
        vec![Influence {
            joint: 9,
            weight: 1.0
        }];
        8
    ];
    influences[0] = even.collect();
    Model {
        positions: (0..8).map(corner).collect(),
        normals: vec![Vec3::Z; 8],
        triangles: vec![[0, 1, 2], [2, 1, 3], [4, 5, 6], [6, 5, 7]],
        primitives: vec![primitive("body/0", 0, 0), primitive("body/1", 4, 2)],
        influences,
        joints: (0..10).map(joint).collect(),
        nodes: (0..11).map(node).collect(),
        clips: vec![
            clip(
                "turn",
                vec![channel(2, Property::Rotation, Interpolation::Linear, 12)],
            ),
            clip(
                "move",
                vec![
                    channel(1, Property::Translation, Interpolation::CubicSpline, 27),
                    channel(1, Property::Scale, Interpolation::Step, 9),
                ],
            ),
        ],
        ..Model::default()
    }
}

/// All that a file can hold, as text.
fn text(model: &Model) -> String {
    let mut model = model.clone();
    model.path.clear();
    model.extensions.clear();
    model.warnings.clear();
    format!("{model:#?}")
}

#[track_caller]
fn assert_round_trip(model: &Model) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.glb");
    write_glb_skinned(&path, model).unwrap();
    // The crate's own validation, which is not ours.
    gltf::Gltf::from_slice(&fs::read(&path).unwrap()).unwrap();
    let (before, after) = (text(model), text(&load(&path).unwrap()));
    let differs = before.lines().zip(after.lines()).find(|(a, b)| a != b);
    assert!(before == after, "{differs:?}");
}

#[test]
fn a_skinned_model_reads_back_the_same() {
    assert_round_trip(&model());
    let mut bare = model();
    bare.influences.iter_mut().for_each(Vec::clear);
    bare.clips.clear();
    assert_round_trip(&bare);
}

#[test]
fn real_characters_read_back_the_same() {
    let folder = std::env::var_os("DERMIS_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"),
        Into::into,
    );
    let folder = folder.join("characters");
    if !folder.exists() {
        println!("skipped: no folder {}", folder.display());
        return;
    }
    for file in [
        "khronos/CesiumMan.glb",
        "khronos/Fox.glb",
        "khronos/SimpleSkin.gltf",
        "mesh2motion/horse-animations.glb",
    ] {
        assert_round_trip(&load(&folder.join(file)).unwrap());
    }
}

#[test]
fn a_model_that_does_not_fit_together_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.glb");
    let spoil: [fn(&mut Model); 6] = [
        |model| model.joints.clear(),
        |model| model.normals.truncate(3),
        |model| model.triangles[3] = [0, 5, 7],
        |model| model.influences[1][0].joint = 10,
        |model| model.nodes[1].parent = Some(5),
        |model| model.clips[0].channels[0].values.truncate(5),
    ];
    for spoil in spoil {
        let mut model = model();
        spoil(&mut model);
        let error = write_glb_skinned(&path, &model).unwrap_err();
        assert!(matches!(error, Error::Argument { .. }), "{error}");
        assert!(!path.exists());
    }
}

#[test]
fn a_morph_animation_holds_every_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("baked.glb");
    let model = model();
    let moved = |by: f32| -> Vec<Vec3> { model.positions.iter().map(|p| *p * by + by).collect() };
    let positions = [moved(1.0), moved(-2.0), moved(0.5)];
    let turned = vec![Vec3::X; 8];
    let frames: Vec<MorphFrame<'_>> = [0.0, 0.25, 0.5]
        .into_iter()
        .zip(&positions)
        .map(|(seconds, positions)| MorphFrame {
            seconds,
            positions,
            normals: if seconds == 0.0 {
                &model.normals
            } else {
                &turned
            },
        })
        .collect();
    let animation = MorphAnimation {
        method: "implicit",
        clip: "bend \"it\"",
        upright: Quat::from_rotation_z(1.0),
        frames: &frames,
    };
    write_glb_morph(&path, &model, &animation).unwrap();
    // Our own reader passes everything and misses the skin only.
    let error = load(&path).unwrap_err().to_string();
    assert!(error.contains("/skins: the file has no skin"), "{error}");

    let file = gltf::Gltf::from_slice(&fs::read(&path).unwrap()).unwrap();
    let blob = file.blob.as_deref().unwrap();
    let buffer = |_: gltf::Buffer<'_>| Some(blob);
    let node = file.nodes().next().unwrap();
    let (_, rotation, _) = node.transform().decomposed();
    assert_eq!(rotation, Quat::from_rotation_z(1.0).to_array());
    let clip = file.animations().next().unwrap();
    assert_eq!(clip.name(), Some("bend \"it\""));
    let channel = clip.channels().next().unwrap();
    let reader = channel.reader(buffer);
    assert!(reader.read_inputs().unwrap().eq([0.0, 0.25, 0.5]));
    let gltf::animation::util::ReadOutputs::MorphTargetWeights(weights) =
        reader.read_outputs().unwrap()
    else {
        panic!("no weights")
    };
    let weights: Vec<f32> = weights.into_f32().collect();
    assert_eq!(weights, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let mesh = file.meshes().next().unwrap();
    for (number, primitive) in mesh.primitives().enumerate() {
        let reader = primitive.reader(buffer);
        let base: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!(indices, [0, 1, 2, 2, 1, 3]);
        let targets = reader.read_morph_targets();
        for ((moved, turned, _), frame) in targets.zip(&frames) {
            let rows = base.iter().zip(moved.unwrap()).zip(turned.unwrap());
            for (row, ((base, moved), turned)) in rows.enumerate() {
                let row = 4 * number + row;
                let position = Vec3::from(*base) + Vec3::from(moved);
                assert!(position.abs_diff_eq(frame.positions[row], 1e-6));
                assert_eq!(Vec3::Z + Vec3::from(turned), frame.normals[row]);
            }
        }
    }

    let mut bad = positions[1].clone();
    bad[3].y = f32::NAN;
    let mut frames = frames.clone();
    frames[1].positions = &bad;
    let animation = MorphAnimation {
        frames: &frames,
        ..animation
    };
    let error = write_glb_morph(&path, &model, &animation).unwrap_err();
    assert!(error.to_string().contains("frame 1: vertex 3"), "{error}");
}

fn frame<'a>(positions: &'a [Vec3], scalars: &'a [f32]) -> PlyFrame<'a> {
    PlyFrame {
        positions,
        normals: positions,
        field: scalars,
        iso: scalars,
        state: &[0, 1, 4],
        bone: &[7, 8, 0x1234],
        triangles: &[[0, 1, 2]],
        method: "lbs",
        clip: "two\nlines",
        time: 0.5,
        device: "cpu",
    }
}

const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 2.0, -3.5)];

#[test]
fn ply_has_the_layout_of_its_header() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frame.ply");
    write_ply(&path, &frame(&CORNERS, &[0.25, 0.5, 0.75])).unwrap();
    let bytes = fs::read(&path).unwrap();
    let end = bytes
        .windows(11)
        .position(|w| w == b"end_header\n")
        .unwrap()
        + 11;
    let header = "ply\nformat binary_little_endian 1.0\n\
        comment dermis method=lbs clip=two lines time=0.5 device=cpu\nelement vertex 3\n\
        property float x\nproperty float y\nproperty float z\n\
        property float nx\nproperty float ny\nproperty float nz\n\
        property float field\nproperty float iso\nproperty uchar state\nproperty ushort bone\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    assert_eq!(std::str::from_utf8(&bytes[..end]).unwrap(), header);
    assert_eq!(bytes.len() - end, 3 * 35 + 13);
    let last = &bytes[end + 70..end + 105];
    assert_eq!(last[8..12], (-3.5_f32).to_le_bytes());
    assert_eq!(last[24..28], 0.75_f32.to_le_bytes());
    assert_eq!(last[32..], [4, 0x34, 0x12]);
    assert_eq!(bytes[end + 105..], [3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    let error = write_ply(&path, &frame(&CORNERS, &[0.0])).unwrap_err();
    assert_eq!(error.to_string(), "field: 1 rows for 3 positions");
}

#[test]
fn obj_counts_from_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frame.obj");
    write_obj(&path, &frame(&CORNERS, &[0.0; 3])).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("\nv 1 2 -3.5\n") && text.contains("\nvn 1 0 0\n"));
    assert!(text.ends_with("f 1//1 2//2 3//3\n"));
}

#[test]
fn a_failed_write_leaves_everything_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("kept.txt");
    write_atomic(&path, |file| file.write_all(b"old")).unwrap();
    let error = write_atomic(&path, |file| {
        file.write_all(&[b'n'; 1 << 20])?;
        Err(io::ErrorKind::StorageFull.into())
    });
    let Err(Error::File { path: named, .. }) = error else {
        panic!("{error:?}")
    };
    assert_eq!(named, path);
    assert_eq!(fs::read(&path).unwrap(), b"old");
    let names = fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(names, 1);
    write_atomic(&path, |file| file.write_all(b"new")).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
    assert!(write_atomic(folder.path(), |_| Ok(())).is_err());
    assert!(write_atomic(&folder.path().join("no/such"), |_| Ok(())).is_err());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_an_error() {
    let error = write_obj(Path::new("/dev/full"), &frame(&CORNERS, &[0.0; 3])).unwrap_err();
    let Error::File { source, .. } = error else {
        panic!("{error}")
    };
    assert_eq!(source.kind(), io::ErrorKind::StorageFull);
}
