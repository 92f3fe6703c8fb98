//! What the interface tells of devices, preparations, rigs and frames is what Rust's façade tells.
// Pointers are to what lives until the call returns.
#![allow(clippy::undocumented_unsafe_blocks)]

use std::{
    ffi::{CStr, c_char, c_void},
    ptr::{null, null_mut},
    sync::Mutex,
};

use dermis::{
    capi::{dm_result::*, *},
    gpu::Gpu,
    rig::{Options, Pose, Rig},
};

use crate::{
    calls,
    facade::{defaults, load},
    fine, last_error, no_gpu, raw, skin,
};

unsafe extern "C" fn on_progress(user: *mut c_void, stage: *const c_char, done: u64, total: u64) {
    let (heard, stage) = unsafe {
        let heard = &*user.cast::<Mutex<Vec<(String, u64, u64)>>>();
        (heard, CStr::from_ptr(stage).to_str().unwrap().to_owned())
    };
    heard.lock().unwrap().push((stage, done, total));
}

#[test]
fn a_preparation_tells_how_far_it_is() {
    let heard = Mutex::new(Vec::<(String, u64, u64)>::new());
    let mut c = defaults();
    c.progress = Some(on_progress);
    c.progress_user = (&raw const heard).cast_mut().cast();
    let mut rig = dm_rig::default();
    fine(unsafe { dm_rig_load(raw::path().as_ptr(), &c, &mut rig) });
    fine(dm_rig_destroy(rig));
    let mut heard = heard.into_inner().unwrap();
    let (model, _) = load("arm.glb");
    let by_rust = Mutex::new(Vec::new());
    let keep = |p: dermis::report::Progress| {
        let row = (p.stage.to_owned(), p.done as u64, p.total as u64);
        by_rust.lock().unwrap().push(row);
    };
    Rig::prepare(&model, &Options::default(), &keep).unwrap();
    // Threads may come in any order.
    let mut wanted = by_rust.into_inner().unwrap();
    heard.sort();
    wanted.sort();
    assert!(!wanted.is_empty());
    assert_eq!(heard, wanted);
}

#[test]
fn joints_clips_and_poses_between_are_the_facades() {
    let (model, path) = load("arm.glb");
    let mut rig = dm_rig::default();
    fine(unsafe { dm_rig_load(path.as_ptr(), null(), &mut rig) });
    let skeleton = dermis::rig::Skeleton::from_model(&model).unwrap();
    let mut info = dm_joint_info {
        size: size_of::<dm_joint_info>() as u32,
        ..Default::default()
    };
    for (row, joint) in skeleton.joints.iter().enumerate() {
        fine(unsafe { dm_rig_joint_info(rig, row as u32, &mut info) });
        let parent = joint.parent.map_or(u32::MAX, |p| p as u32);
        assert_eq!(
            (info.parent, info.bind),
            (parent, joint.bind.to_cols_array())
        );
    }
    let mut name = [0u8; 64];
    let mut needed = 0;
    for (row, clip) in model.clips.iter().enumerate() {
        let out = name.as_mut_ptr().cast();
        fine(unsafe { dm_rig_clip_name(rig, row as u32, out, name.len(), &mut needed) });
        assert_eq!(&name[..needed - 1], clip.name.as_bytes());
    }
    let beyond = unsafe { dm_rig_clip_name(rig, 99, name.as_mut_ptr().cast(), 64, null_mut()) };
    assert_eq!(beyond, DM_ERROR_ARGUMENT, "{}", last_error());
    assert_eq!(
        unsafe { dm_rig_joint_info(rig, 99, &mut info) },
        DM_ERROR_ARGUMENT
    );
    let poses = skin::poses(rig);
    let pose = |row: usize| Pose::from_clip(&model, &skeleton, 0, skin::TIMES[row]).unwrap();
    let wanted = Pose::interpolate(&skeleton, &pose(0), &pose(1), 0.3).unwrap();
    let mut between = poses[0].clone();
    let (out, count) = (between.as_mut_ptr(), skeleton.joints.len());
    let step = |t| unsafe {
        dm_rig_pose_interpolate(rig, poses[0].as_ptr(), poses[1].as_ptr(), t, out, count)
    };
    fine(step(0.3));
    let wanted: Vec<f32> = wanted
        .matrices
        .iter()
        .flat_map(|m| m.to_cols_array())
        .collect();
    assert_eq!(step(1.5), DM_ERROR_ARGUMENT);
    assert_eq!(between, wanted);
    fine(dm_rig_destroy(rig));
}

unsafe extern "C" fn on_device(user: *mut c_void, device: *const dm_device_info) {
    let (heard, device) = unsafe { (&*user.cast::<Mutex<Vec<String>>>(), &*device) };
    assert_eq!(device.size as usize, size_of::<dm_device_info>());
    let text = [device.name, device.driver, device.api, device.kind];
    let text = text.map(|t| unsafe { CStr::from_ptr(t) }.to_str().unwrap());
    let row = format!("{} {}", device.index, text.join(" "));
    heard.lock().unwrap().push(row);
}

#[test]
fn devices_are_the_facades() {
    if no_gpu() {
        return;
    }
    let heard = Mutex::new(Vec::<String>::new());
    fine(unsafe { dm_devices(Some(on_device), (&raw const heard).cast_mut().cast()) });
    let wanted = Gpu::enumerate().unwrap().into_iter();
    let row = |d: dermis::report::DeviceReport| {
        [d.index.to_string(), d.name, d.driver, d.api, d.kind].join(" ")
    };
    assert_eq!(
        heard.into_inner().unwrap(),
        wanted.map(row).collect::<Vec<_>>()
    );
    let result = unsafe { dm_devices(None, null_mut()) };
    assert_eq!(result, DM_ERROR_NULL);
    assert!(last_error().contains("report is NULL"));
}

unsafe extern "C" fn on_pass(user: *mut c_void, pass: *const dm_pass_timing) {
    let (heard, pass) = unsafe { (&*user.cast::<Mutex<Vec<(String, u64)>>>(), &*pass) };
    assert_eq!(pass.size as usize, size_of::<dm_pass_timing>());
    let text = |t| unsafe { CStr::from_ptr(t) }.to_str().unwrap().to_owned();
    assert!(!text(pass.label).is_empty() && pass.steps > 0);
    assert!(pass.begin_ns <= pass.end_ns);
    let row = (text(pass.name), pass.end_ns - pass.begin_ns);
    heard.lock().unwrap().push(row);
}

#[test]
fn passes_tell_their_times() {
    if no_gpu() {
        return;
    }
    let desc = dm_context_desc {
        flags: DM_CONTEXT_TIMESTAMPS,
        ..calls::cpu()
    };
    let context = skin::context(&desc);
    let mut rig = dm_rig::default();
    fine(unsafe { dm_rig_load(raw::path().as_ptr(), null(), &mut rig) });
    let deformer = skin::deformer(context, rig, DM_IMPLICIT);
    let heard = Mutex::new(Vec::<(String, u64)>::new());
    let user = (&raw const heard).cast_mut().cast();
    fine(unsafe { dm_deformer_passes(deformer, Some(on_pass), user) });
    assert!(heard.lock().unwrap().is_empty());
    let mut timings = dm_timings {
        size: size_of::<dm_timings>() as u32,
        ..Default::default()
    };
    let poses = skin::poses(rig);
    let mut frames = 0;
    // All turns, the first of which is known with the frame after it.
    while frames < 2 + timings.turns {
        skin::advance(deformer, &poses[0]);
        fine(dm_deformer_wait(deformer));
        fine(unsafe { dm_deformer_timings(deformer, &mut timings) });
        fine(unsafe { dm_deformer_passes(deformer, Some(on_pass), user) });
        frames += 1;
    }
    assert!(timings.measured == 1 && timings.turns > 0);
    let heard = heard.into_inner().unwrap();
    for pass in ["skin_dqs", "project", "normals"] {
        assert!(heard.iter().any(|(name, _)| name == pass), "{heard:?}");
    }
    fine(dm_deformer_destroy(deformer));
    fine(dm_rig_destroy(rig));
    fine(dm_context_destroy(context));
}
