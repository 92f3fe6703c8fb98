//! A defect within a call: a code, an object that is refused from then on, and nothing else that suffers.

use std::{
    cell::Cell,
    ffi::{CStr, c_char, c_void},
    ptr::{null, null_mut},
};

use glam::Mat4;

use super::{dm_result::*, *};

thread_local! {
    static DEFECT: Cell<bool> = const { Cell::new(false) };
}

/// The defect: panics while an object is in use, once, where a test asks for it.
pub(super) fn defect() {
    if DEFECT.take() {
        panic!("no such thing");
    }
}

fn last_error() -> String {
    // SAFETY: never NULL, and valid until the next call.
    let text = unsafe { CStr::from_ptr(dm_last_error()) };
    text.to_string_lossy().into_owned()
}

fn fine(result: dm_result) {
    assert_eq!(result, DM_OK, "{}", last_error());
}

fn sized<T>() -> T {
    // SAFETY: the structs of the header that are used here are numbers, pointers and optional functions.
    let mut out: T = unsafe { std::mem::zeroed() };
    // SAFETY: they begin with their size.
    unsafe { (&raw mut out).cast::<u32>().write(size_of::<T>() as u32) };
    out
}

/// A box along x with two joints.
fn rig() -> dm_rig {
    let corner =
        |i: u32| [0, 1, 2].map(|axis| if axis == 0 { 4.0 } else { 1.0 } * (i >> axis & 1) as f32);
    let positions: Vec<[f32; 3]> = (0..8).map(corner).collect();
    let indices: [[u32; 3]; 12] = [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    let bind = [0.0, 2.0].map(|x| Mat4::from_translation(glam::Vec3::X * x).to_cols_array());
    let joints: [u16; 8] = [0, 1, 0, 1, 0, 1, 0, 1];
    let (mut desc, mut out) = (sized::<dm_mesh_desc>(), dm_rig::default());
    (desc.vertices, desc.triangles, desc.joints, desc.influences) = (8, 12, 2, 1);
    desc.positions = positions.as_ptr().cast();
    desc.indices = indices.as_ptr().cast();
    desc.bind = bind.as_ptr().cast();
    let (parents, weights) = ([u32::MAX, 0], [1.0f32; 8]);
    (desc.parents, desc.joint_indices, desc.weights) =
        (parents.as_ptr(), joints.as_ptr(), weights.as_ptr());
    // SAFETY: the arrays are as long as the description says.
    fine(unsafe { dm_rig_create(&desc, null(), &mut out) });
    out
}

fn context() -> dm_context {
    let (mut desc, mut out) = (sized::<dm_context_desc>(), dm_context::default());
    (desc.api_version, desc.flags) = (DM_API_VERSION, DM_CONTEXT_CPU);
    // SAFETY: both live until the call returns.
    fine(unsafe { dm_context_create(&desc, &mut out) });
    out
}

fn deformer(context: dm_context, rig: dm_rig) -> Result<dm_deformer, dm_result> {
    let (mut settings, mut out) = (sized::<dm_settings>(), dm_deformer::default());
    // SAFETY: all live until the call returns.
    let result = unsafe {
        fine(dm_settings_default(&mut settings));
        settings.method = DM_DQS;
        dm_deformer_create(context, rig, &settings, &mut out)
    };
    if result == DM_OK {
        Ok(out)
    } else {
        Err(result)
    }
}

fn made_and_destroyed(context: dm_context, rig: dm_rig) -> dm_result {
    match deformer(context, rig) {
        Ok(deformer) => dm_deformer_destroy(deformer),
        Err(code) => code,
    }
}

fn advance(deformer: dm_deformer) -> dm_result {
    let pose = [Mat4::IDENTITY; 2].map(|m| m.to_cols_array());
    // SAFETY: one matrix a joint.
    unsafe { dm_deformer_advance(deformer, pose.as_ptr().cast(), 2) }
}

unsafe extern "C" fn report(_: *mut c_void, _: *const c_char, _: *const c_char, _: u64) {}

/// Runs into the defect in `call`, and finds the object refused in it for good.
fn break_in(name: &str, call: &dyn Fn() -> dm_result) {
    fine(call());
    DEFECT.set(true);
    assert_eq!(call(), DM_ERROR_PANIC, "{name}");
    assert!(!DEFECT.get(), "{name}");
    assert_eq!(
        last_error(),
        format!("{name}: a defect in dermis: no such thing")
    );
    assert_eq!(call(), DM_ERROR_PANIC, "{name}");
    assert!(last_error().contains("destroy it"), "{}", last_error());
}

// SAFETY, of all calls below: pointers are to what lives until the call returns, as long as is said.
#[test]
#[allow(clippy::undocumented_unsafe_blocks)]
fn a_defect_breaks_the_deformer_that_was_in_use_and_nothing_else() {
    let (context, rig) = (context(), rig());
    let other = deformer(context, rig).unwrap();
    type Call = fn(dm_deformer) -> dm_result;
    let calls: [(&str, Call); 7] = [
        ("dm_deformer_advance", advance),
        ("dm_deformer_read", |d| unsafe {
            let mut skin = sized::<dm_skin>();
            skin.vertices = 8;
            dm_deformer_read(d, &skin)
        }),
        ("dm_deformer_reset", |d| dm_deformer_reset(d)),
        ("dm_deformer_save", |d| unsafe {
            dm_deformer_save(d, null_mut(), 0, &mut 0)
        }),
        ("dm_deformer_restore", |d| unsafe {
            dm_deformer_restore(d, null(), 0)
        }),
        ("dm_deformer_iterations", |d| unsafe {
            dm_deformer_iterations(d, &mut sized())
        }),
        ("dm_deformer_timings", |d| unsafe {
            dm_deformer_timings(d, &mut sized())
        }),
    ];
    for (name, call) in calls {
        let broken = deformer(context, rig).unwrap();
        break_in(name, &|| call(broken));
        for (_, call) in calls {
            assert_eq!(call(broken), DM_ERROR_PANIC);
        }
        fine(dm_deformer_destroy(broken));
        fine(advance(other));
    }
    for destroyed in [
        dm_deformer_destroy(other),
        dm_rig_destroy(rig),
        dm_context_destroy(context),
    ] {
        fine(destroyed);
    }
}

#[test]
#[allow(clippy::undocumented_unsafe_blocks)]
fn a_defect_breaks_the_context_or_rig_that_was_in_use() {
    let rig_of = rig();
    type Call = fn(dm_context, dm_rig) -> dm_result;
    let of_context: [(&str, Call); 2] = [
        ("dm_context_memory", |c, _| unsafe {
            dm_context_memory(c, &mut sized())
        }),
        ("dm_context_allocations", |c, _| unsafe {
            dm_context_allocations(c, Some(report), null_mut())
        }),
    ];
    for (name, call) in of_context {
        let broken = context();
        let deformer_of = deformer(broken, rig_of).unwrap();
        break_in(name, &|| call(broken, rig_of));
        assert_eq!(deformer(broken, rig_of), Err(DM_ERROR_PANIC));
        fine(advance(deformer_of));
        fine(dm_context_destroy(broken));
        fine(dm_deformer_destroy(deformer_of));
    }
    let of_rig: [(&str, Call); 6] = [
        ("dm_rig_get_info", |_, r| unsafe {
            dm_rig_get_info(r, &mut sized())
        }),
        ("dm_rig_joint", |_, r| unsafe {
            dm_rig_joint(r, c"joint_1".as_ptr(), &mut 0)
        }),
        ("dm_rig_joint_name", |_, r| unsafe {
            dm_rig_joint_name(r, 0, null_mut(), 0, &mut 0)
        }),
        ("dm_rig_indices", |_, r| unsafe {
            dm_rig_indices(r, [0; 36].as_mut_ptr(), 36)
        }),
        ("dm_rig_pose_local", |_, r| unsafe {
            let mut pose = [Mat4::IDENTITY; 2].map(|m| m.to_cols_array());
            let at = pose.as_mut_ptr().cast();
            dm_rig_pose_local(r, at, at, 2)
        }),
        ("dm_deformer_create", made_and_destroyed),
    ];
    let context = context();
    for (name, call) in of_rig {
        let broken = rig();
        break_in(name, &|| call(context, broken));
        assert_eq!(deformer(context, broken), Err(DM_ERROR_PANIC));
        fine(dm_rig_destroy(broken));
        fine(made_and_destroyed(context, rig_of));
    }
    fine(dm_rig_destroy(rig_of));
    fine(dm_context_destroy(context));
}

/// A straight spine.
fn spine() -> dm_spine {
    let points = [[0.0, 0.5, 0.5], [4.0, 0.5, 0.5]];
    let mut desc = sized::<dm_spine_desc>();
    (desc.kind, desc.point_count) = (DM_SPINE_POLYLINE, 2);
    desc.points = points.as_ptr().cast();
    let mut spine = dm_spine::default();
    // SAFETY: the points live until the call returns.
    fine(unsafe { dm_spine_create(&desc, dm_spine::default(), &mut spine) });
    spine
}

/// Two vertices on it.
fn fleshed(rest: dm_spine) -> Result<dm_flesh, dm_result> {
    let positions = [[1.0f32, 0.0, 0.0], [2.0, 1.0, 1.0]];
    let mut desc = sized::<dm_flesh_desc>();
    (desc.vertices, desc.positions) = (2, positions.as_ptr().cast());
    let mut flesh = dm_flesh::default();
    // SAFETY: the positions live until the call returns.
    match unsafe { dm_flesh_create(rest, &desc, &mut flesh) } {
        DM_OK => Ok(flesh),
        code => Err(code),
    }
}

#[test]
#[allow(clippy::undocumented_unsafe_blocks)]
fn a_defect_breaks_the_spine_or_the_flesh_that_was_in_use() {
    let whole = spine();
    type Call = fn(dm_spine) -> dm_result;
    let of_spine: [(&str, Call); 3] = [
        ("dm_spine_get_info", |s| unsafe {
            dm_spine_get_info(s, &mut sized())
        }),
        ("dm_spine_at", |s| unsafe {
            dm_spine_at(s, 1.0, &mut sized())
        }),
        ("dm_flesh_create", |s| match fleshed(s) {
            Ok(flesh) => dm_flesh_destroy(flesh),
            Err(code) => code,
        }),
    ];
    for (name, call) in of_spine {
        let broken = spine();
        break_in(name, &|| call(broken));
        fine(call(whole));
        fine(dm_spine_destroy(broken));
    }
    let flesh = fleshed(whole).unwrap();
    let bend = || unsafe {
        let mut bent = sized::<dm_bent>();
        bent.vertices = 2;
        dm_flesh_bend(flesh, whole, null(), &bent)
    };
    break_in("dm_flesh_bend", &bend);
    fine(dm_flesh_destroy(flesh));
    fine(dm_spine_destroy(whole));
}

/// Three spheres of a box that grows, as a level.
fn level() -> (dm_sphere_mesh, dm_level) {
    let corner = |i: u32| [0, 1, 2].map(|axis| (i >> axis & 1) as f32);
    let frames = [1.0f32, 1.5].map(|scale| (0..8).map(move |i| corner(i).map(|x| x * scale)));
    let positions: Vec<[f32; 3]> = frames.into_iter().flatten().collect();
    let indices: [[u32; 3]; 4] = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6]];
    let mut desc = sized::<dm_sequence_desc>();
    (desc.vertices, desc.triangles, desc.frames) = (8, 4, 2);
    (desc.positions, desc.indices) = (positions.as_ptr().cast(), indices.as_ptr().cast());
    let (mut mesh, mut level) = (dm_sphere_mesh::default(), dm_level::default());
    // SAFETY: the arrays are as long as the description says.
    unsafe {
        fine(dm_sphere_mesh_build(&desc, null(), &mut mesh));
        fine(dm_level_create(mesh, 3, 0, &mut level));
    }
    (mesh, level)
}

#[test]
#[allow(clippy::undocumented_unsafe_blocks)]
fn a_defect_breaks_the_sphere_mesh_the_level_or_the_particles_that_were_in_use() {
    let context = context();
    let (mesh, whole) = level();
    let positions = [0.5f32, 3.0, 0.5, 0.1];
    let mut desc = sized::<dm_particles_desc>();
    (desc.count, desc.positions) = (1, positions.as_ptr());
    let mut particles = dm_particles::default();
    let made = unsafe { dm_particles_create(context, whole, 0.0, &desc, null(), &mut particles) };
    fine(made);
    let advance = || dm_particles_advance(particles, 1.0, 0.1);
    break_in("dm_particles_advance", &advance);
    let written = unsafe { dm_particles_write(particles, &desc) };
    assert_eq!(written, DM_ERROR_PANIC);
    fine(dm_particles_destroy(particles));
    let of_level = || unsafe { dm_level_get_info(whole, &mut sized()) };
    let of_mesh = || unsafe { dm_sphere_mesh_get_info(mesh, &mut sized()) };
    break_in("dm_sphere_mesh_get_info", &of_mesh);
    // The level has what it needs of the sphere-mesh.
    fine(of_level());
    break_in("dm_level_get_info", &of_level);
    let mut collider = dm_collider::default();
    let made = unsafe { dm_collider_create(whole, 0.0, &mut collider) };
    assert_eq!(made, DM_ERROR_PANIC);
    fine(dm_level_destroy(whole));
    fine(dm_sphere_mesh_destroy(mesh));
    fine(dm_context_destroy(context));
}
