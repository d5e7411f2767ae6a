//! What a schedule needs, against what the device allows; before anything is allocated or compiled.
use gibs_graph::{Access, BackendError, DispatchSize, DispatchStep, Resource, Schedule};

/// Checks every resource and stage.
///
/// # Errors
/// [`BackendError::Limit`] for the first that is too much.
pub(crate) fn check(
    schedule: &Schedule,
    limits: &wgpu::Limits,
    device: &str,
) -> Result<(), BackendError> {
    let allow = |need: u64, limit: u64, what: &dyn Fn() -> String, remedy: &str| {
        if need <= limit {
            return Ok(());
        }
        Err(BackendError::Limit {
            what: what(),
            need,
            limit,
            device: device.into(),
            remedy: remedy.into(),
        })
    };
    for resource in schedule.resources.iter().filter(|r| r.usage.on_device()) {
        check_resource(resource, limits, &allow)?;
    }
    for (_, step, dispatch) in schedule.dispatches() {
        check_stage(&step.label, dispatch, limits, &allow)?;
    }
    Ok(())
}

/// `(need, limit, what, remedy)`.
type Allow<'a> = dyn Fn(u64, u64, &dyn Fn() -> String, &str) -> Result<(), BackendError> + 'a;

fn check_resource(
    resource: &Resource,
    limits: &wgpu::Limits,
    allow: &Allow<'_>,
) -> Result<(), BackendError> {
    if let Some(image) = resource.image {
        let limit = limits.max_texture_dimension_2d.into();
        let what = || format!("the image `{}`, in texels along a side,", resource.key);
        let longest = image.size[0].max(image.size[1]);
        return allow(longest.into(), limit, &what, "use a smaller picture");
    }
    let smaller = "use fewer surfels or rays, a smaller picture or scene, or the cpu backend";
    let what = |unit: &str| format!("{unit} `{}`, in bytes,", resource.key);
    allow(
        resource.bytes,
        limits.max_buffer_size,
        &|| what("the buffer"),
        smaller,
    )?;
    if resource.usage.storage {
        let limit = limits.max_storage_buffer_binding_size;
        allow(
            resource.bytes,
            limit,
            &|| what("the storage binding of"),
            smaller,
        )?;
    }
    if resource.usage.uniform {
        let bytes = u64::from(resource.element.size());
        allow(
            bytes,
            limits.max_uniform_buffer_binding_size,
            &|| what("the uniform"),
            "use another device",
        )?;
    }
    Ok(())
}

fn check_stage(
    label: &str,
    dispatch: &DispatchStep,
    limits: &wgpu::Limits,
    allow: &Allow<'_>,
) -> Result<(), BackendError> {
    let count = |test: fn(Access) -> bool| {
        let bound = dispatch.bindings.iter().filter(|b| b.access.is_bound());
        bound.filter(|b| test(b.access)).count() as u64
    };
    let what = |thing: &str| format!("stage `{label}`, in {thing},");
    let another = "use another device";
    let storage = u64::from(limits.max_storage_buffers_per_shader_stage);
    let is_storage = |access: Access| access != Access::Uniform && !access.is_image();
    let buffers = count(is_storage);
    allow(buffers, storage, &|| what("storage buffers"), another)?;
    let uniform = u64::from(limits.max_uniform_buffers_per_shader_stage);
    let uniforms = count(|access| access == Access::Uniform);
    allow(uniforms, uniform, &|| what("uniform buffers"), another)?;
    let sampled = u64::from(limits.max_sampled_textures_per_shader_stage);
    let images = count(|access| access == Access::Sampled);
    allow(images, sampled, &|| what("sampled textures"), another)?;
    let stored = u64::from(limits.max_storage_textures_per_shader_stage);
    let images = count(|access| access == Access::Stored);
    allow(images, stored, &|| what("storage textures"), another)?;

    let size = dispatch.kernel.workgroup.map(u64::from);
    let invocations = u64::from(limits.max_compute_invocations_per_workgroup);
    allow(
        size.iter().product(),
        invocations,
        &|| what("invocations per workgroup"),
        another,
    )?;
    let sides = [
        limits.max_compute_workgroup_size_x,
        limits.max_compute_workgroup_size_y,
        limits.max_compute_workgroup_size_z,
    ];
    for (axis, (side, limit)) in ["x", "y", "z"].iter().zip(size.into_iter().zip(sides)) {
        allow(
            side,
            limit.into(),
            &|| what(&format!("workgroup size along {axis}")),
            another,
        )?;
    }
    if let DispatchSize::Groups(groups) = dispatch.size {
        let most = u64::from(limits.max_compute_workgroups_per_dimension);
        for n in groups {
            allow(
                n.into(),
                most,
                &|| what("workgroups along one axis"),
                "use a smaller size",
            )?;
        }
    }
    Ok(())
}
