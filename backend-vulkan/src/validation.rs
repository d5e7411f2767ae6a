//! What the validation layer says.
use ash::vk;
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

/// Every warning and error of the validation layer since the backend was made, oldest first.
///
/// A clone sees the same messages, also those that come while the backend itself is dropped.
#[derive(Clone, Debug, Default)]
pub struct ValidationLog(Arc<Mutex<Vec<String>>>);

impl ValidationLog {
    /// The messages, each as `name of the rule: text`.
    pub fn messages(&self) -> Vec<String> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    /// Asks for warnings and errors to be put into this log. The log must outlive the messenger.
    pub(crate) fn messenger(&self) -> vk::DebugUtilsMessengerCreateInfoEXT<'_> {
        use vk::DebugUtilsMessageSeverityFlagsEXT as Severity;
        use vk::DebugUtilsMessageTypeFlagsEXT as Type;
        // General messages are about the loader and its search for drivers, not about what is called.
        vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(Severity::WARNING | Severity::ERROR)
            .message_type(Type::VALIDATION | Type::PERFORMANCE)
            .pfn_user_callback(Some(receive))
            .user_data(Arc::as_ptr(&self.0).cast_mut().cast())
    }
}

/// Called by the layer, on whatever thread made the call that it complains about.
///
/// # Safety
/// `data` is null or what the layer passes, alive during the call, and `log` null or that of [`ValidationLog::messenger`].
unsafe extern "system" fn receive(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    log: *mut c_void,
) -> vk::Bool32 {
    if data.is_null() || log.is_null() {
        return vk::FALSE;
    }
    // SAFETY: the layer passes a valid struct whose strings are null or end in a zero, all alive during this call.
    let (rule, text) = unsafe {
        let text = |s: *const std::ffi::c_char| match s.is_null() {
            true => String::new(),
            false => CStr::from_ptr(s).to_string_lossy().into_owned(),
        };
        (text((*data).p_message_id_name), text((*data).p_message))
    };
    // SAFETY: the pointer was made by `ValidationLog::messenger` from an Arc that the instance keeps until after the
    // messenger is gone.
    let log = unsafe { &*log.cast::<Mutex<Vec<String>>>() };
    log.lock()
        .unwrap_or_else(PoisonError::into_inner)
        .push(format!("{rule}: {text}"));
    vk::FALSE
}
