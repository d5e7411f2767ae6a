//! Images and buffers of the engine.
use super::gpu::Gpu;
use gibs_backend_vulkan::ImageUse;
use gibs_backend_vulkan::ash::vk;
use std::error::Error;

/// Memory for something with these needs.
fn allocate(
    gpu: &Gpu,
    needs: vk::MemoryRequirements,
    wanted: vk::MemoryPropertyFlags,
) -> Result<vk::DeviceMemory, Box<dyn Error>> {
    let types = gpu.memory.memory_types_as_slice();
    let kind = (0..).zip(types).find(|(i, offered)| {
        needs.memory_type_bits & 1 << i != 0 && offered.property_flags.contains(wanted)
    });
    let (kind, _) = kind.ok_or("the device has no memory of the kind that is needed")?;
    let info = vk::MemoryAllocateInfo::default()
        .allocation_size(needs.size)
        .memory_type_index(kind);
    // SAFETY: the device has a memory type of that index.
    Ok(unsafe { gpu.device.allocate_memory(&info, None) }?)
}

/// A two-dimensional image of one level.
pub struct Image<'a> {
    pub raw: vk::Image,
    pub view: vk::ImageView,
    pub aspect: vk::ImageAspectFlags,
    memory: vk::DeviceMemory,
    gpu: &'a Gpu,
}

impl<'a> Image<'a> {
    /// # Errors
    /// What the driver says.
    pub fn new(
        gpu: &'a Gpu,
        [width, height]: [u32; 2],
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Result<Self, Box<dyn Error>> {
        let aspect = match format {
            vk::Format::D32_SFLOAT => vk::ImageAspectFlags::DEPTH,
            _ => vk::ImageAspectFlags::COLOR,
        };
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D {
                width,
                height,
                depth: 1,
            })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        let device = &gpu.device;
        // SAFETY: the device is alive, and the image gets memory of its own before its view.
        unsafe {
            let mut made = Self {
                raw: device.create_image(&info, None)?,
                view: vk::ImageView::null(),
                aspect,
                memory: vk::DeviceMemory::null(),
                gpu,
            };
            let needs = device.get_image_memory_requirements(made.raw);
            made.memory = allocate(gpu, needs, vk::MemoryPropertyFlags::DEVICE_LOCAL)?;
            device.bind_image_memory(made.raw, made.memory, 0)?;
            let info = vk::ImageViewCreateInfo::default()
                .image(made.raw)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(made.whole());
            made.view = device.create_image_view(&info, None)?;
            Ok(made)
        }
    }

    /// Has the next use of the image wait for the last.
    ///
    /// # Safety
    /// The commands are being recorded, and the image was last used as `from` says.
    pub unsafe fn pass(&self, commands: vk::CommandBuffer, from: ImageUse, to: ImageUse) {
        let barrier = [vk::ImageMemoryBarrier::default()
            .src_access_mask(from.access)
            .dst_access_mask(to.access)
            .old_layout(from.layout)
            .new_layout(to.layout)
            .image(self.raw)
            .subresource_range(self.whole())];
        let flags = vk::DependencyFlags::empty();
        // SAFETY: the caller's promise; the stages make these accesses.
        unsafe {
            let device = &self.gpu.device;
            device.cmd_pipeline_barrier(commands, from.stage, to.stage, flags, &[], &[], &barrier);
        }
    }

    /// All of it.
    pub fn whole(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange {
            aspect_mask: self.aspect,
            level_count: 1,
            layer_count: 1,
            ..Default::default()
        }
    }
}

impl Drop for Image<'_> {
    fn drop(&mut self) {
        let device = &self.gpu.device;
        // SAFETY: the frames that used it are done: their owner waits for them, and goes first. Null is no harm.
        unsafe {
            device.destroy_image_view(self.view, None);
            device.destroy_image(self.raw, None);
            device.free_memory(self.memory, None);
        }
    }
}

/// A buffer that the processor sees, too.
pub struct Buffer<'a> {
    pub raw: vk::Buffer,
    bytes: usize,
    at: *mut u8,
    memory: vk::DeviceMemory,
    gpu: &'a Gpu,
}

impl<'a> Buffer<'a> {
    /// # Errors
    /// What the driver says.
    pub fn new(
        gpu: &'a Gpu,
        usage: vk::BufferUsageFlags,
        bytes: usize,
    ) -> Result<Self, Box<dyn Error>> {
        let info = vk::BufferCreateInfo::default()
            .size(bytes as u64)
            .usage(usage);
        let seen = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let (device, flags) = (&gpu.device, vk::MemoryMapFlags::empty());
        // SAFETY: the device is alive, and the buffer gets memory of its own that can be mapped.
        unsafe {
            let mut made = Self {
                raw: device.create_buffer(&info, None)?,
                bytes,
                at: std::ptr::null_mut(),
                memory: vk::DeviceMemory::null(),
                gpu,
            };
            let needs = device.get_buffer_memory_requirements(made.raw);
            made.memory = allocate(gpu, needs, seen)?;
            device.bind_buffer_memory(made.raw, made.memory, 0)?;
            let at = device.map_memory(made.memory, 0, vk::WHOLE_SIZE, flags)?;
            made.at = at.cast();
            Ok(made)
        }
    }

    /// One that holds `content`.
    ///
    /// # Errors
    /// What the driver says.
    pub fn holding(
        gpu: &'a Gpu,
        usage: vk::BufferUsageFlags,
        content: &[u8],
    ) -> Result<Self, Box<dyn Error>> {
        let made = Self::new(gpu, usage, content.len())?;
        // SAFETY: the memory is mapped, has this many bytes, and nothing uses it yet.
        unsafe { made.at.copy_from(content.as_ptr(), content.len()) };
        Ok(made)
    }

    /// What it holds.
    ///
    /// # Safety
    /// Someone has written all of it, and the device is done with that.
    pub unsafe fn read(&self) -> Vec<u8> {
        // SAFETY: the memory is mapped and has this many bytes, which nobody writes, by the caller's promise.
        unsafe { std::slice::from_raw_parts(self.at, self.bytes).to_vec() }
    }
}

impl Drop for Buffer<'_> {
    fn drop(&mut self) {
        let device = &self.gpu.device;
        // SAFETY: as for images; freeing memory also unmaps it.
        unsafe {
            device.destroy_buffer(self.raw, None);
            device.free_memory(self.memory, None);
        }
    }
}
