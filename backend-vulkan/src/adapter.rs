//! Physical devices: what they are, what they allow, and which one to take.
use crate::image;
use crate::instance::{Instance, OLDEST, no_driver, unavailable, version};
use crate::limits;
use crate::rays::{self, Rays};
use ash::{khr, vk};
use gibs_graph::{BackendError, Capabilities, DeviceInfo};
use std::ffi::{CStr, CString};

/// A physical device and everything about it that the backend asks again.
pub(crate) struct Adapter {
    pub physical: vk::PhysicalDevice,
    pub info: DeviceInfo,
    pub capabilities: Capabilities,
    /// Version that device and instance share.
    pub api: u32,
    /// Queue family for compute.
    pub family: u32,
    /// Meaningful bits of a timestamp; 0 where there are none.
    pub timestamp_bits: u32,
    /// Nanoseconds per tick of a timestamp.
    pub timestamp_period: f32,
    /// Names the file that compiled pipelines are kept in.
    pub cache_key: String,
    /// What ray queries take, where the device has them.
    pub rays: Option<Rays>,
    /// Extensions to enable.
    pub extensions: Vec<&'static CStr>,
    rank: u8,
    /// Why it cannot be used.
    unusable: Option<String>,
}

impl Adapter {
    /// Every device that the drivers offer, in their order.
    pub fn list(instance: &Instance) -> Result<Vec<Self>, BackendError> {
        // SAFETY: the instance is alive.
        let found = unsafe { instance.raw.enumerate_physical_devices() }
            .map_err(|e| no_driver(format!("the Vulkan drivers list no devices ({e})")))?;
        Ok(found.into_iter().map(|d| Self::read(instance, d)).collect())
    }

    /// The best device: discrete before integrated before virtual before software. With `name`, only devices whose
    /// name contains it (in any case).
    pub fn choose(instance: &Instance, name: Option<&str>) -> Result<Self, BackendError> {
        let mut adapters = Self::list(instance)?;
        if adapters.is_empty() {
            return Err(no_driver("no Vulkan device was found"));
        }
        if let Some(name) = name {
            let names: Vec<_> = adapters
                .iter()
                .map(|a| format!("`{}`", a.info.name))
                .collect();
            adapters.retain(|a| a.info.name.to_lowercase().contains(&name.to_lowercase()));
            if adapters.is_empty() {
                return Err(unavailable(
                    format!("no Vulkan device is called `{name}`"),
                    format!("choose from {}", names.join(", ")),
                ));
            }
        }
        // Of equal ones the first; `min_by_key` keeps it.
        let best = adapters
            .into_iter()
            .min_by_key(|a| (a.unusable.is_some(), a.rank));
        match best {
            Some(Adapter {
                unusable: Some(reason),
                info,
                ..
            }) => Err(no_driver(format!("the device `{}` {reason}", info.name))),
            Some(adapter) => Ok(adapter),
            None => Err(no_driver("no Vulkan device was found")),
        }
    }

    /// What `physical` is and allows.
    pub fn read(instance: &Instance, physical: vk::PhysicalDevice) -> Self {
        // SAFETY: the physical device belongs to the instance, which is alive.
        let basic = unsafe { instance.raw.get_physical_device_properties(physical) };
        let api = basic.api_version.min(instance.api);
        let extensions = extensions(instance, physical);
        let offers = |name: &CStr| extensions.iter().any(|e| e.as_c_str() == name);
        let families =
            // SAFETY: as above.
            unsafe { instance.raw.get_physical_device_queue_family_properties(physical) };
        let family = compute_family(&families);

        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut maintenance3 = vk::PhysicalDeviceMaintenance3Properties::default();
        let mut maintenance4 = vk::PhysicalDeviceMaintenance4Properties::default();
        if api >= OLDEST {
            let mut all = vk::PhysicalDeviceProperties2::default()
                .push_next(&mut driver)
                .push_next(&mut maintenance3);
            if api >= vk::API_VERSION_1_3 {
                all = all.push_next(&mut maintenance4);
            }
            // SAFETY: as above; the chain holds structs that this version of the API defines.
            unsafe {
                instance
                    .raw
                    .get_physical_device_properties2(physical, &mut all)
            };
        }
        let unusable = unusable(instance, physical, api, family, &offers);

        let family = family.unwrap_or(0);
        let timestamp_bits = families
            .get(family as usize)
            .map_or(0, |f| f.timestamp_valid_bits);
        let (kind, rank) = match basic.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => ("discrete", 0),
            vk::PhysicalDeviceType::INTEGRATED_GPU => ("integrated", 1),
            vk::PhysicalDeviceType::VIRTUAL_GPU => ("virtual", 2),
            _ => ("software", 3),
        };
        let text = |name: Result<&CStr, _>| match name {
            Ok(name) => name.to_string_lossy().into_owned(),
            Err::<_, std::ffi::FromBytesUntilNulError>(_) => String::new(),
        };
        let name = text(basic.device_name_as_c_str());
        let (driver_name, driver_text) = (
            text(driver.driver_name_as_c_str()),
            text(driver.driver_info_as_c_str()),
        );
        let heap = largest_heap(instance, physical);
        let mut notes = vec![
            format!("Vulkan {}", version(basic.api_version)),
            format!("{} MiB of device memory", heap >> 20),
        ];
        notes.extend(unusable.iter().map(|reason| format!("unusable: {reason}")));

        let mut formats = image::FORMATS.to_vec();
        formats.retain(|format| image::is_supported(instance, physical, *format));
        let max_allocation = maintenance3.max_memory_allocation_size;
        let max_buffer = match maintenance4.max_buffer_size {
            0 => max_allocation,
            size => size.min(max_allocation),
        };
        let mut enable = Vec::new();
        if offers(khr::portability_subset::NAME) {
            enable.push(khr::portability_subset::NAME);
        }
        if api < vk::API_VERSION_1_3 {
            enable.push(khr::zero_initialize_workgroup_memory::NAME);
        }
        let rays = Rays::read(instance, physical, api, &offers);
        if rays.is_some() {
            enable.extend(rays::EXTENSIONS);
        }
        let mut capabilities = limits::capabilities(&basic.limits, formats, max_buffer, heap);
        Rays::allow(rays, &mut capabilities);
        Self {
            physical,
            info: DeviceInfo {
                name,
                driver: format!("{driver_name} {driver_text}").trim().to_string(),
                kind: kind.into(),
                timestamps: timestamp_bits > 0,
                ray_query: rays.is_some(),
                notes,
            },
            capabilities,
            api,
            family,
            timestamp_bits,
            timestamp_period: basic.limits.timestamp_period,
            cache_key: cache_key(&basic),
            rays,
            extensions: enable,
            rank,
            unusable,
        }
    }

    /// Why the device cannot be used, if it cannot.
    pub fn unusable(&self) -> Option<&str> {
        self.unusable.as_deref()
    }

    /// Leaves ray queries alone: a host has made the device without them.
    pub fn without_rays(&mut self) {
        self.rays = None;
        self.info.ray_query = false;
        Rays::allow(None, &mut self.capabilities);
    }

    /// Takes the queue family that a host chose.
    pub fn use_family(&mut self, instance: &Instance, family: u32) {
        // SAFETY: the physical device belongs to the instance, which is alive.
        let families = unsafe {
            instance
                .raw
                .get_physical_device_queue_family_properties(self.physical)
        };
        let chosen = families.get(family as usize);
        self.family = family;
        self.timestamp_bits = chosen.map_or(0, |f| f.timestamp_valid_bits);
        self.info.timestamps = self.timestamp_bits > 0;
        if !chosen.is_some_and(|f| f.queue_flags.contains(vk::QueueFlags::COMPUTE)) {
            self.unusable = Some(format!("has no compute in queue family {family}"));
        }
    }
}

/// What the kernels and the frame loop cannot do without.
fn unusable(
    instance: &Instance,
    physical: vk::PhysicalDevice,
    api: u32,
    family: Option<u32>,
    offers: &dyn Fn(&CStr) -> bool,
) -> Option<String> {
    if api < OLDEST {
        return Some(format!("has Vulkan {}, 1.2 is needed", version(api)));
    }
    if family.is_none() {
        return Some("has no compute queue".into());
    }
    let has_zero =
        api >= vk::API_VERSION_1_3 || offers(khr::zero_initialize_workgroup_memory::NAME);
    let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut zero = vk::PhysicalDeviceZeroInitializeWorkgroupMemoryFeatures::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut v12);
    if has_zero {
        features = features.push_next(&mut zero);
    }
    // SAFETY: the physical device belongs to the instance; the chain holds structs that the device knows.
    unsafe {
        instance
            .raw
            .get_physical_device_features2(physical, &mut features)
    };
    if v12.timeline_semaphore == vk::FALSE {
        return Some("has no timeline semaphores".into());
    }
    if zero.shader_zero_initialize_workgroup_memory == vk::FALSE {
        return Some("cannot set workgroup memory to zero".into());
    }
    None
}

/// A family with compute, the one with the widest timestamps.
fn compute_family(families: &[vk::QueueFamilyProperties]) -> Option<u32> {
    let compute = |f: &vk::QueueFamilyProperties| {
        f.queue_count > 0 && f.queue_flags.contains(vk::QueueFlags::COMPUTE)
    };
    (0..families.len() as u32)
        .filter(|&i| compute(&families[i as usize]))
        // `min_by_key` keeps the first of equal ones, which on desktop drivers is the universal family.
        .min_by_key(|&i| std::cmp::Reverse(families[i as usize].timestamp_valid_bits))
}

fn largest_heap(instance: &Instance, physical: vk::PhysicalDevice) -> u64 {
    // SAFETY: the physical device belongs to the instance, which is alive.
    let memory = unsafe { instance.raw.get_physical_device_memory_properties(physical) };
    memory
        .memory_heaps_as_slice()
        .iter()
        .filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL))
        .map(|heap| heap.size)
        .max()
        .unwrap_or(0)
}

fn extensions(instance: &Instance, physical: vk::PhysicalDevice) -> Vec<CString> {
    // SAFETY: the physical device belongs to the instance, which is alive.
    unsafe { instance.raw.enumerate_device_extension_properties(physical) }
        .unwrap_or_default()
        .iter()
        .filter_map(|e| Some(e.extension_name_as_c_str().ok()?.to_owned()))
        .collect()
}

/// The identity that drivers hold cached pipelines against.
fn cache_key(properties: &vk::PhysicalDeviceProperties) -> String {
    let uuid: String = properties
        .pipeline_cache_uuid
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    format!(
        "{:04x}-{:04x}-{uuid}",
        properties.vendor_id, properties.device_id
    )
}
