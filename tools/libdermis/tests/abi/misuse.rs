//! Every function refuses what is wrong with the right code, and never crashes.

use std::{
    ffi::c_char,
    ptr::{null, null_mut},
    thread,
};

use dermis::capi::{dm_result::*, *};

use crate::{
    calls::{Arguments, CALLS, Call, MAY_BE_ZERO, SECOND, Storage, Takes, cpu},
    fine,
    flesh_calls::{FLESH_CALLS, make},
    last_error, raw,
    sphere_calls::SPHERE_CALLS,
};

/// A context on the CPU, the arm, and a tracked deformer.
fn arguments() -> Arguments {
    let (mut context, mut rig) = (dm_context::default(), dm_rig::default());
    let mut deformer = dm_deformer::default();
    let mut info = dm_rig_info {
        size: size_of::<dm_rig_info>() as u32,
        ..Default::default()
    };
    // SAFETY: all pointers are NULL where that is allowed, or to what lives until the call returns.
    unsafe {
        fine(dm_context_create(&cpu(), &mut context));
        fine(dm_rig_load(raw::path().as_ptr(), null(), &mut rig));
        fine(dm_rig_get_info(rig, &mut info));
        let mut settings: dm_settings = std::mem::zeroed();
        settings.size = size_of::<dm_settings>() as u32;
        fine(dm_settings_default(&mut settings));
        settings.method = DM_TRACKING;
        fine(dm_deformer_create(context, rig, &settings, &mut deformer));
        let mut needed = 0;
        fine(dm_deformer_save(deformer, null_mut(), 0, &mut needed));
        let mut bytes = vec![0; needed];
        let out = bytes.as_mut_ptr().cast();
        fine(dm_deformer_save(deformer, out, needed, null_mut()));
        let identity = glam::Mat4::IDENTITY.to_cols_array();
        let storage = Storage {
            numbers: identity.repeat(info.joints as usize),
            indices: vec![0; 3 * info.triangles as usize],
            bytes,
            joints: info.joints as usize,
            vertices: info.vertices,
            needed,
        };
        let mut arguments = Arguments::new((context, rig, deformer), storage);
        (arguments.spine, arguments.flesh) = make();
        arguments.fill_spheres();
        arguments
    }
}

fn run(call: &Call, arguments: &mut Arguments) -> dm_result {
    arguments.begin();
    // SAFETY: see `calls`.
    unsafe { (call.run)(arguments) }
}

fn refused(call: &Call, arguments: &mut Arguments, wanted: dm_result) {
    assert_eq!(run(call, arguments), wanted, "{}", call.name);
    let message = last_error();
    let (name, reason) = message.split_once(": ").unwrap();
    assert_eq!(name, call.name, "{message}");
    assert!(reason.len() > 8, "{message}");
}

fn destroys(call: &Call) -> bool {
    call.name.ends_with("_destroy")
}

/// Each pointer is NULL and each size is wrong in turn, everything else being right.
pub(crate) fn sweep_arguments(call: &Call, a: &mut Arguments) {
    fine(run(call, a));
    let asked = a.asked();
    let mut refusing = 0;
    for row in 0..asked.pointers {
        a.null = Some(row);
        let result = run(call, a);
        if a.asked().optional {
            fine(result);
        } else {
            refusing += 1;
            refused(call, a, DM_ERROR_NULL);
            assert!(last_error().contains("NULL"), "{}", last_error());
        }
    }
    a.null = None;
    assert_eq!(refusing > 0, call.pointer, "{}", call.name);
    assert_eq!(asked.sizes > 0, call.sized, "{}", call.name);
    for row in 0..asked.sizes {
        for size in [0, 1, 3, 1000, u32::MAX] {
            a.size = Some((row, size));
            refused(call, a, DM_ERROR_STRUCT_SIZE);
            assert!(last_error().contains(&size.to_string()));
        }
    }
    a.size = None;
    // Still usable.
    fine(run(call, a));
}

/// A handle of each kind, by kind.
fn handle(a: &mut Arguments, kind: Takes) -> Option<&mut u64> {
    match kind {
        Takes::Nothing => None,
        Takes::Context => Some(&mut a.context.id),
        Takes::Rig => Some(&mut a.rig.id),
        Takes::Deformer => Some(&mut a.deformer.id),
        Takes::Output => Some(&mut a.output.id),
        Takes::Spine => Some(&mut a.spine.id),
        Takes::Flesh => Some(&mut a.flesh.id),
        Takes::SphereMesh => Some(&mut a.mesh.id),
        Takes::Level => Some(&mut a.level.id),
        Takes::Collider => Some(&mut a.collider.id),
        Takes::Particles => Some(&mut a.particles.id),
    }
}

/// Each handle is zero, of another kind, of another number, in turn.
pub(crate) fn sweep_handles(call: &Call, a: &mut Arguments) {
    let all = [
        a.context.id,
        a.rig.id,
        a.deformer.id,
        a.output.id,
        a.spine.id,
        a.flesh.id,
        a.mesh.id,
        a.level.id,
        a.collider.id,
        a.particles.id,
    ];
    let second = SECOND.iter().find(|s| s.0 == call.name).map(|s| s.1);
    for kind in std::iter::once(call.handle).chain(second) {
        let Some(own) = handle(a, kind).map(|id| *id) else {
            continue;
        };
        let foreign = all.into_iter().filter(|id| *id != own);
        let never = [0, 1, own + 1, own ^ 1 << 40, own ^ 1 << 63, u64::MAX];
        for id in foreign.chain(never) {
            // A frame may have no output, a spine no rest.
            if Some(kind) == second && MAY_BE_ZERO.contains(&call.name) && id == 0 {
                continue;
            }
            *handle(a, kind).unwrap() = id;
            refused(call, a, DM_ERROR_HANDLE);
        }
        *handle(a, kind).unwrap() = own;
    }
}

#[test]
fn every_function_refuses_what_is_wrong() {
    let mut a = arguments();
    let all = || CALLS.iter().chain(FLESH_CALLS).chain(SPHERE_CALLS);
    for call in all().filter(|call| !destroys(call)) {
        sweep_arguments(call, &mut a);
    }
    for call in all() {
        sweep_handles(call, &mut a);
    }
    // In any order: what a deformer needs lives on.
    fine(dm_context_destroy(a.context));
    fine(dm_rig_destroy(a.rig));
    let advance = CALLS.iter().find(|c| c.name == "dm_deformer_advance");
    fine(run(advance.unwrap(), &mut a));
    fine(dm_deformer_destroy(a.deformer));
    fine(dm_spine_destroy(a.spine));
    fine(dm_flesh_destroy(a.flesh));
    // Those that were made of others, after them.
    fine(dm_sphere_mesh_destroy(a.mesh));
    fine(dm_level_destroy(a.level));
    for name in ["dm_collider_sweep", "dm_particles_advance"] {
        let call = SPHERE_CALLS.iter().find(|c| c.name == name);
        fine(run(call.unwrap(), &mut a));
    }
    fine(dm_collider_destroy(a.collider));
    fine(dm_particles_destroy(a.particles));
    for call in all().filter(|call| call.handle != Takes::Nothing) {
        refused(call, &mut a, DM_ERROR_HANDLE);
    }
}

#[test]
fn arguments_are_named() {
    let a = arguments();
    let refuse = |result: dm_result, wanted: dm_result, named: &str| {
        assert_eq!(result, wanted, "{}", last_error());
        assert!(last_error().contains(named), "{named}: {}", last_error());
    };
    let count = a.storage.joints;
    let mut numbers = a.storage.numbers.clone();
    let mut needed = 0;
    let mut text = [0; 2];
    let mut context = dm_context::default();
    let create = |desc: dm_context_desc, out: &mut dm_context| {
        // SAFETY: both live until the call returns.
        unsafe { dm_context_create(&desc, out) }
    };
    let desc = dm_context_desc {
        api_version: 2,
        ..cpu()
    };
    refuse(create(desc, &mut context), DM_ERROR_VERSION, "api_version");
    let desc = dm_context_desc {
        flags: 1 << 20,
        ..cpu()
    };
    refuse(create(desc, &mut context), DM_ERROR_ARGUMENT, "desc.flags");
    assert_eq!(context, dm_context::default());
    // SAFETY: pointers are NULL or to what lives until the call returns, as long as is said.
    unsafe {
        let out = numbers.as_mut_ptr();
        let short = dm_rig_pose_clip(a.rig, 0, 0.0, out, count - 1);
        refuse(short, DM_ERROR_SIZE, &count.to_string());
        let clip = dm_rig_pose_clip(a.rig, 99, 0.0, out, count);
        refuse(clip, DM_ERROR_ARGUMENT, "clip");
        let time = dm_rig_pose_clip(a.rig, 0, f32::NAN, out, count);
        refuse(time, DM_ERROR_ARGUMENT, "time");
        let joint = dm_rig_joint(a.rig, c"wing".as_ptr(), &mut 0);
        refuse(joint, DM_ERROR_ARGUMENT, "wing");
        let name = dm_rig_joint_name(a.rig, 0, text.as_mut_ptr(), 2, &mut needed);
        refuse(name, DM_ERROR_SIZE, &needed.to_string());
        let name = dm_rig_joint_name(a.rig, 999, text.as_mut_ptr(), 2, &mut needed);
        refuse(name, DM_ERROR_ARGUMENT, "joint");
        let path = dm_rig_load(c"no/such.glb".as_ptr(), null(), &mut dm_rig::default());
        refuse(path, DM_ERROR_FILE, "no/such.glb");
        let path = dm_rig_load(c"\xff".as_ptr(), null(), &mut dm_rig::default());
        refuse(path, DM_ERROR_ARGUMENT, "path");
        let advance = dm_deformer_advance(a.deformer, out, count + 1);
        refuse(advance, DM_ERROR_SIZE, "count");
        numbers[16] = f32::NAN;
        let advance = dm_deformer_advance(a.deformer, numbers.as_ptr(), count);
        refuse(advance, DM_ERROR_POSE, "joint");
        let state = dm_deformer_restore(a.deformer, text.as_ptr().cast(), 2);
        refuse(state, DM_ERROR_ARGUMENT, "state");
        let mut options: dm_rig_options = std::mem::zeroed();
        options.size = size_of::<dm_rig_options>() as u32;
        options.joint_count = 1;
        let mut joint: dm_joint_options = std::mem::zeroed();
        joint.size = size_of::<dm_joint_options>() as u32;
        (joint.op, joint.name) = (9, c"lower".as_ptr());
        options.joints = &joint;
        let load = |options| dm_rig_load(raw::path().as_ptr(), options, &mut dm_rig::default());
        refuse(load(&options), DM_ERROR_ARGUMENT, "options.joints.op");
        let mut settings: dm_settings = std::mem::zeroed();
        settings.size = size_of::<dm_settings>() as u32;
        let made = dm_deformer_create(a.context, a.rig, &settings, &mut dm_deformer::default());
        refuse(made, DM_ERROR_ARGUMENT, "sigma");
    }
    fine(dm_deformer_destroy(a.deformer));
    fine(dm_rig_destroy(a.rig));
    fine(dm_context_destroy(a.context));
}

/// One a vertex of the tube, and more.
static WEIGHTS: [f32; 999] = [1.0; 999];
static JOINTS: [u16; 999] = [0; 999];
/// Shared by threads that only read the pointer.
struct Names([*const c_char; 1]);
// SAFETY: nobody follows the pointer, which is NULL.
unsafe impl Sync for Names {}
static NAMES: Names = Names([null()]);

#[test]
fn arrays_that_cannot_be_used_are_refused() {
    type Spoil = fn(&mut raw::Mesh, &mut dm_mesh_desc);
    let spoiled: [(Spoil, dm_result, &str); 16] = [
        (|_, d| d.vertices = 0, DM_ERROR_ARGUMENT, "desc.vertices"),
        (
            |_, d| d.vertices = u32::MAX,
            DM_ERROR_ARGUMENT,
            "desc.vertices",
        ),
        (
            |_, d| d.triangles = u32::MAX,
            DM_ERROR_ARGUMENT,
            "desc.triangles",
        ),
        (|_, d| d.joints = 1 << 20, DM_ERROR_ARGUMENT, "desc.joints"),
        (|_, d| d.positions = null(), DM_ERROR_NULL, "desc.positions"),
        (|_, d| d.indices = null(), DM_ERROR_NULL, "desc.indices"),
        (|_, d| d.parents = null(), DM_ERROR_NULL, "desc.parents"),
        (|_, d| d.bind = null(), DM_ERROR_NULL, "desc.bind"),
        (
            |_, d| d.names = NAMES.0.as_ptr(),
            DM_ERROR_NULL,
            "desc.names[0]",
        ),
        (
            |_, d| (d.influences, d.weights) = (1, WEIGHTS.as_ptr()),
            DM_ERROR_NULL,
            "desc.joint_indices",
        ),
        (
            |_, d| (d.influences, d.joint_indices) = (1, JOINTS.as_ptr()),
            DM_ERROR_NULL,
            "desc.weights",
        ),
        (
            |_, d| (d.influences, d.weights) = (0, WEIGHTS.as_ptr()),
            DM_ERROR_ARGUMENT,
            "desc.influences",
        ),
        (
            |m, _| m.indices[3][1] = 9999,
            DM_ERROR_ARGUMENT,
            "triangle 3",
        ),
        (
            |m, _| m.positions[5][2] = f32::NAN,
            DM_ERROR_ARGUMENT,
            "row 5",
        ),
        (|m, _| m.parents[1] = 1, DM_ERROR_ARGUMENT, "joint_1"),
        (|m, _| m.bind[0] = [0.0; 16], DM_ERROR_ARGUMENT, "joint_0"),
    ];
    for (spoil, wanted, named) in spoiled {
        let mut mesh = raw::Mesh::tube();
        let mut desc = mesh.desc();
        spoil(&mut mesh, &mut desc);
        // SAFETY: the arrays are as long as the description says, or it is refused before they are read.
        let result = unsafe { dm_rig_create(&desc, null(), &mut dm_rig::default()) };
        assert_eq!(result, wanted, "{}", last_error());
        assert!(last_error().contains(named), "{named}: {}", last_error());
    }
}

#[test]
fn arrays_of_options_are_null_only_where_they_are_empty() {
    type Spoil = fn(&mut dm_rig_options, &mut dm_joint_options);
    let spoiled: [(Spoil, dm_result, &str); 8] = [
        (|_, _| (), DM_OK, ""),
        (|o, _| o.joint_count = 1, DM_ERROR_NULL, "options.joints"),
        (
            |o, _| o.primitive_count = 1,
            DM_ERROR_NULL,
            "options.primitives",
        ),
        (|o, _| o.part_count = 1, DM_ERROR_NULL, "options.parts"),
        (|o, _| o.spine_count = 1, DM_ERROR_NULL, "options.spines"),
        (
            |o, j| {
                j.name = null();
                (o.joints, o.joint_count) = (j, 1);
            },
            DM_ERROR_NULL,
            "options.joints.name",
        ),
        (
            |o, j| {
                j.size -= 1;
                (o.joints, o.joint_count) = (j, 1);
            },
            DM_ERROR_STRUCT_SIZE,
            "options.joints",
        ),
        (
            |o, j| (o.joints, o.joint_count) = (j, 1),
            DM_OK,
            "options.joints",
        ),
    ];
    for (spoil, wanted, named) in spoiled {
        // SAFETY: numbers, pointers and optional functions, for which 0 is a value; pointers are NULL or to what lives until the
        // call returns.
        let result = unsafe {
            let mut options: dm_rig_options = std::mem::zeroed();
            options.size = size_of::<dm_rig_options>() as u32;
            fine(dm_rig_options_default(&mut options));
            let mut joint: dm_joint_options = std::mem::zeroed();
            joint.size = size_of::<dm_joint_options>() as u32;
            joint.name = c"lower".as_ptr();
            spoil(&mut options, &mut joint);
            dm_rig_load(raw::path().as_ptr(), &options, &mut dm_rig::default())
        };
        assert_eq!(result, wanted, "{named}: {}", last_error());
        assert!(wanted == DM_OK || last_error().contains(named), "{named}");
    }
}

#[test]
fn arrays_of_a_skin_that_are_null_are_not_wanted() {
    let a = arguments();
    let (vertices, joints) = (a.storage.vertices as usize, a.storage.joints);
    let mut numbers = vec![f32::NAN; 3 * vertices];
    let mut states = vec![99u8; vertices];
    let mut bones = vec![u16::MAX; vertices];
    for wanted in 0..7 {
        // SAFETY: arrays are NULL or have room for all vertices.
        unsafe {
            let poses = a.storage.numbers.as_ptr();
            fine(dm_deformer_advance(a.deformer, poses, joints));
            let mut skin: dm_skin = std::mem::zeroed();
            skin.size = size_of::<dm_skin>() as u32;
            skin.vertices = a.storage.vertices;
            let out = numbers.as_mut_ptr();
            match wanted {
                0 => (),
                1 => skin.positions = out,
                2 => skin.normals = out,
                3 => skin.fields = out,
                4 => skin.isos = out,
                5 => skin.states = states.as_mut_ptr(),
                _ => skin.bones = bones.as_mut_ptr(),
            }
            fine(dm_deformer_read(a.deformer, &skin));
        }
        let written = numbers.iter().filter(|x| !x.is_nan()).count();
        let expected = [0, 3, 3, 1, 1, 0, 0][wanted] * vertices;
        assert_eq!(written, expected, "{wanted}");
        numbers.fill(f32::NAN);
    }
    assert!(!states.contains(&99) && !bones.contains(&u16::MAX));
    fine(dm_deformer_destroy(a.deformer));
    fine(dm_rig_destroy(a.rig));
    fine(dm_context_destroy(a.context));
}

#[test]
fn an_error_is_its_threads_own() {
    assert_eq!(dm_rig_destroy(dm_rig { id: 7 }), DM_ERROR_HANDLE);
    thread::spawn(|| assert_eq!(last_error(), ""))
        .join()
        .unwrap();
    assert!(last_error().starts_with("dm_rig_destroy: dm_rig"));
}

#[test]
fn an_object_may_be_destroyed_while_others_use_it() {
    let a = arguments();
    let (deformer, numbers) = (a.deformer, &a.storage.numbers);
    thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(move || {
                for _ in 0..50 {
                    // SAFETY: one matrix a joint.
                    let result = unsafe {
                        dm_deformer_advance(deformer, numbers.as_ptr(), numbers.len() / 16)
                    };
                    assert!(matches!(result, DM_OK | DM_ERROR_HANDLE));
                }
            });
        }
        fine(dm_rig_destroy(a.rig));
        fine(dm_context_destroy(a.context));
        fine(dm_deformer_destroy(deformer));
        assert_eq!(dm_deformer_destroy(deformer), DM_ERROR_HANDLE);
    });
}
