//! On a device of dermis' own. It opens the Vulkan loader by its name, so that this test gives a library of that name to a
//! process of its own.
// The library is the one below, and its functions have these types.
#![allow(clippy::undocumented_unsafe_blocks)]

use std::{
    ffi::{CStr, CString, c_char, c_int, c_void},
    path::Path,
    process::Command,
    ptr::{null, null_mut},
};

use ash::vk;
use dermis::capi::*;

use crate::{
    fine, functions,
    host_device::HostDevice,
    no_gpu,
    scenario::Way,
    state,
    sweep::{self, Codes},
    tube,
};

/// A Vulkan loader that asks the test for every function.
const LOADER: &str = "
typedef void *(*get_t)(void *, const char *);
static get_t get;
void dermis_test_loader(get_t from) { get = from; }
void *vkGetInstanceProcAddr(void *instance, const char *name) { return get(instance, name); }
";

const NAME: &str = "libvulkan.so.1";

/// Path of the true loader, in the process that has the other.
const TRUE_LOADER: &str = "DERMIS_TEST_LOADER";

struct Owned {
    flags: u32,
}

impl Way for Owned {
    fn create(&self, out: &mut dm_context) -> dm_result {
        let desc = dm_context_desc {
            size: size_of::<dm_context_desc>() as u32,
            api_version: DM_API_VERSION,
            flags: self.flags,
            device: null(),
            budget: 0,
            log: Some(state::tell),
            log_user: null_mut(),
        };
        unsafe { dm_context_create(&desc, out) }
    }

    fn host(&self) -> Option<&HostDevice> {
        None
    }
}

#[test]
fn on_a_device_of_dermis_own_any_call_may_fail() {
    if no_gpu() {
        return;
    }
    if let Ok(loader) = std::env::var(TRUE_LOADER) {
        return in_its_process(&loader);
    }
    let folder = tempfile::tempdir().unwrap();
    if !compile(folder.path()) {
        eprintln!("skipped: no cc here; tools/test installs it");
        return;
    }
    let passed = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "--nocapture"])
        .arg("owned::on_a_device_of_dermis_own_any_call_may_fail")
        .env(TRUE_LOADER, loader())
        .env("LD_LIBRARY_PATH", folder.path())
        .status();
    assert!(passed.unwrap().success());
}

fn compile(folder: &Path) -> bool {
    let source = folder.join("loader.c");
    std::fs::write(&source, LOADER).unwrap();
    let status = Command::new("cc")
        .args(["-shared", "-fPIC", "-o"])
        .arg(folder.join(NAME))
        .arg(source)
        .status();
    status.is_ok_and(|status| status.success())
}

/// Path of the loader that dermis opens.
fn loader() -> String {
    let _loaded = unsafe { ash::Entry::load() }.unwrap();
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
    let line = maps.lines().find(|line| line.contains("/libvulkan.so"));
    line.unwrap().split_whitespace().last().unwrap().to_owned()
}

unsafe extern "C" {
    fn dlopen(name: *const c_char, flags: c_int) -> *mut c_void;
    fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
}

fn in_its_process(loader: &str) {
    type Hook = unsafe extern "C" fn(vk::PFN_vkGetInstanceProcAddr);
    unsafe {
        const NOW: c_int = 2;
        let name = CString::new(NAME).unwrap();
        let hook = symbol(dlopen(name.as_ptr(), NOW), c"dermis_test_loader");
        let hook = std::mem::transmute::<*mut c_void, Hook>(hook);
        hook(functions::get_instance_proc_addr);
    }
    // Later than the other, so that this is not found by its name.
    let entry = unsafe { ash::Entry::load_from(loader) }.unwrap();
    functions::load_from(entry.static_fn().get_instance_proc_addr);
    let character = tube(DM_IMPLICIT);
    let flags = DM_CONTEXT_TIMESTAMPS;
    sweep::every_call(&Owned { flags }, &character, Codes::InTurn);
    let flags = DM_CONTEXT_VALIDATION;
    sweep::opening(&Owned { flags }, &character);
    fine(dm_rig_destroy(character.rig));
    fine(dm_level_destroy(character.level));
}

fn symbol(library: *mut c_void, name: &CStr) -> *mut c_void {
    assert!(!library.is_null());
    let symbol = unsafe { dlsym(library, name.as_ptr()) };
    assert!(!symbol.is_null());
    symbol
}
