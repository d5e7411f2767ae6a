//! What a wgpu device allows.
use gibs_graph::Capabilities;

/// The limits of a device as capabilities. WebGPU guarantees every format of images; nobody says how much memory there is.
pub(crate) fn capabilities(limits: &wgpu::Limits, features: wgpu::Features) -> Capabilities {
    let mut allowed = Capabilities::webgpu();
    allowed.buffer = limits.max_buffer_size;
    allowed.storage_binding = limits.max_storage_buffer_binding_size;
    allowed.uniform_binding = limits.max_uniform_buffer_binding_size;
    // A device may have the feature with limits that allow none.
    allowed.ray_query = features.contains(wgpu::Features::EXPERIMENTAL_RAY_QUERY)
        && limits.max_acceleration_structures_per_shader_stage > 0;
    allowed.structure_triangles = limits.max_blas_primitive_count.into();
    allowed.structure_instances = limits.max_tlas_instance_count.into();
    allowed.storage_buffers = limits.max_storage_buffers_per_shader_stage;
    allowed.uniform_buffers = limits.max_uniform_buffers_per_shader_stage;
    allowed.sampled_images = limits.max_sampled_textures_per_shader_stage;
    allowed.stored_images = limits.max_storage_textures_per_shader_stage;
    allowed.image_side = limits.max_texture_dimension_2d;
    allowed.workgroup_size = [
        limits.max_compute_workgroup_size_x,
        limits.max_compute_workgroup_size_y,
        limits.max_compute_workgroup_size_z,
    ];
    allowed.workgroup_invocations = limits.max_compute_invocations_per_workgroup;
    allowed.workgroups = [limits.max_compute_workgroups_per_dimension; 3];
    allowed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// wgpu's defaults are those of the standard.
    #[test]
    fn the_defaults_are_webgpus() {
        assert_eq!(
            capabilities(&wgpu::Limits::default(), wgpu::Features::empty()),
            Capabilities::webgpu()
        );
    }
}
