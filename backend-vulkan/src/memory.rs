//! Buffers and their memory.
use crate::device::Device;
use ash::vk;
use gibs_graph::BackendError;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use gpu_allocator::{AllocationError, MemoryLocation};
use std::sync::Arc;

/// A buffer with memory of its own.
pub(crate) struct Buffer {
    pub raw: vk::Buffer,
    /// Bytes, a multiple of 4.
    pub size: u64,
    /// `None` only before it is allocated and while the buffer is dropped.
    memory: Option<Allocation>,
    device: Arc<Device>,
}

impl Buffer {
    /// A buffer on the device that stages can use in any way, of at least 16 bytes and a multiple of 4; `built_from`
    /// has acceleration structures built from it.
    pub fn resource(
        device: &Arc<Device>,
        name: &str,
        bytes: u64,
        built_from: bool,
    ) -> Result<Self, BackendError> {
        use vk::BufferUsageFlags as Usage;
        // All uses, because an adopted buffer serves another schedule.
        let usage = Usage::STORAGE_BUFFER
            | Usage::UNIFORM_BUFFER
            | Usage::INDIRECT_BUFFER
            | Usage::TRANSFER_SRC
            | Usage::TRANSFER_DST
            | match built_from {
                true => {
                    Usage::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR
                        | Usage::SHADER_DEVICE_ADDRESS
                }
                false => Usage::empty(),
            };
        let size = bytes.next_multiple_of(4).max(16);
        Self::new(device, name, size, usage, MemoryLocation::GpuOnly)
    }

    /// Memory of this use on the device, which has an address there.
    pub fn device(
        device: &Arc<Device>,
        name: &str,
        size: u64,
        usage: vk::BufferUsageFlags,
    ) -> Result<Self, BackendError> {
        let usage = usage | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        Self::new(device, name, size, usage, MemoryLocation::GpuOnly)
    }

    /// As [`Buffer::device`], written by the host.
    pub fn host(
        device: &Arc<Device>,
        name: &str,
        size: u64,
        usage: vk::BufferUsageFlags,
    ) -> Result<Self, BackendError> {
        let usage = usage | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        Self::new(device, name, size, usage, MemoryLocation::CpuToGpu)
    }

    /// Memory that the host writes and the device copies from.
    pub fn staging(device: &Arc<Device>, size: u64) -> Result<Self, BackendError> {
        let usage = vk::BufferUsageFlags::TRANSFER_SRC;
        Self::new(device, "(upload)", size, usage, MemoryLocation::CpuToGpu)
    }

    /// Memory that the device copies to and the host reads.
    pub fn readback(device: &Arc<Device>, size: u64) -> Result<Self, BackendError> {
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        Self::new(device, "(read back)", size, usage, MemoryLocation::GpuToCpu)
    }

    fn new(
        device: &Arc<Device>,
        name: &str,
        size: u64,
        usage: vk::BufferUsageFlags,
        location: MemoryLocation,
    ) -> Result<Self, BackendError> {
        let info = vk::BufferCreateInfo::default()
            .size(size)
            .usage(usage)
            .sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: the device is alive, and the size was checked against its limits.
        let raw = unsafe { device.raw.create_buffer(&info, None) }
            .map_err(|e| not_made(device, "vkCreateBuffer", name, size, e))?;
        // From here on dropping the value gives back what it has.
        let mut buffer = Self {
            raw,
            size,
            memory: None,
            device: Arc::clone(device),
        };
        device.name(raw, name);
        // SAFETY: the buffer was made by this device.
        let requirements = unsafe { device.raw.get_buffer_memory_requirements(raw) };
        let memory = allocate(device, name, requirements, location, true)?;
        // SAFETY: the memory was allocated for the requirements of this buffer, which has no memory yet.
        let bound = unsafe {
            device
                .raw
                .bind_buffer_memory(raw, memory.memory(), memory.offset())
        };
        buffer.memory = Some(memory);
        bound.map_err(device.fail("vkBindBufferMemory"))?;
        Ok(buffer)
    }

    /// Where the device finds it; of a buffer that was made to have an address.
    pub fn address(&self) -> u64 {
        let info = vk::BufferDeviceAddressInfo::default().buffer(self.raw);
        // SAFETY: the buffer belongs to this device, which has addresses of buffers, and was made with one.
        unsafe { self.device.raw.get_buffer_device_address(&info) }
    }

    /// The bytes of a staging or read-back buffer; empty for memory that only the device sees.
    pub fn mapped(&mut self) -> &mut [u8] {
        self.memory
            .as_mut()
            .and_then(Allocation::mapped_slice_mut)
            .unwrap_or_default()
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: whoever holds a buffer waits for the work that uses it before dropping it; destroyed once.
        unsafe { self.device.raw.destroy_buffer(self.raw, None) };
        free(&self.device, self.memory.take());
    }
}

/// Why a buffer or an image of `bytes` bytes was not made.
pub(crate) fn not_made(
    device: &Device,
    call: &'static str,
    name: &str,
    bytes: u64,
    error: vk::Result,
) -> BackendError {
    match error {
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
            out_of_memory(device, name, bytes)
        }
        error => device.fail(call)(error),
    }
}

/// Memory for a buffer (`linear`) or an image called `name`.
pub(crate) fn allocate(
    device: &Device,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    linear: bool,
) -> Result<Allocation, BackendError> {
    let allocated = device.allocator().as_mut().map(|allocator| {
        allocator.allocate(&AllocationCreateDesc {
            name,
            requirements,
            location,
            linear,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        })
    });
    match allocated {
        Some(Ok(memory)) => Ok(memory),
        None | Some(Err(AllocationError::OutOfMemory)) => {
            Err(out_of_memory(device, name, requirements.size))
        }
        Some(Err(e)) => Err(BackendError::Device {
            device: device.adapter.info.name.clone(),
            message: format!("memory for `{name}`: {e}"),
        }),
    }
}

/// Gives memory back.
pub(crate) fn free(device: &Device, memory: Option<Allocation>) {
    if let (Some(memory), Some(allocator)) = (memory, device.allocator().as_mut()) {
        // It fails only for memory of another allocator.
        let _ = allocator.free(memory);
    }
}

fn out_of_memory(device: &Device, name: &str, bytes: u64) -> BackendError {
    BackendError::OutOfMemory {
        device: device.adapter.info.name.clone(),
        resource: name.into(),
        bytes,
    }
}
