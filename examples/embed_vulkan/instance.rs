//! The engine's entry to Vulkan, and what the validation layer says about it.
use gibs_backend_vulkan::ash::{self, ext, vk};
use std::error::Error;
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

/// The version that the engine is written for.
pub const API: u32 = vk::API_VERSION_1_3;

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Every message of the validation layer, oldest first.
#[derive(Clone, Default)]
pub struct Log(Arc<Mutex<Vec<String>>>);

impl Log {
    pub fn messages(&self) -> Vec<String> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    /// The log must outlive the messenger.
    fn messenger(&self) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
        use vk::DebugUtilsMessageSeverityFlagsEXT as Severity;
        use vk::DebugUtilsMessageTypeFlagsEXT as Type;
        vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(Severity::WARNING | Severity::ERROR)
            .message_type(Type::VALIDATION | Type::PERFORMANCE)
            .pfn_user_callback(Some(receive))
            .user_data(Arc::as_ptr(&self.0).cast_mut().cast())
    }
}

unsafe extern "system" fn receive(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    log: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes a struct with a text that ends in a zero; both are alive during this call.
    let text = unsafe { CStr::from_ptr((*data).p_message) };
    // SAFETY: the pointer was made by `Log::messenger`, and the instance keeps the log until the messenger is gone.
    let log = unsafe { &*log.cast::<Mutex<Vec<String>>>() };
    log.lock()
        .unwrap_or_else(PoisonError::into_inner)
        .push(text.to_string_lossy().into_owned());
    vk::FALSE
}

/// The loader and an instance.
pub struct Instance {
    pub entry: ash::Entry,
    pub raw: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    _log: Option<Log>,
}

impl Instance {
    /// With a log, the validation layer checks every call, and that hazards have barriers.
    ///
    /// # Errors
    /// There is no loader, no driver, or no such layer.
    pub fn new(log: Option<&Log>) -> Result<Self, Box<dyn Error>> {
        // SAFETY: the library that is opened is the system's Vulkan loader, which wants nothing else.
        let entry = unsafe { ash::Entry::load() }?;
        let application = vk::ApplicationInfo::default().api_version(API);
        let layers = [LAYER.as_ptr()];
        let extensions = [
            ext::debug_utils::NAME.as_ptr(),
            ext::validation_features::NAME.as_ptr(),
        ];
        let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features =
            vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
        let mut messenger = log.map(Log::messenger).unwrap_or_default();
        let mut info = vk::InstanceCreateInfo::default().application_info(&application);
        if log.is_some() {
            info = info
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions)
                .push_next(&mut features)
                .push_next(&mut messenger);
        }
        // SAFETY: every pointer in `info` is to a local that lives until after the call.
        let raw = unsafe { entry.create_instance(&info, None) }?;
        let mut made = Self {
            entry,
            raw,
            messenger: None,
            _log: log.cloned(),
        };
        if let Some(log) = log {
            let utils = ext::debug_utils::Instance::new(&made.entry, &made.raw);
            // SAFETY: the extension is enabled, and the instance keeps the log until the messenger is gone.
            let messenger = unsafe { utils.create_debug_utils_messenger(&log.messenger(), None) }?;
            made.messenger = Some((utils, messenger));
        }
        Ok(made)
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: each is destroyed once; the device was made from this instance and is gone, since it owned this value.
        unsafe {
            if let Some((utils, messenger)) = self.messenger.take() {
                utils.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}
