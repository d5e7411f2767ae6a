//! Images that the backend makes itself.
use crate::device::Device;
use crate::instance::Instance;
use crate::memory::{allocate, free, not_made};
use ash::vk;
use gibs_graph::{BackendError, ImageFormat, ImageShape};
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;
use std::sync::Arc;

/// All that a barrier, a clear or a view covers: images have one level and one layer.
pub(crate) const COLOR: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// An image with memory of its own. From its first use on it is in the layout `GENERAL`, but for the time of a copy: no
/// barrier of a frame has to know what came last.
pub(crate) struct Image {
    pub raw: vk::Image,
    pub view: vk::ImageView,
    pub shape: ImageShape,
    /// `None` only before it is allocated and while the image is dropped.
    memory: Option<Allocation>,
    device: Arc<Device>,
}

/// How an image of this format is made, and what kernels do to it; `None` for a format that is newer than the backend.
pub(crate) fn native(format: ImageFormat) -> Option<(vk::Format, vk::ImageUsageFlags)> {
    let sampled = vk::ImageUsageFlags::SAMPLED;
    let stored = vk::ImageUsageFlags::STORAGE;
    match format {
        ImageFormat::Float => Some((vk::Format::R32G32B32A32_SFLOAT, sampled)),
        ImageFormat::Uint => Some((vk::Format::R32G32B32A32_UINT, sampled)),
        ImageFormat::Rgba16Float => Some((vk::Format::R16G16B16A16_SFLOAT, stored)),
        ImageFormat::Rgba32Float => Some((vk::Format::R32G32B32A32_SFLOAT, stored)),
        ImageFormat::Rgba8Unorm => Some((vk::Format::R8G8B8A8_UNORM, stored)),
        _ => None,
    }
}

/// Every format that [`native`] knows.
pub(crate) const FORMATS: [ImageFormat; 5] = [
    ImageFormat::Float,
    ImageFormat::Uint,
    ImageFormat::Rgba16Float,
    ImageFormat::Rgba32Float,
    ImageFormat::Rgba8Unorm,
];

/// A device can make images of this format, use them in kernels, and copy them.
pub(crate) fn is_supported(
    instance: &Instance,
    physical: vk::PhysicalDevice,
    format: ImageFormat,
) -> bool {
    use vk::FormatFeatureFlags as Features;
    let Some((native, _)) = native(format) else {
        return false;
    };
    let used = match format.is_stored() {
        true => Features::STORAGE_IMAGE,
        false => Features::SAMPLED_IMAGE,
    };
    // SAFETY: the physical device belongs to the instance, which is alive.
    let properties = unsafe {
        instance
            .raw
            .get_physical_device_format_properties(physical, native)
    };
    properties
        .optimal_tiling_features
        .contains(used | Features::TRANSFER_SRC | Features::TRANSFER_DST)
}

impl Image {
    /// An image whose content and layout are undefined.
    pub fn new(device: &Arc<Device>, name: &str, shape: ImageShape) -> Result<Self, BackendError> {
        // The limits were checked before, so the format is one of those below.
        let (format, used) = native(shape.format).unwrap_or_default();
        let [width, height] = shape.size;
        let bytes = u64::from(width) * u64::from(height) * u64::from(shape.format.texel_bytes());
        let transfers = vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
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
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(used | transfers)
            .sharing_mode(vk::SharingMode::EXCLUSIVE)
            .initial_layout(vk::ImageLayout::UNDEFINED);
        // SAFETY: the device is alive; size, format and usage were checked against its limits.
        let raw = unsafe { device.raw.create_image(&info, None) }
            .map_err(|e| not_made(device, "vkCreateImage", name, bytes, e))?;
        // From here on dropping the value gives back what it has.
        let mut image = Self {
            raw,
            view: vk::ImageView::null(),
            shape,
            memory: None,
            device: Arc::clone(device),
        };
        device.name(raw, name);
        // SAFETY: the image was made by this device.
        let requirements = unsafe { device.raw.get_image_memory_requirements(raw) };
        let memory = allocate(device, name, requirements, MemoryLocation::GpuOnly, false)?;
        // SAFETY: the memory was allocated for the requirements of this image, which has no memory yet.
        let bound = unsafe {
            device
                .raw
                .bind_image_memory(raw, memory.memory(), memory.offset())
        };
        image.memory = Some(memory);
        bound.map_err(device.fail("vkBindImageMemory"))?;
        let info = vk::ImageViewCreateInfo::default()
            .image(raw)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(format)
            .subresource_range(COLOR);
        // SAFETY: the image has memory, and this format.
        image.view = unsafe { device.raw.create_image_view(&info, None) }
            .map_err(|e| not_made(device, "vkCreateImageView", name, bytes, e))?;
        Ok(image)
    }
}

/// Records that an image goes from one layout to another, between transfers.
///
/// # Safety
/// `commands` is a command buffer of `device` that is being recorded; the image lives until its work is done, and is in
/// the layout `from`.
pub(crate) unsafe fn turn(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    image: vk::Image,
    from: vk::ImageLayout,
    to: vk::ImageLayout,
) {
    let stage = vk::PipelineStageFlags::TRANSFER;
    let barrier = [vk::ImageMemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
        .dst_access_mask(vk::AccessFlags::TRANSFER_READ | vk::AccessFlags::TRANSFER_WRITE)
        .old_layout(from)
        .new_layout(to)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image)
        .subresource_range(COLOR)];
    let flags = vk::DependencyFlags::empty();
    // SAFETY: the caller's promise.
    unsafe { device.cmd_pipeline_barrier(commands, stage, stage, flags, &[], &[], &barrier) };
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: whoever holds an image waits for the work that uses it before dropping it; each handle is destroyed
        // once, and null handles are ignored.
        unsafe {
            self.device.raw.destroy_image_view(self.view, None);
            self.device.raw.destroy_image(self.raw, None);
        }
        free(&self.device, self.memory.take());
    }
}
