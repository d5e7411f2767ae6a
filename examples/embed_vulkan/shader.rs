//! The engine's shaders: WGSL, as SPIR-V.
use super::gpu::Gpu;
use gibs_backend_vulkan::ash::vk;
use naga::back::spv;
use naga::valid::{ValidationFlags, Validator};
use std::error::Error;

/// Vertex and fragment shader of the G-buffer.
pub const GBUFFER: &str = "
    var<immediate> to_clip: mat4x4<f32>;
    struct Surface {
        @builtin(position) clip: vec4<f32>,
        @location(0) normal: vec3<f32>,
        @location(1) albedo: vec3<f32>,
        @location(2) @interpolate(flat) object: u32,
    }
    @vertex fn vertex(@location(0) position: vec3<f32>, @location(1) normal: vec3<f32>,
                      @location(2) albedo: vec3<f32>, @location(3) object: u32) -> Surface {
        return Surface(to_clip * vec4(position, 1.0), normal, albedo, object);
    }
    struct Texels {
        @location(0) normal: vec2<f32>,
        @location(1) albedo: vec4<f32>,
        @location(2) object: u32,
    }
    fn octahedral(n: vec3<f32>) -> vec2<f32> {
        let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
        let folded = (1.0 - abs(p.yx)) * select(vec2(-1.0), vec2(1.0), p >= vec2(0.0));
        return select(folded, p, n.z >= 0.0);
    }
    @fragment fn fragment(s: Surface) -> Texels {
        return Texels(octahedral(s.normal), vec4(s.albedo, 1.0), s.object);
    }";

/// A module with every entry point of `wgsl`. Whoever calls destroys it.
///
/// # Errors
/// What is wrong with the source, or what the driver says.
pub fn module(gpu: &Gpu, wgsl: &str) -> Result<vk::ShaderModule, Box<dyn Error>> {
    let module = naga::front::wgsl::parse_str(wgsl)?;
    let info = Validator::new(ValidationFlags::all(), spv::supported_capabilities())
        .validate(&module)
        .map_err(|e| e.emit_to_string(wgsl))?;
    let options = spv::Options {
        lang_version: (1, 3),
        // Projections are those of Vulkan: y points down already.
        flags: spv::WriterFlags::LABEL_VARYINGS,
        ..Default::default()
    };
    let words = spv::write_vec(&module, &info, &options, None)?;
    let info = vk::ShaderModuleCreateInfo::default().code(&words);
    // SAFETY: the device is alive, and naga writes SPIR-V that is valid.
    Ok(unsafe { gpu.device.create_shader_module(&info, None) }?)
}
