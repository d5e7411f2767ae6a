//! Kernels as SPIR-V words. Beside the leave to use ray queries (`device`), the one unsafe part of this crate.
#![allow(unsafe_code)]
use crate::context::Context;
use gibs_shaders::{CompiledKernel, SPIRV};
use std::borrow::Cow;

/// Whether the device takes the words as they are: Vulkan 1.3 has SPIR-V up to 1.6, and every device of it zeros workgroup
/// memory where a module asks for that, which wgpu then enables.
pub(crate) fn takes_words(adapter: &wgpu::Adapter) -> bool {
    const VULKAN_1_3: u32 = 1 << 22 | 3 << 12;
    // SAFETY: the adapter is only looked at, and lives as long.
    let found = unsafe { adapter.as_hal::<wgpu::hal::api::Vulkan>() };
    found.is_some_and(|adapter| {
        let properties = adapter.physical_device_capabilities().properties();
        properties.api_version >= VULKAN_1_3
    })
}

/// A module of the kernel's SPIR-V, which wgpu hands on as it is.
///
/// # Errors
/// What naga's writer says.
pub(crate) fn module(
    context: &Context,
    label: &str,
    compiled: &CompiledKernel,
) -> Result<wgpu::ShaderModule, String> {
    let words = compiled.spirv(SPIRV).map_err(|error| error.to_string())?;
    let [x, y, z] = compiled.workgroup_size();
    let entry = wgpu::PassthroughShaderEntryPoint {
        name: Cow::Borrowed("main"),
        workgroup_size: (x, y, z),
    };
    let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
        label: Some(label),
        entry_points: Cow::Borrowed(std::slice::from_ref(&entry)),
        spirv: Some(Cow::Owned(words)),
        ..Default::default()
    };
    // SAFETY: the device takes SPIR-V of this version and zeros workgroup memory itself (`takes_words`). The words were made by naga from a module that naga validated, with bounds checks; its entry point is
    // `main`; and its bindings are numbered as wgpu numbers those of the layout, which is made from the same kernel: from 0 without
    // gaps (wgpu-hal, `create_bind_group_layout` on Vulkan).
    Ok(unsafe { context.device.create_shader_module_passthrough(descriptor) })
}
