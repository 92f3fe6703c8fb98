//! A bundled character on a host's device, recorded into its command buffer and written into its vertex buffer.
// Pointers are NULL or to what lives until the call returns; Vulkan's handles live as long as the host.
#![allow(clippy::undocumented_unsafe_blocks, dead_code)]

use std::{
    ffi::{CStr, CString},
    ptr::{null, null_mut},
};

use ash::vk::Handle as _;
use dermis::capi::*;

use crate::host_device::HostDevice;

/// Fails with the last error where a call did not succeed.
#[track_caller]
pub(crate) fn fine(result: dm_result) {
    // SAFETY: never NULL, and valid until the next call.
    let text = unsafe { CStr::from_ptr(dm_last_error()) };
    assert_eq!(result, dm_result::DM_OK, "{}", text.to_string_lossy());
}

/// Everything that a frame needs.
pub(crate) struct Stage<'a> {
    host: &'a HostDevice,
    context: dm_context,
    rig: dm_rig,
    deformer: dm_deformer,
    output: dm_output,
    joints: usize,
    vertices: u32,
}

/// A struct of zeros with its size.
pub(crate) fn sized<T>() -> T {
    // The structs that are used here are numbers, pointers and optional functions, and begin with their size.
    unsafe {
        let mut out: T = std::mem::zeroed();
        (&raw mut out).cast::<u32>().write(size_of::<T>() as u32);
        out
    }
}

/// A bundled character.
pub(crate) fn load(name: &str) -> dm_rig {
    let path = format!("{}/../../assets/{name}.glb", env!("CARGO_MANIFEST_DIR"));
    let (path, mut rig) = (CString::new(path).unwrap(), dm_rig::default());
    fine(unsafe { dm_rig_load(path.as_ptr(), null(), &mut rig) });
    rig
}

/// A context on the host's device.
pub(crate) fn adopt(host: &HostDevice) -> dm_context {
    let mut context = dm_context::default();
    fine(unsafe { dm_context_adopt(&host.vulkan(), &mut context) });
    context
}

impl<'a> Stage<'a> {
    pub(crate) fn new(host: &'a HostDevice, character: &str, method: u32) -> Self {
        Self::of(host, adopt(host), load(character), method)
    }

    /// Takes context and rig.
    pub(crate) fn of(host: &'a HostDevice, context: dm_context, rig: dm_rig, method: u32) -> Self {
        let (mut info, mut settings) = (sized::<dm_rig_info>(), sized::<dm_settings>());
        let (mut deformer, mut output) = (dm_deformer::default(), dm_output::default());
        unsafe {
            fine(dm_rig_get_info(rig, &mut info));
            fine(dm_settings_default(&mut settings));
            settings.method = method;
            fine(dm_deformer_create(context, rig, &settings, &mut deformer));
            fine(dm_output_create(
                context,
                deformer,
                &host.output(),
                &mut output,
            ));
        }
        Self {
            host,
            context,
            rig,
            deformer,
            output,
            joints: info.joints as usize,
            vertices: info.vertices,
        }
    }

    /// A pose in which every joint but the first is turned.
    pub(crate) fn turned(&self, degrees: f32) -> Vec<f32> {
        let turn = glam::Mat4::from_rotation_z(degrees.to_radians()).to_cols_array();
        let mut local = glam::Mat4::IDENTITY.to_cols_array().to_vec();
        local.extend(turn.repeat(self.joints - 1));
        let at = local.as_mut_ptr();
        fine(unsafe { dm_rig_pose_local(self.rig, at, at, self.joints) });
        local
    }

    /// Records a frame into the host's command buffer, which is being recorded.
    pub(crate) fn record(&self, slot: u32, pose: &[f32]) {
        let commands = self.host.commands.as_raw() as *mut _;
        let (deformer, output) = (self.deformer, self.output);
        let (at, joints) = (pose.as_ptr(), self.joints);
        fine(unsafe { dm_frame_record(deformer, commands, slot, at, joints, output) });
    }

    pub(crate) fn iterations(&self) -> dm_iterations {
        let mut out = sized();
        fine(unsafe { dm_deformer_iterations(self.deformer, &mut out) });
        out
    }

    /// Reads the skin.
    pub(crate) fn read(&self) -> Vec<f32> {
        let (mut skin, mut positions) =
            (sized::<dm_skin>(), vec![0f32; 3 * self.vertices as usize]);
        (skin.vertices, skin.positions) = (self.vertices, positions.as_mut_ptr());
        fine(unsafe { dm_deformer_read(self.deformer, &skin) });
        positions
    }

    /// Saves a state and goes on from it.
    pub(crate) fn save_and_restore(&self) {
        let mut needed = 0;
        unsafe {
            fine(dm_deformer_save(self.deformer, null_mut(), 0, &mut needed));
            let mut state = vec![0u8; needed];
            let out = state.as_mut_ptr().cast();
            fine(dm_deformer_save(self.deformer, out, needed, null_mut()));
            fine(dm_deformer_restore(self.deformer, out, needed));
        }
    }

    /// Destroys everything.
    pub(crate) fn end(self) {
        fine(dm_output_destroy(self.output));
        fine(dm_deformer_destroy(self.deformer));
        fine(dm_rig_destroy(self.rig));
        fine(dm_context_destroy(self.context));
    }
}

#[cfg(target_env = "gnu")]
unsafe extern "C" {
    fn malloc_trim(keep: usize) -> i32;
}

/// Resident memory of this process in KiB, without what the C library keeps of memory that was freed.
pub(crate) fn resident() -> u64 {
    // SAFETY: may be called at any time.
    #[cfg(target_env = "gnu")]
    unsafe {
        malloc_trim(0)
    };
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let number = line.unwrap().trim().trim_end_matches(" kB");
    number.parse().unwrap()
}
