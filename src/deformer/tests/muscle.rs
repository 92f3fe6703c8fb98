//! Extra primitives as the passes get them: scaled with the bend of their driver, and as one with nothing while they swell.

use std::{path::Path, sync::Arc};

use bytemuck::cast_slice;
use glam::{Mat4, Vec3, Vec4};

use crate::{
    deformer::{Method, Settings, pose::PoseUpload, statics::Statics},
    field::atlas_layout,
    layout::{FieldPose, FieldsHead, NO_MOTION},
    rig::{Options, Pose, Primitive, Rig},
};

fn arm() -> Arc<Rig> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let model = crate::asset::load(&assets.join("arm.glb")).unwrap();
    let options = Options {
        primitives: Primitive::read(&assets.join("biceps.json")).unwrap(),
        ..Options::default()
    };
    Arc::new(Rig::prepare(&model, &options, &|_| {}).unwrap())
}

/// The elbow bent by an angle, and the whole arm turned.
fn bent(rig: &Rig, degrees: f32, turn: f32) -> Pose {
    let local = [
        Mat4::from_rotation_y(turn),
        Mat4::from_rotation_z(degrees.to_radians()),
    ];
    Pose::from_local(&rig.skeleton, &local).unwrap()
}

/// The last slice's fields, by row of the rig.
fn posed(rig: &Rig, statics: &Statics, poses: [Option<&Pose>; 2]) -> Vec<FieldPose> {
    let layout = atlas_layout(rig.fields.len(), 2048).unwrap();
    let mut upload = PoseUpload::default();
    upload.push(rig, statics, &layout, poses[0], poses[1].unwrap());
    let fields: &[FieldPose] = cast_slice(&upload.last_fields()[size_of::<FieldsHead>()..]);
    let mut rows: Vec<(u32, FieldPose)> =
        statics.order.iter().copied().zip(fields.to_vec()).collect();
    rows.sort_by_key(|r| r.0);
    rows.into_iter().map(|r| r.1).collect()
}

#[test]
fn a_posed_primitive_is_scaled_about_its_centre_and_carried_by_its_joint() {
    let rig = arm();
    let statics = Statics::new(&rig, &Settings::default()).unwrap();
    let primitive = &rig.primitives[0];
    assert_eq!((rig.fields.len(), rig.fields[2].joint), (3, 0));
    for (degrees, scale) in [(0.0, 1.0), (60.0, 1.375), (90.0, 1.5625), (150.0, 1.75)] {
        let pose = bent(&rig, degrees, 0.4);
        let field = posed(&rig, &statics, [None, Some(&pose)])[2];
        let rows = field.rows.map(Vec4::from_array);
        for offset in [Vec3::Y * 0.03, Vec3::Z * 0.02, Vec3::X * 0.1, Vec3::ZERO] {
            let swollen = primitive.centre + offset * Vec3::new(1.0, scale, scale);
            let x = pose.matrices[0].transform_point3(swollen).extend(1.0);
            let there = Vec3::from_array(rows.map(|r| r.dot(x)));
            let unscaled = primitive.centre + offset;
            let here = rig.fields[2].bounds.from_rest().transform_point3(unscaled);
            assert!(
                there.distance(here) < 1e-4,
                "{degrees} {offset}: {there} {here}"
            );
        }
    }
}

#[test]
fn a_swelling_primitive_moves_like_nothing_else() {
    let rig = arm();
    for method in [Method::Implicit, Method::Tracking] {
        let settings = Settings {
            method,
            ..Settings::default()
        };
        let statics = Statics::new(&rig, &settings).unwrap();
        let motions = |before: Option<&Pose>, pose: &Pose| {
            let fields = posed(&rig, &statics, [before, Some(pose)]);
            fields.iter().map(|f| f.tile >> 24).collect::<Vec<_>>()
        };
        let (rest, turned) = (bent(&rig, 0.0, 0.0), bent(&rig, 0.0, 0.4));
        assert_eq!(motions(None, &rest), [0, 0, 0]);
        assert_eq!(motions(None, &turned), [0, 0, 0]);
        let half = bent(&rig, 45.0, 0.0);
        assert_eq!(motions(None, &half), [0, 1, NO_MOTION]);
        // From pose to pose: nothing but the whole arm turns, the elbow bends on, the muscle is at its thickest.
        assert_eq!(motions(Some(&half), &bent(&rig, 45.0, 0.4)), [0, 0, 0]);
        assert_eq!(motions(Some(&half), &bent(&rig, 50.0, 0.4))[2], NO_MOTION);
        let [far, further] = [130.0, 150.0].map(|d| bent(&rig, d, 0.0));
        assert_eq!(motions(Some(&far), &further), [0, 1, 0]);
    }
}
