//! The skin is that of the Rust façade, bit for bit.

use std::{
    ffi::c_void,
    path::Path,
    ptr::{null, null_mut},
    sync::Arc,
};

use dermis::{
    asset::{self, Model},
    capi::*,
    deformer::{Deformer, Device, Method, Settings, Skin},
    gpu::{Gpu, GpuOptions},
    rig::{Options, Pose, Rig},
};
use glam::Vec3;

use crate::{Messages, calls, fine, keep, no_gpu, raw};

/// Frames of the arm's clip.
pub(crate) const TIMES: [f32; 3] = [0.2, 0.6, 1.0];

fn arm() -> Model {
    asset::load(&crate::root().join(Path::new("assets/arm.glb"))).unwrap()
}

/// Skins by the façade.
fn by_rust(device: &Device, method: Method) -> Vec<Skin> {
    let model = arm();
    let rig = Arc::new(Rig::prepare(&model, &Options::default(), &|_| {}).unwrap());
    let settings = Settings {
        method,
        ..Settings::default()
    };
    let mut deformer = Deformer::new(device, rig.clone(), &settings).unwrap();
    let frame = |seconds| {
        let pose = Pose::from_clip(&model, &rig.skeleton, 0, seconds).unwrap();
        deformer.advance(&pose).unwrap();
        deformer.read().unwrap()
    };
    TIMES.map(frame).to_vec()
}

/// Poses of the arm's clip.
pub(crate) fn poses(rig: dm_rig) -> Vec<Vec<f32>> {
    let joints = info(rig).joints as usize;
    let pose = |seconds| {
        let mut matrices = vec![0.0; 16 * joints];
        // SAFETY: one matrix a joint.
        fine(unsafe { dm_rig_pose_clip(rig, 0, seconds, matrices.as_mut_ptr(), joints) });
        matrices
    };
    TIMES.map(pose).to_vec()
}

pub(crate) fn info(rig: dm_rig) -> dm_rig_info {
    let mut info = dm_rig_info {
        size: size_of::<dm_rig_info>() as u32,
        ..Default::default()
    };
    // SAFETY: lives until the call returns.
    fine(unsafe { dm_rig_get_info(rig, &mut info) });
    info
}

fn load() -> dm_rig {
    let mut rig = dm_rig::default();
    // SAFETY: all live until the call returns.
    fine(unsafe { dm_rig_load(raw::path().as_ptr(), null(), &mut rig) });
    rig
}

pub(crate) fn deformer(context: dm_context, rig: dm_rig, method: u32) -> dm_deformer {
    deformers(context, rig, method, 1)
}

pub(crate) fn deformers(
    context: dm_context,
    rig: dm_rig,
    method: u32,
    instances: u32,
) -> dm_deformer {
    let mut deformer = dm_deformer::default();
    // SAFETY: all live until the call returns; zeros are a value of the struct.
    unsafe {
        let mut settings: dm_settings = std::mem::zeroed();
        settings.size = size_of::<dm_settings>() as u32;
        fine(dm_settings_default(&mut settings));
        settings.method = method;
        settings.instances = instances;
        fine(dm_deformer_create(context, rig, &settings, &mut deformer));
    }
    deformer
}

pub(crate) fn advance(deformer: dm_deformer, pose: &[f32]) {
    // SAFETY: 16 numbers a matrix.
    fine(unsafe { dm_deformer_advance(deformer, pose.as_ptr(), pose.len() / 16) });
}

pub(crate) fn read(deformer: dm_deformer, vertices: u32) -> Skin {
    read_instance(deformer, vertices, 0)
}

fn read_instance(deformer: dm_deformer, vertices: u32, instance: u32) -> Skin {
    let count = vertices as usize;
    let mut skin = Skin {
        positions: vec![Vec3::ZERO; count],
        normals: vec![Vec3::ZERO; count],
        field: vec![0.0; count],
        iso: vec![0.0; count],
        state: vec![0; count],
        bone: vec![0; count],
    };
    let out = dm_skin {
        size: size_of::<dm_skin>() as u32,
        vertices,
        positions: skin.positions.as_mut_ptr().cast(),
        normals: skin.normals.as_mut_ptr().cast(),
        fields: skin.field.as_mut_ptr(),
        isos: skin.iso.as_mut_ptr(),
        states: skin.state.as_mut_ptr(),
        bones: skin.bone.as_mut_ptr(),
        instance,
        reserved: 0,
    };
    // SAFETY: each array has a row a vertex.
    fine(unsafe { dm_deformer_read(deformer, &out) });
    skin
}

/// Skins by the C interface, of a rig with the arm's joints, in its poses.
pub(crate) fn by_c(context: dm_context, rig: dm_rig, poses: &[Vec<f32>], method: u32) -> Vec<Skin> {
    let vertices = info(rig).vertices;
    let deformer = deformer(context, rig, method);
    let frame = |pose: &Vec<f32>| {
        advance(deformer, pose);
        read(deformer, vertices)
    };
    let skins = poses.iter().map(frame).collect();
    fine(dm_deformer_destroy(deformer));
    skins
}

pub(crate) fn context(desc: &dm_context_desc) -> dm_context {
    let mut context = dm_context::default();
    // SAFETY: both live until the call returns.
    fine(unsafe { dm_context_create(desc, &mut context) });
    context
}

/// A validated device by both ways; `None` where `DERMIS_NO_GPU=1` asks for the skip.
fn devices(messages: &Messages) -> Option<(Device, dm_context)> {
    if no_gpu() {
        return None;
    }
    let options = GpuOptions {
        validation: true,
        ..GpuOptions::default()
    };
    let desc = dm_context_desc {
        flags: DM_CONTEXT_VALIDATION | DM_CONTEXT_TIMESTAMPS,
        log: Some(keep),
        log_user: std::ptr::from_ref(messages).cast_mut().cast(),
        ..calls::cpu()
    };
    Some((Device::Gpu(Gpu::new(&options).unwrap()), context(&desc)))
}

fn no_complaints(messages: &Messages) {
    let messages = messages.lock().unwrap();
    assert!(messages.iter().any(|(level, _)| *level == DM_LOG_INFO));
    let complaints = messages.iter().filter(|(level, _)| *level == DM_LOG_ERROR);
    assert_eq!(complaints.count(), 0, "{messages:#?}");
}

#[test]
fn the_cpus_skin_is_the_facades() {
    let context = context(&calls::cpu());
    let rig = load();
    let c = by_c(context, rig, &poses(rig), DM_IMPLICIT);
    assert!(c == by_rust(&Device::Cpu, Method::Implicit));
    fine(dm_rig_destroy(rig));
    fine(dm_context_destroy(context));
}

#[test]
fn the_devices_skin_is_the_facades() {
    let messages = Messages::default();
    let Some((device, context)) = devices(&messages) else {
        return;
    };
    let rig = load();
    for (number, method) in [
        (DM_LBS, Method::Lbs),
        (DM_DQS, Method::Dqs),
        (DM_IMPLICIT, Method::Implicit),
        (DM_TRACKING, Method::Tracking),
    ] {
        let c = by_c(context, rig, &poses(rig), number);
        assert!(c == by_rust(&device, method), "{method:?}");
    }
    fine(dm_rig_destroy(rig));
    fine(dm_context_destroy(context));
    no_complaints(&messages);
}

/// The three poses at once for three instances, then each instance's next one.
fn instances_have_the_skins_of_deformers(context: dm_context, method: u32) {
    let rig = load();
    let (poses, vertices) = (poses(rig), info(rig).vertices);
    let three = deformers(context, rig, method, 3);
    let next = [&poses[1], &poses[2], &poses[0]];
    advance(three, &poses.concat());
    let mut needed = 0;
    // SAFETY: NULL without room asks for the number; then there is room.
    let state = unsafe {
        fine(dm_deformer_save_instance(
            three,
            2,
            null_mut(),
            0,
            &mut needed,
        ));
        let mut state = vec![0u8; needed];
        let out = state.as_mut_ptr().cast();
        fine(dm_deformer_save_instance(three, 2, out, needed, null_mut()));
        state
    };
    advance(three, &next.map(|pose| pose.clone()).concat());
    for (row, next) in next.into_iter().enumerate() {
        let one = deformer(context, rig, method);
        advance(one, &poses[row]);
        advance(one, next);
        let own = read(one, vertices);
        assert!(
            own == read_instance(three, vertices, row as u32),
            "{method} {row}"
        );
        fine(dm_deformer_destroy(one));
    }
    // The first one goes on from where the third was, the second from rest.
    let last = read_instance(three, vertices, 2);
    // SAFETY: as many bytes as were saved.
    fine(unsafe { dm_deformer_restore_instance(three, 0, state.as_ptr().cast(), needed) });
    fine(dm_deformer_reset_instance(three, 1));
    advance(three, &[&poses[0][..], &poses[1], &poses[1]].concat());
    let one = deformer(context, rig, method);
    advance(one, &poses[1]);
    assert!(read_instance(three, vertices, 0) == last);
    assert!(read_instance(three, vertices, 1) == read(one, vertices));
    for handle in [one, three] {
        fine(dm_deformer_destroy(handle));
    }
    fine(dm_rig_destroy(rig));
}

#[test]
fn instances_of_a_device_have_the_skins_of_deformers() {
    let messages = Messages::default();
    let Some((_, context)) = devices(&messages) else {
        return;
    };
    for method in [DM_LBS, DM_DQS, DM_IMPLICIT, DM_TRACKING] {
        instances_have_the_skins_of_deformers(context, method);
    }
    fine(dm_context_destroy(context));
    no_complaints(&messages);
}

#[test]
fn instances_of_the_cpu_have_the_skins_of_deformers() {
    let context = context(&calls::cpu());
    instances_have_the_skins_of_deformers(context, DM_IMPLICIT);
    let rig = load();
    let (three, pose) = (deformers(context, rig, DM_DQS, 3), &poses(rig)[0]);
    // SAFETY: refused.
    let wrong = unsafe {
        [
            dm_deformer_advance(three, pose.as_ptr(), pose.len() / 16),
            dm_deformer_save_instance(three, 3, null_mut(), 0, &mut 0),
            dm_deformer_restore_instance(three, 3, null(), 0),
            dm_deformer_reset_instance(three, u32::MAX),
        ]
    };
    assert_eq!(wrong[0], dm_result::DM_ERROR_SIZE);
    assert_eq!(wrong[1..], [dm_result::DM_ERROR_ARGUMENT; 3]);
    fine(dm_deformer_destroy(three));
    fine(dm_rig_destroy(rig));
    fine(dm_context_destroy(context));
}

#[test]
fn arrays_give_the_skin_of_the_file() {
    let context = context(&calls::cpu());
    let file = load();
    let mesh = raw::Mesh::of(&arm());
    let mut arrays = dm_rig::default();
    // SAFETY: the arrays are as long as the description says.
    fine(unsafe { dm_rig_create(&mesh.desc(), null(), &mut arrays) });
    let (a, mut b) = (info(file), info(arrays));
    assert_eq!((a.clips > 0, b.clips), (true, 0));
    b.clips = a.clips;
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
    let poses = poses(file);
    let skins = [file, arrays].map(|rig| by_c(context, rig, &poses, DM_IMPLICIT));
    assert!(skins[0] == skins[1]);
    for handle in [file, arrays] {
        fine(dm_rig_destroy(handle));
    }
    fine(dm_context_destroy(context));
}

#[test]
fn arrays_without_weights_and_names_make_a_character() {
    let mesh = raw::Mesh::tube();
    let mut rig = dm_rig::default();
    let mut name = [0u8; 16];
    let mut needed = 0;
    // SAFETY: the arrays are as long as the description says, and all else lives until the calls return.
    unsafe {
        fine(dm_rig_create(&mesh.desc(), null(), &mut rig));
        let out = name.as_mut_ptr().cast();
        fine(dm_rig_joint_name(rig, 1, out, name.len(), &mut needed));
    }
    assert_eq!(&name[..needed], b"joint_1\0");
    let numbers = info(rig);
    assert_eq!((numbers.joints, numbers.fields), (2, 2));
    let mut indices = vec![0u32; 3 * numbers.triangles as usize];
    // SAFETY: there is room for three rows a triangle.
    fine(unsafe { dm_rig_indices(rig, indices.as_mut_ptr(), indices.len()) });
    assert_eq!(indices, mesh.indices.as_flattened());
    fine(dm_rig_destroy(rig));
}

#[test]
fn a_turn_of_a_joint_is_the_facades_pose() {
    let rig = load();
    let model = arm();
    let skeleton = dermis::rig::Skeleton::from_model(&model).unwrap();
    let mut row = 0;
    // SAFETY: both live until the call returns.
    fine(unsafe { dm_rig_joint(rig, c"lower".as_ptr(), &mut row) });
    let mut local = vec![glam::Mat4::IDENTITY; skeleton.joints.len()];
    local[row as usize] = glam::Mat4::from_rotation_z(1.0);
    let wanted = Pose::from_local(&skeleton, &local).unwrap();
    let mut numbers: Vec<f32> = local.iter().flat_map(|m| m.to_cols_array()).collect();
    let (matrices, count) = (numbers.as_mut_ptr(), local.len());
    // SAFETY: one matrix a joint in both, which may be the same.
    fine(unsafe { dm_rig_pose_local(rig, matrices, matrices, count) });
    let wanted: Vec<f32> = wanted
        .matrices
        .iter()
        .flat_map(|m| m.to_cols_array())
        .collect();
    assert_eq!(numbers, wanted);
    fine(dm_rig_destroy(rig));
}

#[test]
fn a_tracked_skin_goes_on_from_its_bytes() {
    let messages = Messages::default();
    let Some((_, context)) = devices(&messages) else {
        return;
    };
    let rig = load();
    let (poses, vertices) = (poses(rig), info(rig).vertices);
    let tracked = deformer(context, rig, DM_TRACKING);
    advance(tracked, &poses[0]);
    let mut needed = 0;
    // SAFETY: NULL without room asks for the number; then there is room.
    let state = unsafe {
        fine(dm_deformer_save(tracked, null_mut(), 0, &mut needed));
        let mut state = vec![0u8; needed];
        let out = state.as_mut_ptr().cast();
        fine(dm_deformer_save(tracked, out, needed, null_mut()));
        state
    };
    advance(tracked, &poses[1]);
    let first = read(tracked, vertices);
    advance(tracked, &poses[2]);
    // SAFETY: as many bytes as were saved.
    fine(unsafe { dm_deformer_restore(tracked, state.as_ptr().cast(), needed) });
    advance(tracked, &poses[1]);
    assert!(first == read(tracked, vertices));
    fine(dm_deformer_reset(tracked));
    fine(dm_deformer_destroy(tracked));
    fine(dm_rig_destroy(rig));
    fine(dm_context_destroy(context));
    no_complaints(&messages);
}

#[test]
fn memory_and_measurements_are_told() {
    let messages = Messages::default();
    let Some((_, context)) = devices(&messages) else {
        return;
    };
    let rig = load();
    let implicit = deformer(context, rig, DM_IMPLICIT);
    for pose in &poses(rig) {
        advance(implicit, pose);
        read(implicit, info(rig).vertices);
    }
    let mut memory = dm_memory {
        size: size_of::<dm_memory>() as u32,
        ..Default::default()
    };
    let mut iterations = dm_iterations {
        size: size_of::<dm_iterations>() as u32,
        ..Default::default()
    };
    let mut timings = dm_timings {
        size: size_of::<dm_timings>() as u32,
        ..Default::default()
    };
    let mut seen = 0u32;
    // SAFETY: all live until the calls return.
    unsafe {
        fine(dm_context_memory(context, &mut memory));
        let user = std::ptr::from_mut(&mut seen).cast::<c_void>();
        fine(dm_context_allocations(context, Some(calls::count), user));
        fine(dm_deformer_iterations(implicit, &mut iterations));
        fine(dm_deformer_timings(implicit, &mut timings));
    }
    let m = &memory;
    let sum = m.fields + m.mesh + m.operators + m.pose_ring + m.transient + m.readback;
    assert!(m.fields > 0 && m.mesh > 0 && m.pose_ring > 0);
    assert_eq!((m.total, m.buffers), (sum, u64::from(seen)));
    assert!(iterations.evaluations > 0 && iterations.rounds > 0);
    assert!(timings.measured == 1 && timings.gpu_ns > 0 && timings.record_ns > 0);
    fine(dm_deformer_destroy(implicit));
    fine(dm_rig_destroy(rig));
    fine(dm_context_destroy(context));
    no_complaints(&messages);
}
