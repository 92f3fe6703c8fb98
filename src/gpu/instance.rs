//! Loader, instance and the canary that collects validation messages.

use std::{
    ffi::{CStr, c_char, c_void},
    sync::{Arc, Mutex},
};

use ash::{ext, khr, vk};

use super::fault::{Subject, lock, vulkan};
use crate::{Error, Result};

/// Lowest Vulkan version that dermis runs on.
pub(crate) const API: u32 = vk::API_VERSION_1_2;

const VALIDATION: &CStr = c"VK_LAYER_KHRONOS_validation";

/// More messages than these say nothing new.
const MESSAGES: usize = 256;

/// Warnings and errors of the validation layers; a test that finds one in it fails.
#[derive(Debug, Default)]
pub(crate) struct Canary(Mutex<Vec<String>>);

impl Canary {
    pub(crate) fn messages(&self) -> Vec<String> {
        lock(&self.0).clone()
    }

    #[cfg(test)]
    pub(crate) fn take(&self) -> Vec<String> {
        std::mem::take(&mut *lock(&self.0))
    }

    fn tell(&self, message: String) {
        let mut messages = lock(&self.0);
        if messages.len() < MESSAGES {
            messages.push(message);
        }
    }
}

/// A Vulkan instance; destroyed on drop.
pub(crate) struct Instance {
    pub(crate) raw: ash::Instance,
    pub(crate) canary: Arc<Canary>,
    /// Debug names and labels are available.
    pub(crate) debug_utils: bool,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// Made here, to be destroyed here.
    owned: bool,
    /// Keeps the loader's library open.
    _entry: ash::Entry,
}

impl Instance {
    /// Opens the loader; with `validation`, core and synchronization validation watch every call.
    pub(crate) fn new(validation: bool) -> Result<Self> {
        let entry = load()?;
        let layers = if validation {
            require_layer(&entry)?;
            vec![VALIDATION.as_ptr()]
        } else {
            Vec::new()
        };
        let (extensions, flags) = extensions(&entry, validation)?;
        let debug_utils = extensions.contains(&ext::debug_utils::NAME);
        let canary = Arc::new(Canary::default());
        let raw = create(
            &entry,
            &layers,
            &extensions,
            flags,
            validation.then_some(&canary),
        )?;
        let mut instance = Self {
            raw,
            canary,
            debug_utils,
            messenger: None,
            owned: true,
            _entry: entry,
        };
        if validation {
            instance.messenger = Some(instance.listen()?);
        }
        Ok(instance)
    }

    /// The host's instance, which outlives this.
    ///
    /// # Safety
    /// The instance is valid as long as this is, and the function that of its loader.
    pub(crate) unsafe fn of_host(
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
    ) -> Self {
        let loader = ash::StaticFn {
            get_instance_proc_addr,
        };
        // SAFETY: promised by the caller.
        let (entry, raw) = unsafe {
            let raw = ash::Instance::load(&loader, instance);
            (ash::Entry::from_static_fn(loader), raw)
        };
        Self {
            raw,
            canary: Arc::default(),
            debug_utils: true,
            messenger: None,
            owned: false,
            _entry: entry,
        }
    }

    fn listen(&self) -> Result<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)> {
        let loader = ext::debug_utils::Instance::new(&self._entry, &self.raw);
        let info = messenger(&self.canary);
        // SAFETY: the instance is alive and has VK_EXT_debug_utils; the canary outlives the messenger, see `Drop`.
        let raw = unsafe { loader.create_debug_utils_messenger(&info, None) }
            .subject("vkCreateDebugUtilsMessengerEXT", "instance")?;
        Ok((loader, raw))
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: whoever owns the instance dropped its device first; nothing of an own instance is in use. The canary,
        // to which the layers hold a pointer until the instance is gone, is a field and dropped after this.
        unsafe {
            if let Some((loader, messenger)) = self.messenger.take() {
                loader.destroy_debug_utils_messenger(messenger, None);
            }
            if self.owned {
                self.raw.destroy_instance(None);
            }
        }
    }
}

fn load() -> Result<ash::Entry> {
    // SAFETY: opening the system's Vulkan loader runs its initialisers, which are trusted like any system library.
    unsafe { ash::Entry::load() }.map_err(no_loader)
}

fn no_loader(error: ash::LoadingError) -> Error {
    Error::NoDevice {
        reason: format!(
            "the Vulkan loader cannot be opened ({error}); install a loader and a driver, on Debian \
             `apt install libvulkan1 mesa-vulkan-drivers`, or use the cpu device"
        ),
    }
}

fn require_layer(entry: &ash::Entry) -> Result<()> {
    // SAFETY: the entry is loaded.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }
        .subject("vkEnumerateInstanceLayerProperties", "instance")?;
    let found = layers
        .iter()
        .any(|l| l.layer_name_as_c_str() == Ok(VALIDATION));
    found.then_some(()).ok_or_else(|| Error::NoDevice {
        reason: "validation was asked for but VK_LAYER_KHRONOS_validation is not installed \
                 (on Debian `apt install vulkan-validationlayers`)"
            .into(),
    })
}

/// Instance extensions to turn on, and the flag that portability drivers (MoltenVK) need.
fn extensions(
    entry: &ash::Entry,
    validation: bool,
) -> Result<(Vec<&'static CStr>, vk::InstanceCreateFlags)> {
    let call = "vkEnumerateInstanceExtensionProperties";
    // SAFETY: the entry is loaded.
    let all =
        unsafe { entry.enumerate_instance_extension_properties(None) }.subject(call, "instance")?;
    let has = |name: &CStr| all.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
    let mut wanted = Vec::new();
    if validation || has(ext::debug_utils::NAME) {
        wanted.push(ext::debug_utils::NAME);
    }
    if validation {
        wanted.push(ext::validation_features::NAME);
    }
    let mut flags = vk::InstanceCreateFlags::empty();
    if has(khr::portability_enumeration::NAME) {
        wanted.push(khr::portability_enumeration::NAME);
        flags |= vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
    }
    Ok((wanted, flags))
}

fn create(
    entry: &ash::Entry,
    layers: &[*const c_char],
    extensions: &[&CStr],
    flags: vk::InstanceCreateFlags,
    canary: Option<&Arc<Canary>>,
) -> Result<ash::Instance> {
    let names: Vec<_> = extensions.iter().map(|e| e.as_ptr()).collect();
    let application = vk::ApplicationInfo::default()
        .application_name(c"dermis")
        .engine_name(c"dermis")
        .api_version(API);
    let mut info = vk::InstanceCreateInfo::default()
        .application_info(&application)
        .enabled_layer_names(layers)
        .enabled_extension_names(&names)
        .flags(flags);
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let mut messenger = canary.map(messenger);
    if let Some(messenger) = &mut messenger {
        info = info.push_next(&mut features).push_next(messenger);
    }
    // SAFETY: every pointer in `info` is to a value alive until the call returns; the canary is kept by the caller for
    // as long as the instance lives.
    unsafe { entry.create_instance(&info, None) }.map_err(no_instance)
}

fn no_instance(code: vk::Result) -> Error {
    use vk::Result as Code;
    if matches!(
        code,
        Code::ERROR_OUT_OF_HOST_MEMORY | Code::ERROR_OUT_OF_DEVICE_MEMORY
    ) {
        return vulkan("vkCreateInstance", "instance", code);
    }
    Error::NoDevice {
        reason: format!(
            "vkCreateInstance: {code:?}; without a driver install one, on Debian \
             `apt install mesa-vulkan-drivers`, or use the cpu device"
        ),
    }
}

/// Warnings and errors of the validation layers. Messages of the loader about other drivers are left out: they tell of
/// the machine, not of dermis.
fn messenger(canary: &Arc<Canary>) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    use vk::{
        DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type,
    };
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        .message_type(Type::VALIDATION | Type::PERFORMANCE)
        .pfn_user_callback(Some(on_message))
        .user_data(Arc::as_ptr(canary).cast_mut().cast())
}

unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layers hand over valid data with a null-terminated message (or none), and the pointer from `messenger`,
    // which is to a canary that outlives the instance.
    let told = unsafe {
        let message = data.as_ref().and_then(|d| d.message_as_c_str());
        user.cast::<Canary>().as_ref().zip(message)
    };
    if let Some((canary, message)) = told {
        canary.tell(message.to_string_lossy().into_owned());
    }
    vk::FALSE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_loader_says_what_to_install() {
        // SAFETY: there is no such library, so that nothing runs.
        let loaded = unsafe { ash::Entry::load_from("libdermis-no-vulkan.so") };
        let error = loaded.map(drop).map_err(no_loader);
        let text = error.map_or_else(|e| e.to_string(), |()| String::new());
        assert!(
            text.contains("no Vulkan device") && text.contains("apt install libvulkan1"),
            "{text}"
        );
    }
}
