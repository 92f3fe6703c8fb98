//! Every function of the interface with one set of arguments that works and a way to spoil each of them.
// Pointers are NULL or to what lives until the call returns.
#![allow(clippy::undocumented_unsafe_blocks)]

use std::{
    cell::Cell,
    ffi::{CStr, c_char, c_void},
    ptr::{null, null_mut},
};

use dermis::capi::*;

use crate::host_device::HostDevice;

/// Arguments of all functions; pointers are into the fixture's own storage.
pub(crate) struct Arguments {
    pub(crate) context: dm_context,
    pub(crate) rig: dm_rig,
    pub(crate) deformer: dm_deformer,
    pub(crate) output: dm_output,
    pub(crate) spine: dm_spine,
    pub(crate) flesh: dm_flesh,
    pub(crate) mesh: dm_sphere_mesh,
    pub(crate) level: dm_level,
    pub(crate) collider: dm_collider,
    pub(crate) particles: dm_particles,
    /// A host's device, where there is one.
    pub(crate) host: Option<HostDevice>,
    /// The pointer that is NULL, counted in the order in which a call asks for them.
    pub(crate) null: Option<usize>,
    /// The struct that has another size, counted likewise, and its size.
    pub(crate) size: Option<(usize, u32)>,
    asked: Cell<Asked>,
    pub(crate) storage: Storage,
}

/// What a call has asked for.
#[derive(Clone, Copy, Default)]
pub(crate) struct Asked {
    pub(crate) pointers: usize,
    pub(crate) sizes: usize,
    /// The pointer that is NULL may be.
    pub(crate) optional: bool,
}

/// Room for results, and inputs.
#[derive(Default)]
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
    Output,
    Spine,
    Flesh,
    SphereMesh,
    Level,
    Collider,
    Particles,
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

pub(crate) const fn call(
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
    pub(crate) fn new(
        (context, rig, deformer): (dm_context, dm_rig, dm_deformer),
        storage: Storage,
    ) -> Self {
        Self {
            context,
            rig,
            deformer,
            output: dm_output::default(),
            spine: dm_spine::default(),
            flesh: dm_flesh::default(),
            mesh: dm_sphere_mesh::default(),
            level: dm_level::default(),
            collider: dm_collider::default(),
            particles: dm_particles::default(),
            host: None,
            null: None,
            size: None,
            asked: Cell::default(),
            storage,
        }
    }

    /// The host's device; only functions that need one ask for it.
    pub(crate) fn host(&self) -> &HostDevice {
        self.host.as_ref().unwrap()
    }

    /// Begins a call.
    pub(crate) fn begin(&self) {
        self.asked.take();
    }

    /// What the last call has asked for.
    pub(crate) fn asked(&self) -> Asked {
        self.asked.get()
    }

    /// The next pointer is the one that is NULL.
    pub(crate) fn is_null(&self, optional: bool) -> bool {
        let mut asked = self.asked.get();
        let null = self.null == Some(asked.pointers);
        asked.pointers += 1;
        asked.optional |= null && optional;
        self.asked.set(asked);
        null
    }

    /// A pointer that must not be NULL.
    pub(crate) fn of<T>(&self, pointer: *mut T) -> *mut T {
        if self.is_null(false) {
            null_mut()
        } else {
            pointer
        }
    }

    /// A pointer that may be NULL.
    pub(crate) fn may<T>(&self, pointer: *mut T) -> *mut T {
        if self.is_null(true) {
            null_mut()
        } else {
            pointer
        }
    }

    /// A pointer to what is read, that must not be NULL.
    pub(crate) fn from<T>(&self, rows: &[T]) -> *const T {
        self.of(rows.as_ptr().cast_mut())
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

    pub(crate) fn size<T>(&self) -> u32 {
        let mut asked = self.asked.get();
        let row = asked.sizes;
        asked.sizes += 1;
        self.asked.set(asked);
        match self.size {
            Some((wrong, size)) if wrong == row => size,
            _ => size_of::<T>() as u32,
        }
    }

    pub(crate) fn text(&self, text: &CStr) -> *const c_char {
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

unsafe extern "C" fn pass(_user: *mut c_void, _pass: *const dm_pass_timing) {}

/// The result of making an object, which is destroyed where there is one.
pub(crate) fn made(result: dm_result, destroy: impl FnOnce() -> dm_result) -> dm_result {
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

/// The options of a preparation, with all that they may have.
struct Options {
    options: dm_rig_options,
    _joints: Box<[dm_joint_options; 1]>,
}

unsafe fn options(a: &Arguments) -> Options {
    unsafe {
        let mut joints = Box::new([std::mem::zeroed::<dm_joint_options>()]);
        joints[0].size = a.size::<dm_joint_options>();
        joints[0].name = a.text(c"lower");
        let mut options: dm_rig_options = std::mem::zeroed();
        options.size = a.size::<dm_rig_options>();
        (options.joint_count, options.joints) = (1, a.from(&joints[..]));
        Options {
            options,
            _joints: joints,
        }
    }
}

use Takes::{Context, Deformer, Level, Nothing, Output, Particles, Rig, Spine};

/// Functions with a second handle.
pub(crate) const SECOND: [(&str, Takes); 9] = [
    ("dm_deformer_create", Rig),
    ("dm_output_create", Deformer),
    ("dm_frame_record", Output),
    ("dm_spine_create", Spine),
    ("dm_spine_load", Spine),
    ("dm_flesh_bend", Spine),
    ("dm_particles_create", Level),
    ("dm_particles_output", Particles),
    ("dm_particles_record", Output),
];

/// Those whose second handle may be zero.
pub(crate) const MAY_BE_ZERO: [&str; 4] = [
    "dm_frame_record",
    "dm_spine_create",
    "dm_spine_load",
    "dm_particles_record",
];

/// All functions that return a result. The destroying ones get handles of their own.
#[rustfmt::skip]
pub(crate) const CALLS: &[Call] = &[
    call("dm_context_create", Nothing, true, true, |a| unsafe {
        let mut desc = dm_context_desc { size: a.size::<dm_context_desc>(), ..cpu() };
        let mut out = dm_context::default();
        let result = dm_context_create(a.of(&mut desc), a.of(&mut out));
        made(result, || dm_context_destroy(out))
    }),
    call("dm_context_destroy", Context, false, false, |a| dm_context_destroy(a.context)),
    call("dm_context_memory", Context, true, true, |a| unsafe {
        let mut out = dm_memory { size: a.size::<dm_memory>(), ..Default::default() };
        dm_context_memory(a.context, a.of(&mut out))
    }),
    call("dm_context_allocations", Context, true, false, |a| unsafe {
        let report: dm_allocation_report = if a.is_null(false) { None } else { Some(count) };
        dm_context_allocations(a.context, report, null_mut())
    }),
    call("dm_rig_options_default", Nothing, true, true, |a| unsafe {
        let mut out: dm_rig_options = std::mem::zeroed();
        out.size = a.size::<dm_rig_options>();
        dm_rig_options_default(a.of(&mut out))
    }),
    call("dm_rig_load", Nothing, true, true, |a| unsafe {
        let mut options = options(a);
        let mut out = dm_rig::default();
        let path = crate::raw::path();
        let result = dm_rig_load(a.text(&path), a.may(&mut options.options), a.of(&mut out));
        made(result, || dm_rig_destroy(out))
    }),
    call("dm_rig_create", Nothing, true, true, |a| unsafe {
        let mesh = crate::raw::Mesh::tube();
        let mut desc = mesh.desc();
        desc.size = a.size::<dm_mesh_desc>();
        desc.positions = a.of(desc.positions.cast_mut());
        desc.indices = a.of(desc.indices.cast_mut());
        desc.parents = a.of(desc.parents.cast_mut());
        desc.bind = a.of(desc.bind.cast_mut());
        let mut options: dm_rig_options = std::mem::zeroed();
        options.size = a.size::<dm_rig_options>();
        let mut out = dm_rig::default();
        let result = dm_rig_create(a.of(&mut desc), a.may(&mut options), a.of(&mut out));
        made(result, || dm_rig_destroy(out))
    }),
    call("dm_rig_destroy", Rig, false, false, |a| dm_rig_destroy(a.rig)),
    call("dm_rig_get_info", Rig, true, true, |a| unsafe {
        let mut out = dm_rig_info { size: a.size::<dm_rig_info>(), ..Default::default() };
        dm_rig_get_info(a.rig, a.of(&mut out))
    }),
    call("dm_rig_joint", Rig, true, false, |a| unsafe {
        dm_rig_joint(a.rig, a.text(c"lower"), a.of(&mut 0))
    }),
    call("dm_rig_joint_name", Rig, true, false, |a| unsafe {
        let out = a.bytes().cast();
        dm_rig_joint_name(a.rig, 0, out, a.storage.bytes.len(), a.may(&mut 0))
    }),
    call("dm_rig_joint_info", Rig, true, true, |a| unsafe {
        let mut out = dm_joint_info { size: a.size::<dm_joint_info>(), ..Default::default() };
        dm_rig_joint_info(a.rig, 0, a.of(&mut out))
    }),
    call("dm_rig_clip_name", Rig, true, false, |a| unsafe {
        let out = a.bytes().cast();
        dm_rig_clip_name(a.rig, 0, out, a.storage.bytes.len(), a.may(&mut 0))
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
        dm_rig_pose_local(a.rig, local, a.numbers(), a.storage.joints)
    }),
    call("dm_rig_pose_interpolate", Rig, true, false, |a| unsafe {
        let (from, to) = (a.numbers(), a.numbers());
        dm_rig_pose_interpolate(a.rig, from, to, 0.5, a.numbers(), a.storage.joints)
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
        let result = dm_deformer_create(a.context, a.rig, a.may(&mut settings), a.of(&mut out));
        made(result, || dm_deformer_destroy(out))
    }),
    call("dm_deformer_destroy", Deformer, false, false, |a| dm_deformer_destroy(a.deformer)),
    call("dm_deformer_advance", Deformer, true, false, |a| unsafe {
        dm_deformer_advance(a.deformer, a.numbers(), a.storage.joints)
    }),
    call("dm_deformer_wait", Deformer, false, false, |a| dm_deformer_wait(a.deformer)),
    call("dm_deformer_read", Deformer, true, true, |a| unsafe {
        let mut skin: dm_skin = std::mem::zeroed();
        (skin.size, skin.vertices) = (a.size::<dm_skin>(), a.storage.vertices);
        let count = a.storage.vertices as usize;
        let mut vectors = [vec![0f32; 3 * count], vec![0f32; 3 * count]];
        let mut numbers = [vec![0f32; count], vec![0f32; count]];
        let (mut states, mut bones) = (vec![0u8; count], vec![0u16; count]);
        skin.positions = a.may(vectors[0].as_mut_ptr());
        skin.normals = a.may(vectors[1].as_mut_ptr());
        skin.fields = a.may(numbers[0].as_mut_ptr());
        skin.isos = a.may(numbers[1].as_mut_ptr());
        skin.states = a.may(states.as_mut_ptr());
        skin.bones = a.may(bones.as_mut_ptr());
        dm_deformer_read(a.deformer, a.of(&mut skin))
    }),
    call("dm_deformer_reset", Deformer, false, false, |a| dm_deformer_reset(a.deformer)),
    call("dm_deformer_save", Deformer, true, false, |a| unsafe {
        let out = a.bytes().cast();
        let mut needed = a.storage.needed;
        let result = dm_deformer_save(a.deformer, out, a.storage.bytes.len(), a.may(&mut needed));
        a.storage.needed = needed;
        result
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
    call("dm_deformer_passes", Deformer, true, false, |a| unsafe {
        let report: dm_pass_report = if a.is_null(false) { None } else { Some(pass) };
        dm_deformer_passes(a.deformer, report, null_mut())
    }),
];
