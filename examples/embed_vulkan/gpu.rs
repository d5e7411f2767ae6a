//! The engine's device and its queue.
use super::instance::{API, Instance, Log};
use gibs_backend_vulkan::ash::{self, khr, vk};
use std::error::Error;

/// A device with one queue, for graphics and compute.
pub struct Gpu {
    pub device: ash::Device,
    pub queue: vk::Queue,
    pub family: u32,
    pub physical: vk::PhysicalDevice,
    pub name: String,
    pub memory: vk::PhysicalDeviceMemoryProperties,
    /// Last, since the device goes before it.
    pub instance: Instance,
}

impl Gpu {
    /// Takes the best device: discrete before integrated before others. With a log, under validation; where it `traces`, made for
    /// ray queries.
    ///
    /// # Errors
    /// No device fits, or what the driver says.
    pub fn new(log: Option<&Log>, traces: bool) -> Result<Self, Box<dyn Error>> {
        let instance = Instance::new(log)?;
        // SAFETY: the instance is alive.
        let found = unsafe { instance.raw.enumerate_physical_devices() }?;
        // SAFETY: the devices are those of the instance.
        let fits = |&physical: &_| unsafe { Some((physical, fitting(&instance, physical)?)) };
        let (physical, (_, family)) = found
            .iter()
            .filter_map(fits)
            .min_by_key(|(_, (rank, _))| *rank)
            .ok_or("no device has Vulkan 1.3, what the engine needs of it, and a graphics queue")?;
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(family)
            .queue_priorities(&[1.0])];
        // What gibs needs, and what the engine itself does.
        let mut v12 = vk::PhysicalDeviceVulkan12Features::default()
            .timeline_semaphore(true)
            .buffer_device_address(traces);
        let mut structures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default()
            .acceleration_structure(true);
        let mut queries = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true);
        let extensions = [
            khr::acceleration_structure::NAME.as_ptr(),
            khr::deferred_host_operations::NAME.as_ptr(),
            khr::ray_query::NAME.as_ptr(),
        ];
        let mut v13 = vk::PhysicalDeviceVulkan13Features::default()
            .shader_zero_initialize_workgroup_memory(true)
            .dynamic_rendering(true);
        let mut info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .push_next(&mut v12)
            .push_next(&mut v13);
        if traces {
            info = info
                .enabled_extension_names(&extensions)
                .push_next(&mut structures)
                .push_next(&mut queries);
        }
        // SAFETY: the device has the queue family and the features, but for those of ray queries, without which the driver
        // refuses the call; pointers in `info` are to locals.
        unsafe {
            let device = instance.raw.create_device(physical, &info, None)?;
            let properties = instance.raw.get_physical_device_properties(physical);
            let name = properties.device_name_as_c_str()?;
            Ok(Self {
                queue: device.get_device_queue(family, 0),
                family,
                physical,
                name: name.to_string_lossy().into_owned(),
                memory: instance.raw.get_physical_device_memory_properties(physical),
                device,
                instance,
            })
        }
    }
}

/// The rank of a device, smaller is better, and its first queue family for graphics and compute. `None` where the
/// device cannot be used.
///
/// # Safety
/// The device is one of the instance.
unsafe fn fitting(instance: &Instance, physical: vk::PhysicalDevice) -> Option<(u32, u32)> {
    let (mut v12, mut v13) = (
        vk::PhysicalDeviceVulkan12Features::default(),
        vk::PhysicalDeviceVulkan13Features::default(),
    );
    // SAFETY: the caller's promise; a device of 1.3 knows both structs of features.
    let (properties, families) = unsafe {
        let properties = instance.raw.get_physical_device_properties(physical);
        if properties.api_version < API {
            return None;
        }
        let mut features = vk::PhysicalDeviceFeatures2::default()
            .push_next(&mut v12)
            .push_next(&mut v13);
        instance
            .raw
            .get_physical_device_features2(physical, &mut features);
        let families = instance
            .raw
            .get_physical_device_queue_family_properties(physical);
        (properties, families)
    };
    let needed = [
        v12.timeline_semaphore,
        v13.shader_zero_initialize_workgroup_memory,
        v13.dynamic_rendering,
    ];
    let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    let family = families.iter().position(|f| f.queue_flags.contains(both))?;
    let rank = match properties.device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => 0,
        vk::PhysicalDeviceType::INTEGRATED_GPU => 1,
        _ => 2,
    };
    (!needed.contains(&vk::FALSE)).then_some((rank, family as u32))
}

impl Drop for Gpu {
    fn drop(&mut self) {
        // SAFETY: what was made from the device borrowed it, or was declared after it, and is gone.
        unsafe { self.device.destroy_device(None) };
    }
}
