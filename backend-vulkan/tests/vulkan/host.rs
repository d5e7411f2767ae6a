//! The backend on a device that somebody else made and keeps.
use crate::state::counting;
use crate::support::{prepare, read, start, upload};
use gibs_backend_vulkan::ash::{self, vk};
use gibs_backend_vulkan::{VulkanBackend, VulkanExecutable};
use gibs_graph::{Backend, Executable};

/// An engine: the least that makes a device with a compute queue.
struct Engine {
    entry: ash::Entry,
    instance: ash::Instance,
    physical: vk::PhysicalDevice,
    device: ash::Device,
    queue: vk::Queue,
    family: u32,
}

const API: u32 = vk::API_VERSION_1_2;

impl Engine {
    /// # Safety
    /// A driver is there.
    unsafe fn new() -> Self {
        // SAFETY: calls in the order that Vulkan wants, with pointers to locals only.
        unsafe {
            let entry = ash::Entry::load().unwrap();
            let application = vk::ApplicationInfo::default().api_version(API);
            let info = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = entry.create_instance(&info, None).unwrap();
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
            Self {
                entry,
                instance,
                physical,
                device,
                queue,
                family,
            }
        }
    }
}

#[test]
fn the_device_of_an_engine_is_used_and_left_alone() {
    if start().is_none() {
        return;
    }
    // SAFETY: a driver is there; the handles belong together and are destroyed after everything made from them.
    unsafe {
        let engine = Engine::new();
        let backend = VulkanBackend::from_host(
            engine.entry.clone(),
            engine.instance.clone(),
            API,
            engine.physical,
            engine.device.clone(),
            engine.queue,
            engine.family,
        )
        .unwrap();
        assert!(
            backend
                .device()
                .notes
                .iter()
                .any(|note| note.starts_with("Vulkan"))
        );
        let mut e = prepare(&backend, counting(10));
        upload(&mut *e, "source", &[2u32; 10]);
        e.run().unwrap();
        assert_eq!(read(&mut *e, "total"), (2..12).collect::<Vec<u32>>());

        let total = e.schedule().resource("total").unwrap();
        let executable = e.into_any().downcast::<VulkanExecutable>().unwrap();
        assert!(executable.buffer(total).is_some());
        assert_eq!(executable.buffer(99), None);
        assert_eq!(executable.schedule().name, "counting");
        drop(executable);
        drop(backend);

        engine.device.device_wait_idle().unwrap();
        engine.device.destroy_device(None);
        engine.instance.destroy_instance(None);
    }
}
