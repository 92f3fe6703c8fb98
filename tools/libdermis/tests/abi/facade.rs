//! What Rust's façade can be asked for can be asked for in C, and gives the same bits.
// Pointers are to what lives until the call returns.
#![allow(clippy::undocumented_unsafe_blocks)]

use std::{
    ffi::{CStr, CString},
    ptr::null,
    sync::Arc,
};

use dermis::{
    asset::{self, Model},
    capi::{dm_result::*, *},
    compose::{Controller, Form, Level, OpeningCurve, Operator, Profile},
    deformer::{Deformer, Device, Method, Settings, Skin},
    flesh::Map,
    rig::{Options, Pose, Primitive, Rig, SpineChain},
};

use crate::{calls, fine, last_error, raw, skin};

pub(crate) fn load(name: &str) -> (Model, CString) {
    let path = crate::root().join("assets").join(name);
    let text = CString::new(path.to_str().unwrap()).unwrap();
    (asset::load(&path).unwrap(), text)
}

pub(crate) fn defaults() -> dm_rig_options {
    unsafe {
        let mut options: dm_rig_options = std::mem::zeroed();
        options.size = size_of::<dm_rig_options>() as u32;
        fine(dm_rig_options_default(&mut options));
        options
    }
}

fn joint(name: &'static CStr) -> dm_joint_options {
    let mut joint: dm_joint_options = unsafe { std::mem::zeroed() };
    (joint.size, joint.name) = (size_of::<dm_joint_options>() as u32, name.as_ptr());
    joint
}

/// The skin of a bent arm, by Rust on the CPU.
fn by_rust(model: &Model, options: &Options, method: Method) -> Skin {
    let rig = Arc::new(Rig::prepare(model, options, &|_| {}).unwrap());
    let settings = Settings {
        method,
        ..Settings::default()
    };
    let mut deformer = Deformer::new(&Device::Cpu, rig.clone(), &settings).unwrap();
    let pose = Pose::from_clip(model, &rig.skeleton, 0, 0.8).unwrap();
    deformer.advance(&pose).unwrap();
    deformer.wait().unwrap();
    deformer.read().unwrap()
}

/// The same by C.
fn by_c(path: &CStr, options: &dm_rig_options, method: u32) -> Skin {
    let mut rig = dm_rig::default();
    fine(unsafe { dm_rig_load(path.as_ptr(), options, &mut rig) });
    let context = skin::context(&calls::cpu());
    let deformer = skin::deformer(context, rig, method);
    let joints = skin::info(rig).joints as usize;
    let mut pose = vec![0.0; 16 * joints];
    fine(unsafe { dm_rig_pose_clip(rig, 0, 0.8, pose.as_mut_ptr(), joints) });
    skin::advance(deformer, &pose);
    fine(dm_deformer_wait(deformer));
    let read = skin::read(deformer, skin::info(rig).vertices);
    fine(dm_deformer_destroy(deformer));
    fine(dm_rig_destroy(rig));
    fine(dm_context_destroy(context));
    read
}

/// Both give the same, and not what the defaults give.
fn same(options: &Options, c: &dm_rig_options, method: Method, number: u32) {
    let (model, path) = load("arm.glb");
    let wanted = by_rust(&model, options, method);
    assert!(by_c(&path, c, number) == wanted);
    assert!(wanted != by_rust(&model, &Options::default(), method));
}

const POINTS: [f32; 6] = [-0.5, 0.1, 0.2, 0.9, 0.8, 0.3];
const PAIRS: [(f32, f32); 3] = [(-0.5, 0.1), (0.2, 0.9), (0.8, 0.3)];

#[test]
fn operators_and_openings_of_joints_are_the_facades() {
    let name = || "lower".to_owned();
    for (op, operator) in [
        (DM_OPERATOR_BLEND, Operator::Blend),
        (DM_OPERATOR_BULGE, Operator::Bulge),
    ] {
        for (opening, curve) in [
            (DM_CURVE_ELBOW, OpeningCurve::elbow()),
            (DM_CURVE_FINGER, OpeningCurve::finger()),
            (
                DM_CURVE_POINTS,
                OpeningCurve::new(PAIRS, [2.0, 1.0]).unwrap(),
            ),
        ] {
            let joint = dm_joint_options {
                op,
                opening,
                opening_points: POINTS,
                opening_exponents: [2.0, 0.0],
                ..joint(c"lower")
            };
            let mut c = defaults();
            (c.joints, c.joint_count, c.magnitude) = (&joint, 1, 1.5);
            let options = Options {
                joints: vec![(name(), operator)],
                openings: vec![(name(), curve)],
                magnitude: 1.5,
                ..Options::default()
            };
            same(&options, &c, Method::Implicit, DM_IMPLICIT);
        }
    }
}

#[test]
fn controllers_and_rigid_joints_are_the_facades() {
    let name = || "lower".to_owned();
    for (controller, curve) in [
        (DM_CURVE_ELBOW, Controller::elbow()),
        (DM_CURVE_FINGER, Controller::finger()),
        (DM_CURVE_NEVER, Controller::never()),
        (DM_CURVE_POINTS, Controller::new(PAIRS, [1.0, 3.0]).unwrap()),
    ] {
        let joint = dm_joint_options {
            op: DM_OPERATOR_BULGE,
            controller,
            controller_points: POINTS,
            controller_exponents: [0.0, 3.0],
            ..joint(c"lower")
        };
        let mut c = defaults();
        (c.joints, c.joint_count) = (&joint, 1);
        let options = Options {
            joints: vec![(name(), Operator::Bulge)],
            controllers: vec![(name(), curve)],
            ..Options::default()
        };
        same(&options, &c, Method::Tracking, DM_TRACKING);
    }
    let joint = dm_joint_options {
        rigid: 1,
        ..joint(c"lower")
    };
    let mut c = defaults();
    (c.joints, c.joint_count) = (&joint, 1);
    let options = Options {
        rigid: vec![name()],
        ..Options::default()
    };
    same(&options, &c, Method::Tracking, DM_TRACKING);
}

#[test]
fn profiles_from_memory_and_from_files_are_the_facades() {
    let levels = [0.0, 0.7].map(|depth| Level {
        depth,
        surface: vec![[0.0, 0.5], [0.3, 0.5 + 0.2 * depth], [0.5, 0.5], [0.5, 0.0]],
        contact: vec![[0.5, 0.5], [0.5 + 0.4 * depth, 0.5 + 0.4 * depth]],
    });
    let depths = [0.0, 0.7];
    let surfaces: Vec<[f64; 2]> = levels.iter().flat_map(|l| l.surface.clone()).collect();
    let contacts: Vec<[f64; 2]> = levels.iter().flat_map(|l| l.contact.clone()).collect();
    let profile = dm_profile {
        size: size_of::<dm_profile>() as u32,
        form: DM_PROFILE_POLYLINE,
        levels: 2,
        surface_points: 4,
        contact_points: 2,
        depths: depths.as_ptr(),
        surfaces: surfaces.as_ptr().cast(),
        contacts: contacts.as_ptr().cast(),
    };
    let joint = dm_joint_options {
        op: DM_OPERATOR_PROFILE,
        ..joint(c"lower")
    };
    let mut c = defaults();
    (c.joints, c.joint_count, c.profile) = (&joint, 1, &profile);
    let mut options = Options {
        joints: vec![("lower".into(), Operator::Profile)],
        profile: Some(Profile::new(Form::Polyline, levels.into()).unwrap()),
        ..Options::default()
    };
    same(&options, &c, Method::Tracking, DM_TRACKING);
    let file = crate::root().join("assets/profile.json");
    let text = CString::new(file.to_str().unwrap()).unwrap();
    (c.profile, c.profile_file) = (null(), text.as_ptr());
    options.profile = Some(Profile::read(&file).unwrap());
    same(&options, &c, Method::Tracking, DM_TRACKING);
    // Wrong ones are named.
    let load = |options: &dm_rig_options| unsafe {
        dm_rig_load(raw::path().as_ptr(), options, &mut dm_rig::default())
    };
    c.profile = &profile;
    assert_eq!(load(&c), DM_ERROR_ARGUMENT, "{}", last_error());
    c.profile_file = null();
    for (wrong, code, named) in [
        (
            dm_profile { size: 8, ..profile },
            DM_ERROR_STRUCT_SIZE,
            "size",
        ),
        (dm_profile { form: 7, ..profile }, DM_ERROR_ARGUMENT, "form"),
        (
            dm_profile {
                levels: 0,
                ..profile
            },
            DM_ERROR_ARGUMENT,
            "level",
        ),
        (
            dm_profile {
                levels: !0,
                ..profile
            },
            DM_ERROR_ARGUMENT,
            "depths",
        ),
        (
            dm_profile {
                depths: null(),
                ..profile
            },
            DM_ERROR_NULL,
            "depths",
        ),
        (
            dm_profile {
                surfaces: null(),
                ..profile
            },
            DM_ERROR_NULL,
            "surfaces",
        ),
        (
            dm_profile {
                contacts: null(),
                ..profile
            },
            DM_ERROR_NULL,
            "contacts",
        ),
        (
            dm_profile {
                surface_points: 3,
                ..profile
            },
            DM_ERROR_ARGUMENT,
            "profile",
        ),
    ] {
        c.profile = &wrong;
        assert_eq!(load(&c), code, "{named}: {}", last_error());
        assert!(last_error().contains(named), "{named}: {}", last_error());
    }
    (c.profile, c.joint_count) = (&profile, 0);
    assert_eq!(load(&c), DM_ERROR_ARGUMENT, "{}", last_error());
    assert!(last_error().contains("DM_OPERATOR_PROFILE"));
}

/// The primitive of assets/biceps.json.
fn biceps() -> Primitive {
    let file = crate::root().join("assets/biceps.json");
    Primitive::read(&file).unwrap().remove(0)
}

#[test]
fn primitives_from_memory_and_from_files_are_the_facades() {
    let wanted = Primitive {
        along: Some(0.8),
        ..biceps()
    };
    let text = |text: &str| CString::new(text).unwrap();
    let (name, joint, driver) = (
        text(&wanted.name),
        text(&wanted.joint),
        text(&wanted.driver),
    );
    let primitive = dm_primitive {
        size: size_of::<dm_primitive>() as u32,
        radius: wanted.radius,
        name: name.as_ptr(),
        joint: joint.as_ptr(),
        driver: driver.as_ptr(),
        start: wanted.start,
        end: wanted.end,
        degrees: wanted.degrees,
        scale: wanted.scale,
        along: 0.8,
    };
    let mut c = defaults();
    (c.primitives, c.primitive_count) = (&primitive, 1);
    let options = |primitive| Options {
        primitives: vec![primitive],
        ..Options::default()
    };
    same(&options(wanted), &c, Method::Implicit, DM_IMPLICIT);
    let file = crate::root().join("assets/biceps.json");
    let text = CString::new(file.to_str().unwrap()).unwrap();
    let mut file = defaults();
    file.primitive_file = text.as_ptr();
    same(&options(biceps()), &file, Method::Tracking, DM_TRACKING);
    let load = |options: &dm_rig_options| unsafe {
        dm_rig_load(raw::path().as_ptr(), options, &mut dm_rig::default())
    };
    c.primitive_file = text.as_ptr();
    assert_eq!(load(&c), DM_ERROR_ARGUMENT, "{}", last_error());
    c.primitive_file = null();
    for (wrong, code, named) in [
        (
            dm_primitive {
                size: 0,
                ..primitive
            },
            DM_ERROR_STRUCT_SIZE,
            "size",
        ),
        (
            dm_primitive {
                name: null(),
                ..primitive
            },
            DM_ERROR_NULL,
            "name",
        ),
        (
            dm_primitive {
                joint: null(),
                ..primitive
            },
            DM_ERROR_NULL,
            "joint",
        ),
        (
            dm_primitive {
                driver: null(),
                ..primitive
            },
            DM_ERROR_NULL,
            "driver",
        ),
        (
            dm_primitive {
                driver: c"tail".as_ptr(),
                ..primitive
            },
            DM_ERROR_ARGUMENT,
            "tail",
        ),
        (
            dm_primitive {
                radius: f32::NAN,
                ..primitive
            },
            DM_ERROR_ARGUMENT,
            "radius",
        ),
        (
            dm_primitive {
                along: -1.0,
                ..primitive
            },
            DM_ERROR_ARGUMENT,
            "along",
        ),
    ] {
        c.primitives = &wrong;
        assert_eq!(load(&c), code, "{named}: {}", last_error());
        assert!(last_error().contains(named), "{named}: {}", last_error());
    }
    c.primitives = null();
    assert_eq!(load(&c), DM_ERROR_NULL, "{}", last_error());
}

#[test]
fn spines_are_the_facades() {
    let chain = dm_spine_chain {
        size: size_of::<dm_spine_chain>() as u32,
        map: DM_MAP_NORMAL,
        root: c"upper".as_ptr(),
        tip: c"lower".as_ptr(),
    };
    let mut c = defaults();
    (c.spines, c.spine_count) = (&chain, 1);
    let options = Options {
        spines: vec![SpineChain {
            root: "upper".into(),
            tip: "lower".into(),
            map: Map::Normal,
        }],
        ..Options::default()
    };
    same(&options, &c, Method::Dqs, DM_DQS);
    let null = null();
    let (name, tip) = (DM_ERROR_NULL, c"wing".as_ptr());
    for (wrong, code, named) in [
        (
            dm_spine_chain { size: 8, ..chain },
            DM_ERROR_STRUCT_SIZE,
            "size",
        ),
        (
            dm_spine_chain {
                root: null,
                ..chain
            },
            name,
            "root",
        ),
        (dm_spine_chain { tip: null, ..chain }, name, "tip"),
        (dm_spine_chain { map: 3, ..chain }, DM_ERROR_ARGUMENT, "map"),
        (dm_spine_chain { tip, ..chain }, DM_ERROR_ARGUMENT, "wing"),
    ] {
        c.spines = &wrong;
        let result = unsafe { dm_rig_load(raw::path().as_ptr(), &c, &mut dm_rig::default()) };
        assert_eq!(result, code, "{named}: {}", last_error());
        assert!(last_error().contains(named), "{named}: {}", last_error());
    }
}

#[test]
fn parts_are_the_callers() {
    let (model, _) = load("arm.glb");
    let parts = vec![1u16; model.positions.len()];
    let mut c = defaults();
    (c.parts, c.part_count) = (parts.as_ptr(), parts.len() as u32);
    let options = Options {
        part: Some(parts.clone()),
        ..Options::default()
    };
    same(&options, &c, Method::Implicit, DM_IMPLICIT);
    c.part_count = 3;
    let rig = &mut dm_rig::default();
    let result = unsafe { dm_rig_load(raw::path().as_ptr(), &c, rig) };
    assert_eq!(result, DM_ERROR_ARGUMENT, "{}", last_error());
}

#[test]
fn painted_rigidity_of_arrays_is_the_facades() {
    let (mut model, path) = load("arm.glb");
    let rows = model.positions.len();
    let mesh = raw::Mesh::of(&model);
    let mut rigid = vec![0.0; rows];
    rigid[rows / 2..].fill(1.0);
    let mut desc = mesh.desc();
    desc.rigid = rigid.as_ptr();
    let mut rig = dm_rig::default();
    fine(unsafe { dm_rig_create(&desc, null(), &mut rig) });
    let mut file = dm_rig::default();
    fine(unsafe { dm_rig_load(path.as_ptr(), null(), &mut file) });
    let context = skin::context(&calls::cpu());
    let poses = skin::poses(file);
    let painted = skin::by_c(context, rig, &poses[..1], DM_TRACKING);
    model.rigid = rigid.clone();
    let made = Arc::new(Rig::prepare(&model, &Options::default(), &|_| {}).unwrap());
    let settings = Settings {
        method: Method::Tracking,
        ..Settings::default()
    };
    let mut deformer = Deformer::new(&Device::Cpu, made.clone(), &settings).unwrap();
    let pose = Pose::from_clip(&model, &made.skeleton, 0, skin::TIMES[0]).unwrap();
    deformer.advance(&pose).unwrap();
    assert!(painted[0] == deformer.read().unwrap());
    assert!(painted != skin::by_c(context, file, &poses[..1], DM_TRACKING));
    rigid[2] = 1.5;
    desc.rigid = rigid.as_ptr();
    let refused = unsafe { dm_rig_create(&desc, null(), &mut dm_rig::default()) };
    assert_eq!(refused, DM_ERROR_ARGUMENT, "{}", last_error());
    assert!(last_error().contains("rigid: row 2"), "{}", last_error());
    for handle in [rig, file] {
        fine(dm_rig_destroy(handle));
    }
    fine(dm_context_destroy(context));
}
