//! The device that the backend and all of its executables share.
use crate::adapter::Adapter;
use crate::cache;
use crate::instance::{Instance, no_driver};
use crate::kernels::Kernels;
use ash::{ext, khr, vk};
use gibs_graph::BackendError;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use gpu_allocator::{AllocationSizes, AllocatorDebugSettings};
use std::ffi::{CStr, CString};
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A logical device with its queue, its memory and its pipelines. Executables hold it in an `Arc`, so it goes when
/// the last of them and the backend are gone.
pub(crate) struct Device {
    pub raw: ash::Device,
    pub adapter: Adapter,
    queue: Mutex<vk::Queue>,
    /// `None` only while the device is dropped.
    allocator: Mutex<Option<Allocator>>,
    kernels: Mutex<Kernels>,
    pub pipeline_cache: vk::PipelineCache,
    cache_path: Option<PathBuf>,
    names: Option<ext::debug_utils::Device>,
    /// Functions of acceleration structures, where ray queries were enabled.
    pub rays: Option<khr::acceleration_structure::Device>,
    owned: bool,
    /// Last, since everything above was made from it.
    pub instance: Instance,
}

/// Names what failed; for `map_err`.
pub(crate) fn failed(device: &str, call: &str, error: vk::Result) -> BackendError {
    BackendError::Device {
        device: device.into(),
        message: format!("{call}: {error}"),
    }
}

impl Device {
    /// Makes a device with one queue.
    pub fn new(instance: Instance, adapter: Adapter) -> Result<Self, BackendError> {
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(adapter.family)
            .queue_priorities(&priorities)];
        let extensions: Vec<_> = adapter.extensions.iter().map(|e| e.as_ptr()).collect();
        let traces = adapter.rays.is_some();
        let mut v12 = vk::PhysicalDeviceVulkan12Features::default()
            .timeline_semaphore(true)
            .buffer_device_address(traces);
        let mut structures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default()
            .acceleration_structure(true);
        let mut queries = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true);
        let mut v13 = vk::PhysicalDeviceVulkan13Features::default()
            .shader_zero_initialize_workgroup_memory(true)
            .maintenance4(true);
        let mut zero = vk::PhysicalDeviceZeroInitializeWorkgroupMemoryFeatures::default()
            .shader_zero_initialize_workgroup_memory(true);
        let mut info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .push_next(&mut v12);
        info = if adapter.api >= vk::API_VERSION_1_3 {
            info.push_next(&mut v13)
        } else {
            info.push_next(&mut zero)
        };
        if traces {
            info = info.push_next(&mut structures).push_next(&mut queries);
        }
        // SAFETY: the physical device belongs to the instance, was found to have these features and extensions, and
        // all pointers are to locals that live until after the call.
        let raw =
            unsafe { instance.raw.create_device(adapter.physical, &info, None) }.map_err(|e| {
                no_driver(format!(
                    "the device `{}` does not start ({e})",
                    adapter.info.name
                ))
            })?;
        // SAFETY: the device was made with one queue of this family.
        let queue = unsafe { raw.get_device_queue(adapter.family, 0) };
        Self::share(instance, adapter, raw, queue, true)
    }

    /// Wraps a device. With `owned` it is destroyed in the end.
    pub fn share(
        instance: Instance,
        adapter: Adapter,
        raw: ash::Device,
        queue: vk::Queue,
        owned: bool,
    ) -> Result<Self, BackendError> {
        const MIB: u64 = 1 << 20;
        // Small first blocks that grow: a small scene does not take hundreds of megabytes.
        let sizes = AllocationSizes::new(16 * MIB, 8 * MIB)
            .with_max_device_memblock_size(256 * MIB)
            .with_max_host_memblock_size(64 * MIB);
        let names = instance
            .names
            .then(|| ext::debug_utils::Device::new(&instance.raw, &raw));
        let rays = adapter
            .rays
            .map(|_| khr::acceleration_structure::Device::new(&instance.raw, &raw));
        let cache_path = cache::path(&adapter.cache_key);
        let mut device = Self {
            raw,
            adapter,
            queue: Mutex::new(queue),
            allocator: Mutex::new(None),
            kernels: Mutex::default(),
            pipeline_cache: vk::PipelineCache::null(),
            cache_path,
            names,
            rays,
            owned,
            instance,
        };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: device.instance.raw.clone(),
            device: device.raw.clone(),
            physical_device: device.adapter.physical,
            debug_settings: AllocatorDebugSettings::default(),
            buffer_device_address: device.rays.is_some(),
            allocation_sizes: sizes,
        });
        let allocator = allocator.map_err(|e| BackendError::Device {
            device: device.adapter.info.name.clone(),
            message: format!("no memory allocator: {e}"),
        })?;
        *device.allocator() = Some(allocator);
        device.pipeline_cache = device.load_pipelines()?;
        Ok(device)
    }

    /// Makes an error of what a call returned.
    pub fn fail(&self, call: &'static str) -> impl Fn(vk::Result) -> BackendError + '_ {
        move |error| failed(&self.adapter.info.name, call, error)
    }

    /// The allocator.
    pub fn allocator(&self) -> MutexGuard<'_, Option<Allocator>> {
        self.allocator
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// The kernels that were built on this device.
    pub fn kernels(&self) -> MutexGuard<'_, Kernels> {
        self.kernels.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Submits, in order with all other executables of this device.
    pub fn submit(&self, submission: &vk::SubmitInfo<'_>) -> Result<(), BackendError> {
        let queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: the queue belongs to this device and is locked; callers pass command buffers of this device that
        // were recorded completely and are not pending.
        unsafe {
            self.raw
                .queue_submit(*queue, &[*submission], vk::Fence::null())
        }
        .map_err(self.fail("vkQueueSubmit"))
    }

    /// Names an object for tools and for messages of the validation layer.
    pub fn name<T: vk::Handle>(&self, object: T, name: &str) {
        if let (Some(names), Ok(name)) = (&self.names, CString::new(name)) {
            let info = vk::DebugUtilsObjectNameInfoEXT::default()
                .object_handle(object)
                .object_name(&name);
            // SAFETY: the object belongs to this device and no other thread has it yet. Failing to name it is no harm.
            let _ = unsafe { names.set_debug_utils_object_name(&info) };
        }
    }

    /// Opens a named region in a command buffer, for tools.
    pub fn begin_label(&self, commands: vk::CommandBuffer, name: &CStr) {
        if let Some(names) = &self.names {
            let info = vk::DebugUtilsLabelEXT::default().label_name(name);
            // SAFETY: the command buffer is being recorded by the caller.
            unsafe { names.cmd_begin_debug_utils_label(commands, &info) };
        }
    }

    /// Closes the region.
    pub fn end_label(&self, commands: vk::CommandBuffer) {
        if let Some(names) = &self.names {
            // SAFETY: the command buffer is being recorded by the caller, who opened a region in it.
            unsafe { names.cmd_end_debug_utils_label(commands) };
        }
    }

    fn load_pipelines(&self) -> Result<vk::PipelineCache, BackendError> {
        let data = self
            .cache_path
            .as_deref()
            .and_then(cache::load)
            .unwrap_or_default();
        let create = |data: &[u8]| {
            let info = vk::PipelineCacheCreateInfo::default().initial_data(data);
            // SAFETY: the device is alive; the data is what a driver gave (its checksum holds), or empty, and the
            // driver checks that it is its own.
            unsafe { self.raw.create_pipeline_cache(&info, None) }
        };
        create(&data)
            .or_else(|_| create(&[]))
            .map_err(self.fail("vkCreatePipelineCache"))
    }

    /// Keeps the compiled pipelines for the next start. Not being able to is no harm.
    pub fn save_pipelines(&self) {
        let Some(path) = &self.cache_path else { return };
        // SAFETY: the cache belongs to this device.
        if let Ok(data) = unsafe { self.raw.get_pipeline_cache_data(self.pipeline_cache) } {
            let _ = cache::save(path, &data);
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let kernels = std::mem::take(&mut *self.kernels());
        // SAFETY: executables hold the device and waited for their work before they let go, so nothing made from it
        // is in use; each object is destroyed once, the device last and only if it was made here.
        unsafe {
            for kernel in kernels.all() {
                kernel.destroy(&self.raw);
            }
            self.raw.destroy_pipeline_cache(self.pipeline_cache, None);
            drop(self.allocator().take());
            if self.owned {
                self.raw.destroy_device(None);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_device_is_an_error_that_says_so() {
        let error = failed("GPU", "vkQueueSubmit", vk::Result::ERROR_DEVICE_LOST);
        let text = error.to_string();
        assert!(matches!(error, BackendError::Device { .. }));
        assert!(
            text.contains("GPU") && text.contains("vkQueueSubmit"),
            "{text}"
        );
        assert!(text.to_lowercase().contains("lost"), "{text}");
    }
}
