//! Every function of the interface with one set of arguments that works and a way to spoil each of them.
// Pointers are NULL or to what lives until the call returns.
#![allow(clippy::undocumented_unsafe_blocks)]

use std::{
    ffi::{CStr, c_char, c_void},
    ptr::{null, null_mut},
};

use dermis::capi::*;

/// Arguments of all functions; pointers are into the fixture's own storage.
pub(crate) struct Arguments {
    pub(crate) context: dm_context,
    pub(crate) rig: dm_rig,
    pub(crate) deformer: dm_deformer,
    /// Passed in place of each pointer that must not be NULL where it is.
    pub(crate) null: bool,
    /// Sizes of all structs.
    pub(crate) size: Option<u32>,
    pub(crate) storage: Storage,
}

/// Room for results, and inputs.
pub(crate) struct Storage {
    pub(crate) numbers: Vec<f32>,
    pub(crate) indices: Vec<u32>,
    pub(crate) bytes: Vec<u8>,
    pub(crate) joints: usize,
    pub(crate) vertices: u32,
    pub(crate) needed: usize,
}

/// What a function takes that can be wrong.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Takes {
    Nothing,
    Context,
    Rig,
    Deformer,
}

/// One function.
pub(crate) struct Call {
    pub(crate) name: &'static str,
    pub(crate) handle: Takes,
    /// Has a pointer that must not be NULL.
    pub(crate) pointer: bool,
    /// Has a struct with a size.
    pub(crate) sized: bool,
    pub(crate) run: unsafe fn(&mut Arguments) -> dm_result,
}

const fn call(
    name: &'static str,
    handle: Takes,
    pointer: bool,
    sized: bool,
    run: unsafe fn(&mut Arguments) -> dm_result,
) -> Call {
    Call {
        name,
        handle,
        pointer,
        sized,
        run,
    }
}

impl Arguments {
    fn of<T>(&self, pointer: *mut T) -> *mut T {
        if self.null { null_mut() } else { pointer }
    }

    fn bytes(&mut self) -> *mut u8 {
        let pointer = self.storage.bytes.as_mut_ptr();
        self.of(pointer)
    }

    fn indices(&mut self) -> *mut u32 {
        let pointer = self.storage.indices.as_mut_ptr();
        self.of(pointer)
    }

    fn numbers(&mut self) -> *mut f32 {
        let pointer = self.storage.numbers.as_mut_ptr();
        self.of(pointer)
    }

    fn size<T>(&self) -> u32 {
        self.size.unwrap_or(size_of::<T>() as u32)
    }

    fn text(&self, text: &CStr) -> *const c_char {
        self.of(text.as_ptr().cast_mut())
    }
}

pub(crate) unsafe extern "C" fn count(
    user: *mut c_void,
    _class: *const c_char,
    _name: *const c_char,
    _bytes: u64,
) {
    if !user.is_null() {
        // SAFETY: the tests pass a counter or NULL.
        unsafe { *user.cast::<u32>() += 1 };
    }
}

/// The result of making an object, which is destroyed where there is one.
fn made(result: dm_result, destroy: impl FnOnce() -> dm_result) -> dm_result {
    if result == dm_result::DM_OK {
        return destroy();
    }
    result
}

/// A description of the CPU.
pub(crate) fn cpu() -> dm_context_desc {
    dm_context_desc {
        size: size_of::<dm_context_desc>() as u32,
        api_version: DM_API_VERSION,
        flags: DM_CONTEXT_CPU,
        device: null(),
        budget: 0,
        log: None,
        log_user: null_mut(),
    }
}

use Takes::{Context, Deformer, Nothing, Rig};

/// All functions that return a result. The destroying ones get handles of their own.
#[rustfmt::skip]
pub(crate) const CALLS: &[Call] = &[
    call("dm_context_create", Nothing, true, true, |a| unsafe {
        let mut desc = dm_context_desc { size: a.size::<dm_context_desc>(), ..cpu() };
        let mut out = dm_context::default();
        let result = dm_context_create(a.of(&mut desc), &mut out);
        made(result, || dm_context_destroy(out))
    }),
    call("dm_context_destroy", Context, false, false, |a| dm_context_destroy(a.context)),
    call("dm_context_memory", Context, true, true, |a| unsafe {
        let mut out = dm_memory { size: a.size::<dm_memory>(), ..Default::default() };
        dm_context_memory(a.context, a.of(&mut out))
    }),
    call("dm_context_allocations", Context, true, false, |a| unsafe {
        let report: dm_allocation_report = if a.null { None } else { Some(count) };
        dm_context_allocations(a.context, report, null_mut())
    }),
    call("dm_rig_options_default", Nothing, true, true, |a| unsafe {
        let mut out: dm_rig_options = std::mem::zeroed();
        out.size = a.size::<dm_rig_options>();
        dm_rig_options_default(a.of(&mut out))
    }),
    call("dm_rig_load", Nothing, true, true, |a| unsafe {
        let mut options: dm_rig_options = std::mem::zeroed();
        options.size = a.size::<dm_rig_options>();
        let mut out = dm_rig::default();
        let path = crate::raw::path();
        let result = dm_rig_load(a.text(&path), &options, &mut out);
        made(result, || dm_rig_destroy(out))
    }),
    call("dm_rig_create", Nothing, true, true, |a| unsafe {
        let mesh = crate::raw::Mesh::tube();
        let mut desc = mesh.desc();
        desc.size = a.size::<dm_mesh_desc>();
        let mut out = dm_rig::default();
        let result = dm_rig_create(a.of(&mut desc), null(), &mut out);
        made(result, || dm_rig_destroy(out))
    }),
    call("dm_rig_destroy", Rig, false, false, |a| dm_rig_destroy(a.rig)),
    call("dm_rig_get_info", Rig, true, true, |a| unsafe {
        let mut out = dm_rig_info { size: a.size::<dm_rig_info>(), ..Default::default() };
        dm_rig_get_info(a.rig, a.of(&mut out))
    }),
    call("dm_rig_joint", Rig, true, false, |a| unsafe {
        dm_rig_joint(a.rig, a.text(c"lower"), &mut 0)
    }),
    call("dm_rig_joint_name", Rig, true, false, |a| unsafe {
        let out = a.bytes().cast();
        dm_rig_joint_name(a.rig, 0, out, a.storage.bytes.len(), &mut 0)
    }),
    call("dm_rig_indices", Rig, true, false, |a| unsafe {
        let out = a.indices();
        dm_rig_indices(a.rig, out, a.storage.indices.len())
    }),
    call("dm_rig_clip_seconds", Rig, true, false, |a| unsafe {
        dm_rig_clip_seconds(a.rig, 0, a.of(&mut 0.0))
    }),
    call("dm_rig_pose_clip", Rig, true, false, |a| unsafe {
        let out = a.numbers();
        dm_rig_pose_clip(a.rig, 0, 0.0, out, a.storage.joints)
    }),
    call("dm_rig_pose_local", Rig, true, false, |a| unsafe {
        let local = a.numbers();
        dm_rig_pose_local(a.rig, local, a.storage.numbers.as_mut_ptr(), a.storage.joints)
    }),
    call("dm_settings_default", Nothing, true, true, |a| unsafe {
        let mut out: dm_settings = std::mem::zeroed();
        out.size = a.size::<dm_settings>();
        dm_settings_default(a.of(&mut out))
    }),
    call("dm_deformer_create", Context, true, true, |a| unsafe {
        let mut settings: dm_settings = std::mem::zeroed();
        settings.size = size_of::<dm_settings>() as u32;
        dm_settings_default(&mut settings);
        settings.size = a.size::<dm_settings>();
        settings.method = DM_DQS;
        let mut out = dm_deformer::default();
        let result = dm_deformer_create(a.context, a.rig, &settings, a.of(&mut out));
        made(result, || dm_deformer_destroy(out))
    }),
    call("dm_deformer_destroy", Deformer, false, false, |a| dm_deformer_destroy(a.deformer)),
    call("dm_deformer_advance", Deformer, true, false, |a| unsafe {
        dm_deformer_advance(a.deformer, a.numbers(), a.storage.joints)
    }),
    call("dm_deformer_read", Deformer, true, true, |a| unsafe {
        let mut skin: dm_skin = std::mem::zeroed();
        (skin.size, skin.vertices) = (a.size::<dm_skin>(), a.storage.vertices);
        dm_deformer_read(a.deformer, a.of(&mut skin))
    }),
    call("dm_deformer_reset", Deformer, false, false, |a| dm_deformer_reset(a.deformer)),
    call("dm_deformer_save", Deformer, true, false, |a| unsafe {
        let out = a.bytes().cast();
        dm_deformer_save(a.deformer, out, a.storage.bytes.len(), &mut a.storage.needed)
    }),
    call("dm_deformer_restore", Deformer, true, false, |a| unsafe {
        let state = a.bytes().cast();
        dm_deformer_restore(a.deformer, state, a.storage.needed)
    }),
    call("dm_deformer_reset_instance", Deformer, false, false, |a| {
        dm_deformer_reset_instance(a.deformer, 0)
    }),
    call("dm_deformer_save_instance", Deformer, true, false, |a| unsafe {
        let out = a.bytes().cast();
        dm_deformer_save_instance(a.deformer, 0, out, a.storage.bytes.len(), &mut a.storage.needed)
    }),
    call("dm_deformer_restore_instance", Deformer, true, false, |a| unsafe {
        let state = a.bytes().cast();
        dm_deformer_restore_instance(a.deformer, 0, state, a.storage.needed)
    }),
    call("dm_deformer_iterations", Deformer, true, true, |a| unsafe {
        let mut out = dm_iterations { size: a.size::<dm_iterations>(), ..Default::default() };
        dm_deformer_iterations(a.deformer, a.of(&mut out))
    }),
    call("dm_deformer_timings", Deformer, true, true, |a| unsafe {
        let mut out = dm_timings { size: a.size::<dm_timings>(), ..Default::default() };
        dm_deformer_timings(a.deformer, a.of(&mut out))
    }),
];
