//! An engine: a device with a queue, a few images and buffers, watched by the validation layer.
mod work;

use crate::support::start;
use gibs_backend_vulkan::VulkanBackend;
use gibs_backend_vulkan::ash::{self, ext, vk};
use std::cell::RefCell;
use std::ffi::{CStr, c_void};
use std::sync::Mutex;

pub use work::{FRESH, Lent, Room, TRANSFER_READ, TRANSFER_WRITE, whole};

const API: u32 = vk::API_VERSION_1_2;

pub struct Engine {
    pub entry: ash::Entry,
    pub instance: ash::Instance,
    pub physical: vk::PhysicalDevice,
    pub device: ash::Device,
    pub queue: vk::Queue,
    pub family: u32,
    pool: vk::CommandPool,
    images: RefCell<Vec<Lent>>,
    buffers: RefCell<Vec<Room>>,
    messenger: (ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT),
    messages: Box<Mutex<Vec<String>>>,
}

/// Runs `test` on an engine, and fails on any message of the layer. Not run where [`start`] gives nothing.
pub fn engaged(test: impl FnOnce(&Engine)) {
    if let Some(messages) = overheard(test) {
        assert_eq!(messages, Vec::<String>::new());
    }
}

/// As [`engaged`], for tests that look at the messages themselves.
pub fn overheard(test: impl FnOnce(&Engine)) -> Option<Vec<String>> {
    start()?;
    // SAFETY: a driver and the layer are there.
    let engine = unsafe { Engine::new() };
    test(&engine);
    // SAFETY: the test has dropped what it made from the engine.
    Some(unsafe { engine.end() })
}

unsafe extern "system" fn receive(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    log: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes a valid struct, and the log lives as long as the messenger.
    unsafe {
        let text = CStr::from_ptr((*data).p_message).to_string_lossy();
        let log = &*log.cast::<Mutex<Vec<String>>>();
        log.lock().unwrap().push(text.into_owned());
    }
    vk::FALSE
}

impl Engine {
    /// # Safety
    /// A driver and the validation layer are there.
    unsafe fn new() -> Self {
        use vk::DebugUtilsMessageSeverityFlagsEXT as Severity;
        use vk::DebugUtilsMessageTypeFlagsEXT as Type;
        // SAFETY: calls in the order that Vulkan wants, with pointers to locals only; the log is on the heap.
        unsafe {
            let entry = ash::Entry::load().unwrap();
            let messages: Box<Mutex<Vec<String>>> = Box::default();
            let application = vk::ApplicationInfo::default().api_version(API);
            let layers = [c"VK_LAYER_KHRONOS_validation".as_ptr()];
            let extensions = [
                ext::debug_utils::NAME.as_ptr(),
                ext::validation_features::NAME.as_ptr(),
            ];
            let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
            let mut features =
                vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
            let info = vk::InstanceCreateInfo::default()
                .application_info(&application)
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions)
                .push_next(&mut features);
            let instance = entry.create_instance(&info, None).unwrap();
            let utils = ext::debug_utils::Instance::new(&entry, &instance);
            let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
                .message_severity(Severity::WARNING | Severity::ERROR)
                .message_type(Type::VALIDATION | Type::PERFORMANCE)
                .pfn_user_callback(Some(receive))
                .user_data((&raw const *messages).cast_mut().cast());
            let messenger = utils.create_debug_utils_messenger(&info, None).unwrap();
            let physical = instance.enumerate_physical_devices().unwrap()[0];
            let family = instance
                .get_physical_device_queue_family_properties(physical)
                .iter()
                .position(|f| f.queue_flags.contains(vk::QueueFlags::COMPUTE))
                .unwrap() as u32;
            let queues = [vk::DeviceQueueCreateInfo::default()
                .queue_family_index(family)
                .queue_priorities(&[1.0])];
            let extensions = [ash::khr::zero_initialize_workgroup_memory::NAME.as_ptr()];
            let mut v12 = vk::PhysicalDeviceVulkan12Features::default().timeline_semaphore(true);
            let mut zero = vk::PhysicalDeviceZeroInitializeWorkgroupMemoryFeatures::default()
                .shader_zero_initialize_workgroup_memory(true);
            let info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_extension_names(&extensions)
                .push_next(&mut v12)
                .push_next(&mut zero);
            let device = instance.create_device(physical, &info, None).unwrap();
            let queue = device.get_device_queue(family, 0);
            let info = vk::CommandPoolCreateInfo::default().queue_family_index(family);
            let pool = device.create_command_pool(&info, None).unwrap();
            Self {
                entry,
                instance,
                physical,
                device,
                queue,
                family,
                pool,
                images: RefCell::default(),
                buffers: RefCell::default(),
                messenger: (utils, messenger),
                messages,
            }
        }
    }

    /// Destroys everything; gives what the layer said.
    unsafe fn end(self) -> Vec<String> {
        // SAFETY: nothing is under way after the wait; each handle is destroyed once, in the right order.
        unsafe {
            self.device.device_wait_idle().unwrap();
            for lent in self.images.take() {
                self.device.destroy_image_view(lent.view, None);
                self.device.destroy_image(lent.image, None);
                self.device.free_memory(lent.memory, None);
            }
            for room in self.buffers.take() {
                self.device.destroy_buffer(room.buffer, None);
                self.device.free_memory(room.memory, None);
            }
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_device(None);
            let (utils, messenger) = self.messenger;
            utils.destroy_debug_utils_messenger(messenger, None);
            self.instance.destroy_instance(None);
        }
        self.messages.into_inner().unwrap()
    }

    /// A backend on the engine's device; dropped before the engine ends.
    pub fn backend(&self) -> VulkanBackend {
        // SAFETY: the handles belong together, and tests drop the backend before the engine ends.
        unsafe {
            VulkanBackend::from_host(
                self.entry.clone(),
                self.instance.clone(),
                API,
                self.physical,
                self.device.clone(),
                self.queue,
                self.family,
            )
        }
        .unwrap()
    }
}
