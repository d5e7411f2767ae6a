//! The Vulkan instance: loader, layers and the messenger.
use crate::backend::Options;
use crate::validation::ValidationLog;
use ash::{ext, khr, vk};
use gibs_graph::BackendError;
use std::ffi::CStr;

/// The newest version that the backend knows how to use.
const NEWEST: u32 = vk::API_VERSION_1_3;
/// The oldest version that it can use.
pub(crate) const OLDEST: u32 = vk::API_VERSION_1_2;

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";
const INSTALL_DRIVER: &str =
    "install a Vulkan driver, for example the Debian package mesa-vulkan-drivers";
const INSTALL_LAYER: &str = "install the validation layer, for example the Debian package vulkan-validationlayers, \
     or run without validation";

/// An instance, made here or lent by a host.
pub(crate) struct Instance {
    pub raw: ash::Instance,
    /// Version of the API that the instance was made for.
    pub api: u32,
    /// Objects and command buffers can be named.
    pub names: bool,
    /// The validation layer looks for missing barriers.
    pub checks_hazards: bool,
    pub log: ValidationLog,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    owned: bool,
    /// Keeps the loader in memory.
    _entry: ash::Entry,
}

/// The backend is not there.
pub(crate) fn unavailable(reason: impl Into<String>, remedy: impl Into<String>) -> BackendError {
    BackendError::Unavailable {
        backend: "vulkan".into(),
        reason: reason.into(),
        remedy: remedy.into(),
    }
}

/// As [`unavailable`], where a driver would help.
pub(crate) fn no_driver(reason: impl Into<String>) -> BackendError {
    unavailable(reason, INSTALL_DRIVER)
}

impl Instance {
    /// Opens the loader and makes an instance.
    pub fn new(options: &Options) -> Result<Self, BackendError> {
        // SAFETY: the library that is opened is the system's Vulkan loader, whose initialization has no requirements.
        let entry = unsafe { ash::Entry::load() }
            .map_err(|e| no_driver(format!("the Vulkan loader cannot be opened ({e})")))?;
        // SAFETY: the entry was loaded; the call has no other requirements.
        let loader = unsafe { entry.try_enumerate_instance_version() }
            .ok()
            .flatten()
            .unwrap_or(vk::API_VERSION_1_0);
        if loader < OLDEST {
            return Err(unavailable(
                format!("the Vulkan loader is for version {}", version(loader)),
                "update it, for example the Debian package libvulkan1",
            ));
        }
        let api = loader.min(NEWEST);
        let validate = options.validation || options.sync_validation;
        let layer_extensions = if validate {
            layer_extensions(&entry)?
        } else {
            Vec::new()
        };
        let offered = extensions(&entry, None)?;
        let offers = |name: &CStr| {
            offered.iter().any(|e| e == name) || layer_extensions.iter().any(|e| e == name)
        };

        let names = offers(ext::debug_utils::NAME);
        let portability = offers(khr::portability_enumeration::NAME);
        let mut wanted = Vec::new();
        if names {
            wanted.push(ext::debug_utils::NAME.as_ptr());
        }
        if portability {
            wanted.push(khr::portability_enumeration::NAME.as_ptr());
        }
        if options.sync_validation {
            if !offers(ext::validation_features::NAME) {
                return Err(unavailable(
                    "the validation layer cannot check synchronization (VK_EXT_validation_features)",
                    INSTALL_LAYER,
                ));
            }
            wanted.push(ext::validation_features::NAME.as_ptr());
        }

        let log = ValidationLog::default();
        let mut messenger = log.messenger();
        let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features =
            vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
        let layers = [LAYER.as_ptr()];
        let application = vk::ApplicationInfo::default()
            .application_name(c"gibs")
            .engine_name(c"gibs")
            .api_version(api);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_extension_names(&wanted);
        if portability {
            info = info.flags(vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR);
        }
        if validate {
            info = info.enabled_layer_names(&layers).push_next(&mut messenger);
        }
        if options.sync_validation {
            info = info.push_next(&mut features);
        }
        // SAFETY: every pointer in `info` is to a local that lives until after the call.
        let raw = unsafe { entry.create_instance(&info, None) }
            .map_err(|e| no_driver(format!("no Vulkan driver answers ({e})")))?;

        let mut made = Self {
            raw,
            api,
            names,
            checks_hazards: options.sync_validation,
            log,
            messenger: None,
            owned: true,
            _entry: entry,
        };
        if validate {
            made.listen()?;
        }
        Ok(made)
    }

    /// Uses the instance of a host, which stays its owner.
    pub fn from_host(entry: ash::Entry, raw: ash::Instance, api: u32) -> Self {
        Self {
            raw,
            api,
            names: false,
            checks_hazards: false,
            log: ValidationLog::default(),
            messenger: None,
            owned: false,
            _entry: entry,
        }
    }

    fn listen(&mut self) -> Result<(), BackendError> {
        let utils = ext::debug_utils::Instance::new(&self._entry, &self.raw);
        // SAFETY: VK_EXT_debug_utils is enabled (the layer offers it), and the log lives until the messenger is gone.
        let messenger = unsafe { utils.create_debug_utils_messenger(&self.log.messenger(), None) }
            .map_err(|e| unavailable(format!("no validation messages ({e})"), INSTALL_LAYER))?;
        self.messenger = Some((utils, messenger));
        Ok(())
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some((utils, messenger)) = self.messenger.take() {
            // SAFETY: the messenger was made with this instance and is destroyed once.
            unsafe { utils.destroy_debug_utils_messenger(messenger, None) };
        }
        if self.owned {
            // SAFETY: the instance was made here; the device made from it is gone, since it owned this value.
            unsafe { self.raw.destroy_instance(None) };
        }
    }
}

/// `major.minor.patch`.
pub(crate) fn version(packed: u32) -> String {
    format!(
        "{}.{}.{}",
        vk::api_version_major(packed),
        vk::api_version_minor(packed),
        vk::api_version_patch(packed)
    )
}

fn layer_extensions(entry: &ash::Entry) -> Result<Vec<std::ffi::CString>, BackendError> {
    // SAFETY: the entry was loaded; the call has no other requirements.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
    if !layers
        .iter()
        .any(|layer| layer.layer_name_as_c_str() == Ok(LAYER))
    {
        return Err(unavailable(
            format!("the layer {} is not installed", LAYER.to_string_lossy()),
            INSTALL_LAYER,
        ));
    }
    extensions(entry, Some(LAYER))
}

fn extensions(
    entry: &ash::Entry,
    layer: Option<&CStr>,
) -> Result<Vec<std::ffi::CString>, BackendError> {
    // SAFETY: the entry was loaded, and the layer name, if any, ends in a zero.
    let found = unsafe { entry.enumerate_instance_extension_properties(layer) }
        .map_err(|e| no_driver(format!("the Vulkan loader lists no extensions ({e})")))?;
    Ok(found
        .iter()
        .filter_map(|e| Some(e.extension_name_as_c_str().ok()?.to_owned()))
        .collect())
}
