//! Vulkan loader, instance, debug messenger.

use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex};

use ash::{ext, khr, vk};

use super::check;
use crate::error::{Error, Result};

/// What to do when no Vulkan loader or driver is found.
const INSTALL_HINT: &str = "install a Vulkan driver and loader (Debian: apt install libvulkan1 mesa-vulkan-drivers)";

/// Messages of the validation layers, in the order of arrival.
pub(super) type Messages = Arc<Mutex<Vec<String>>>;

/// Loader, instance and, with validation, the messenger that collects its messages.
pub struct Instance {
    /// Keeps the loader library open.
    #[cfg_attr(not(feature = "window"), expect(dead_code, reason = "only a window asks for it"))]
    pub(super) entry: ash::Entry,
    pub(super) raw: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// Kept alive for the messenger's user data pointer.
    messages: Messages,
    pub(super) has_debug_utils: bool,
}

impl Instance {
    /// Loads Vulkan and creates a surfaceless 1.3 instance.
    ///
    /// # Errors
    /// [`Error::NoDevice`] without a loader or Vulkan 1.3; [`Error::Failure`] when validation is asked for and
    /// the layer is not installed.
    pub fn new(validation: bool) -> Result<Self> {
        Self::with_extensions(validation, &[])
    }

    /// [`Self::new`] with extensions of the instance enabled, such as those of surfaces.
    pub(super) fn with_extensions(validation: bool, wanted: &[&CStr]) -> Result<Self> {
        // SAFETY: the loader library is trusted to be a Vulkan loader; nothing else is assumed of it.
        let entry = unsafe { ash::Entry::load() }
            .map_err(|_| Error::NoDevice(format!("no Vulkan loader (libvulkan.so.1) was found: {INSTALL_HINT}")))?;
        require_instance_version(&entry)?;
        let layers: Vec<&CStr> = if validation { vec![c"VK_LAYER_KHRONOS_validation"] } else { Vec::new() };
        if validation {
            require_layer(&entry, layers[0])?;
        }
        if let Some(missing) = wanted.iter().find(|name| !has_extension(&entry, None, name)) {
            return Err(Error::NoDevice(format!(
                "a window needs {} of the Vulkan driver, which is not there: add --headless to render without one",
                missing.to_string_lossy()
            )));
        }
        let has_debug_utils = has_extension(&entry, None, ext::debug_utils::NAME)
            || layers.first().is_some_and(|layer| has_extension(&entry, Some(layer), ext::debug_utils::NAME));
        let raw = create_instance(&entry, &layers, wanted, has_debug_utils, validation)?;
        let messages = Messages::default();
        let messenger =
            (validation && has_debug_utils).then(|| create_messenger(&entry, &raw, &messages)).transpose()?;
        Ok(Self { entry, raw, messenger, messages, has_debug_utils })
    }

    /// Validation messages (warnings and errors) so far.
    #[must_use]
    pub fn messages(&self) -> Vec<String> {
        self.messages.lock().map(|list| list.clone()).unwrap_or_default()
    }

    pub(super) fn message_log(&self) -> Messages {
        Arc::clone(&self.messages)
    }

    pub(super) fn physical_devices(&self) -> Result<Vec<vk::PhysicalDevice>> {
        // SAFETY: the instance is alive.
        let devices = unsafe { self.raw.enumerate_physical_devices() };
        let devices = devices.map_err(|result| {
            Error::NoDevice(format!("the Vulkan drivers could not be listed ({result}): {INSTALL_HINT}"))
        })?;
        if devices.is_empty() {
            return Err(Error::NoDevice(format!("no Vulkan driver was found: {INSTALL_HINT}")));
        }
        Ok(devices)
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: devices hold an `Arc` of the instance, so none is left; both objects were created here.
        unsafe {
            if let Some((functions, messenger)) = &self.messenger {
                functions.destroy_debug_utils_messenger(*messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

fn require_instance_version(entry: &ash::Entry) -> Result<()> {
    // SAFETY: plain query on a loaded entry.
    let version = unsafe { entry.try_enumerate_instance_version() }.ok().flatten().unwrap_or(vk::API_VERSION_1_0);
    if version < vk::API_VERSION_1_3 {
        return Err(Error::NoDevice("the Vulkan loader is older than 1.3: install a newer libvulkan1".to_owned()));
    }
    Ok(())
}

fn require_layer(entry: &ash::Entry, layer: &CStr) -> Result<()> {
    // SAFETY: plain query on a loaded entry.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
    if layers.iter().any(|l| l.layer_name_as_c_str() == Ok(layer)) {
        return Ok(());
    }
    Err(Error::Failure(
        "--validation needs VK_LAYER_KHRONOS_validation (Debian: apt install vulkan-validationlayers)".to_owned(),
    ))
}

fn has_extension(entry: &ash::Entry, layer: Option<&CStr>, name: &CStr) -> bool {
    // SAFETY: plain query on a loaded entry.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(layer) }.unwrap_or_default();
    extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name))
}

fn create_instance(
    entry: &ash::Entry,
    layers: &[&CStr],
    wanted: &[&CStr],
    has_debug_utils: bool,
    validation: bool,
) -> Result<ash::Instance> {
    let app = vk::ApplicationInfo::default()
        .application_name(c"gridlight")
        .engine_name(c"gridlight")
        .api_version(vk::API_VERSION_1_3);
    let layer_pointers: Vec<_> = layers.iter().map(|l| l.as_ptr()).collect();
    let mut extensions: Vec<_> = wanted.iter().map(|name| name.as_ptr()).collect();
    if has_debug_utils {
        extensions.push(ext::debug_utils::NAME.as_ptr());
    }
    // Without both, the loader hides drivers that are built on another interface, such as MoltenVK.
    let mut flags = vk::InstanceCreateFlags::empty();
    if has_extension(entry, None, khr::portability_enumeration::NAME) {
        extensions.push(khr::portability_enumeration::NAME.as_ptr());
        flags |= vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
    }
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let mut info = vk::InstanceCreateInfo::default()
        .flags(flags)
        .application_info(&app)
        .enabled_layer_names(&layer_pointers)
        .enabled_extension_names(&extensions);
    if validation {
        info = info.push_next(&mut features);
    }
    // SAFETY: all pointers in `info` outlive the call.
    unsafe { entry.create_instance(&info, None) }
        .map_err(|result| Error::NoDevice(format!("no Vulkan instance could be made ({result}): {INSTALL_HINT}")))
}

fn create_messenger(
    entry: &ash::Entry,
    instance: &ash::Instance,
    messages: &Messages,
) -> Result<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)> {
    let functions = ext::debug_utils::Instance::new(entry, instance);
    let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR)
        .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE)
        .pfn_user_callback(Some(on_message))
        .user_data(Arc::as_ptr(messages).cast_mut().cast());
    // SAFETY: the user data is the mutex inside an `Arc` that the `Instance` keeps until the messenger is gone.
    let messenger =
        check("vkCreateDebugUtilsMessengerEXT", unsafe { functions.create_debug_utils_messenger(&info, None) })?;
    Ok((functions, messenger))
}

/// Collects one message; also logs it at once, so that a crash does not swallow it.
unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user_data: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes valid callback data with a NUL-terminated message.
    let text = unsafe {
        data.as_ref()
            .filter(|d| !d.p_message.is_null())
            .map(|d| CStr::from_ptr(d.p_message).to_string_lossy().into_owned())
            .unwrap_or_default()
    };
    log::error!("validation: {text}");
    // SAFETY: `user_data` is the mutex set in `create_messenger`, alive as long as the messenger.
    if let Some(messages) = unsafe { user_data.cast::<Mutex<Vec<String>>>().as_ref() }
        && let Ok(mut list) = messages.lock()
    {
        list.push(text);
    }
    vk::FALSE
}
