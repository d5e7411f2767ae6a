//! What it takes to trace rays on the device: extensions, features and limits.
use crate::instance::{Instance, OLDEST};
use ash::{khr, vk};
use gibs_graph::Capabilities;
use std::ffi::CStr;

/// Extensions that acceleration structures and queries of them take; the rest that they ask for is in Vulkan 1.2.
pub(crate) const EXTENSIONS: [&CStr; 3] = [
    khr::acceleration_structure::NAME,
    khr::deferred_host_operations::NAME,
    khr::ray_query::NAME,
];

/// What a device with ray queries allows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rays {
    /// Scratch memory of a build starts at a multiple of this.
    pub scratch_alignment: u64,
    triangles: u64,
    instances: u64,
}

impl Rays {
    /// `None` where the device has no ray queries.
    pub fn read(
        instance: &Instance,
        physical: vk::PhysicalDevice,
        api: u32,
        offers: &dyn Fn(&CStr) -> bool,
    ) -> Option<Self> {
        if api < OLDEST || !EXTENSIONS.into_iter().all(offers) {
            return None;
        }
        let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut structures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default();
        let mut queries = vk::PhysicalDeviceRayQueryFeaturesKHR::default();
        let mut features = vk::PhysicalDeviceFeatures2::default()
            .push_next(&mut v12)
            .push_next(&mut structures)
            .push_next(&mut queries);
        // SAFETY: the physical device belongs to the instance, which is alive; it knows the structs in the chain.
        unsafe {
            instance
                .raw
                .get_physical_device_features2(physical, &mut features)
        };
        let has_all = [
            v12.buffer_device_address,
            structures.acceleration_structure,
            queries.ray_query,
        ];
        if has_all.contains(&vk::FALSE) {
            return None;
        }
        let mut limits = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
        let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut limits);
        // SAFETY: as above.
        unsafe {
            instance
                .raw
                .get_physical_device_properties2(physical, &mut all)
        };
        Some(Self {
            scratch_alignment: limits
                .min_acceleration_structure_scratch_offset_alignment
                .max(1)
                .into(),
            triangles: limits.max_primitive_count,
            instances: limits.max_instance_count,
        })
    }

    /// Enters what is allowed into `capabilities`, or that there is none.
    pub fn allow(rays: Option<Self>, capabilities: &mut Capabilities) {
        capabilities.ray_query = rays.is_some();
        capabilities.structure_triangles = rays.map_or(0, |r| r.triangles);
        capabilities.structure_instances = rays.map_or(0, |r| r.instances);
    }
}
