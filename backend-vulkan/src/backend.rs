//! The backend: a device, and executables made for it.
use crate::adapter::Adapter;
use crate::device::Device;
use crate::executable::VulkanExecutable;
use crate::instance::{Instance, unavailable};
use crate::validation::ValidationLog;
use ash::vk;
use gibs_graph::{Backend, BackendError, Capabilities, DeviceInfo, Executable, Schedule};
use std::fmt;
use std::sync::Arc;

/// How the backend starts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Check every call with the validation layer.
    pub validation: bool,
    /// Check also that hazards have barriers; turns the layer on.
    pub sync_validation: bool,
    /// Only a device whose name contains this, in any case.
    pub device: Option<String>,
}

/// Vulkan as a backend.
pub struct VulkanBackend {
    device: Arc<Device>,
}

impl VulkanBackend {
    /// Starts the best device: discrete before integrated before virtual before software.
    ///
    /// # Errors
    /// [`BackendError::Unavailable`] without a loader, a driver, a device that fits or a layer that was asked for; it
    /// says what to install.
    pub fn new(options: Options) -> Result<Self, BackendError> {
        let instance = Instance::new(&options)?;
        let adapter = Adapter::choose(&instance, options.device.as_deref())?;
        Ok(Self {
            device: Arc::new(Device::new(instance, adapter)?),
        })
    }

    /// Every device that the drivers offer, also those that cannot be used, with the reason among their notes.
    ///
    /// # Errors
    /// [`BackendError::Unavailable`] without a loader or a driver.
    pub fn devices() -> Result<Vec<DeviceInfo>, BackendError> {
        let instance = Instance::new(&Options::default())?;
        Ok(Adapter::list(&instance)?
            .into_iter()
            .map(|adapter| adapter.info)
            .collect())
    }

    /// Uses the device of an engine, which stays its owner. Nothing is destroyed here but what is made here.
    ///
    /// `family` is the queue's family; it needs compute. `api` is the version that the instance was made for.
    ///
    /// # Errors
    /// [`BackendError::Unavailable`] if the device is too old or lacks a feature.
    ///
    /// # Safety
    /// - The handles belong together and outlive this value and every executable made from it.
    /// - The device was made with the features `timelineSemaphore` and `shaderZeroInitializeWorkgroupMemory` (Vulkan
    ///   1.3, or VK_KHR_zero_initialize_workgroup_memory).
    /// - Nobody else uses the queue during a call of this value or of an executable made from it.
    pub unsafe fn from_host(
        entry: ash::Entry,
        instance: ash::Instance,
        api: u32,
        physical_device: vk::PhysicalDevice,
        device: ash::Device,
        queue: vk::Queue,
        family: u32,
    ) -> Result<Self, BackendError> {
        let handles = (entry, instance, api, physical_device, device);
        Self::of_host(handles, (queue, family), false)
    }

    /// As [`VulkanBackend::from_host`], of a device that was made to trace rays.
    ///
    /// # Errors
    /// As [`VulkanBackend::from_host`], and if the physical device has no ray queries.
    ///
    /// # Safety
    /// As [`VulkanBackend::from_host`]; and the device was made with the extensions `VK_KHR_acceleration_structure`,
    /// `VK_KHR_deferred_host_operations` and `VK_KHR_ray_query` and the features `accelerationStructure`, `rayQuery` and
    /// `bufferDeviceAddress`.
    pub unsafe fn from_host_with_ray_queries(
        entry: ash::Entry,
        instance: ash::Instance,
        api: u32,
        physical_device: vk::PhysicalDevice,
        device: ash::Device,
        queue: vk::Queue,
        family: u32,
    ) -> Result<Self, BackendError> {
        let handles = (entry, instance, api, physical_device, device);
        Self::of_host(handles, (queue, family), true)
    }

    fn of_host(
        handles: (
            ash::Entry,
            ash::Instance,
            u32,
            vk::PhysicalDevice,
            ash::Device,
        ),
        (queue, family): (vk::Queue, u32),
        traces: bool,
    ) -> Result<Self, BackendError> {
        let (entry, instance, api, physical_device, device) = handles;
        let instance = Instance::from_host(entry, instance, api);
        let mut adapter = Adapter::read(&instance, physical_device);
        adapter.use_family(&instance, family);
        if let Some(reason) = adapter.unusable() {
            return Err(unavailable(
                format!("the device `{}` {reason}", adapter.info.name),
                "make the device for Vulkan 1.2 or newer and with a compute queue",
            ));
        }
        if !traces {
            adapter.without_rays();
        } else if adapter.rays.is_none() {
            return Err(unavailable(
                format!("the device `{}` has no ray queries", adapter.info.name),
                "use from_host, which does without them",
            ));
        }
        let device = Device::share(instance, adapter, device, queue, false)?;
        Ok(Self {
            device: Arc::new(device),
        })
    }

    /// As [`Backend::prepare`], for those who record frames into their own command buffers.
    ///
    /// # Errors
    /// As [`Backend::prepare`].
    pub fn prepare_vulkan(
        &self,
        schedule: Arc<Schedule>,
    ) -> Result<VulkanExecutable, BackendError> {
        VulkanExecutable::new(&self.device, schedule)
    }

    /// What the validation layer has said so far; empty without the layer.
    pub fn validation_messages(&self) -> Vec<String> {
        self.validation_log().messages()
    }

    /// The log of the validation layer, which also sees what comes while the backend is dropped.
    pub fn validation_log(&self) -> ValidationLog {
        self.device.instance.log.clone()
    }
}

impl Backend for VulkanBackend {
    fn name(&self) -> &str {
        "vulkan"
    }

    fn device(&self) -> &DeviceInfo {
        &self.device.adapter.info
    }

    fn capabilities(&self) -> &Capabilities {
        &self.device.adapter.capabilities
    }

    fn prepare(&self, schedule: Arc<Schedule>) -> Result<Box<dyn Executable>, BackendError> {
        Ok(Box::new(self.prepare_vulkan(schedule)?))
    }
}

impl fmt::Debug for VulkanBackend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("VulkanBackend")
            .field("device", self.device())
            .finish()
    }
}
