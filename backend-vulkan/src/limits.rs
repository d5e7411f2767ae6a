//! What a Vulkan device allows.
use ash::vk;
use gibs_graph::{Capabilities, ImageFormat};

/// The limits of a device as capabilities; `buffer` bounds one allocation, `heap` all of them.
pub(crate) fn capabilities(
    limits: &vk::PhysicalDeviceLimits,
    formats: Vec<ImageFormat>,
    buffer: u64,
    heap: u64,
) -> Capabilities {
    let per_stage = |stage: u32, set: u32| stage.min(set).min(limits.max_per_stage_resources);
    let mut allowed = Capabilities::unlimited();
    allowed.buffer = buffer;
    allowed.storage_binding = limits.max_storage_buffer_range.into();
    allowed.uniform_binding = limits.max_uniform_buffer_range.into();
    allowed.memory = heap;
    allowed.storage_buffers = per_stage(
        limits.max_per_stage_descriptor_storage_buffers,
        limits.max_descriptor_set_storage_buffers,
    );
    allowed.uniform_buffers = per_stage(
        limits.max_per_stage_descriptor_uniform_buffers,
        limits.max_descriptor_set_uniform_buffers,
    );
    allowed.sampled_images = per_stage(
        limits.max_per_stage_descriptor_sampled_images,
        limits.max_descriptor_set_sampled_images,
    );
    allowed.stored_images = per_stage(
        limits.max_per_stage_descriptor_storage_images,
        limits.max_descriptor_set_storage_images,
    );
    allowed.image_side = limits.max_image_dimension2_d;
    allowed.formats = formats;
    allowed.workgroup_size = limits.max_compute_work_group_size;
    allowed.workgroup_invocations = limits.max_compute_work_group_invocations;
    allowed.workgroups = limits.max_compute_work_group_count;
    allowed
}
