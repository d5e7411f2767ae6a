//! The pipeline that rasterizes the G-buffer.
use super::engine::Vertex;
use super::gpu::Gpu;
use super::shader;
use gibs_backend_vulkan::ash::vk;
use std::error::Error;
use std::mem::offset_of;

/// Formats of the colours: octahedral normal, albedo, object.
pub const COLORS: [vk::Format; 3] = [
    vk::Format::R16G16_SFLOAT,
    vk::Format::R8G8B8A8_UNORM,
    vk::Format::R32_UINT,
];
pub const DEPTH: vk::Format = vk::Format::D32_SFLOAT;

/// A pipeline with its layout.
pub struct Pipeline<'a> {
    pub raw: vk::Pipeline,
    pub layout: vk::PipelineLayout,
    gpu: &'a Gpu,
}

impl<'a> Pipeline<'a> {
    /// # Errors
    /// What the driver says.
    pub fn new(gpu: &'a Gpu) -> Result<Self, Box<dyn Error>> {
        let matrix = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::VERTEX)
            .size(64)];
        let info = vk::PipelineLayoutCreateInfo::default().push_constant_ranges(&matrix);
        let mut made = Self {
            raw: vk::Pipeline::null(),
            // SAFETY: the device is alive, and has 128 bytes of push constants at least.
            layout: unsafe { gpu.device.create_pipeline_layout(&info, None) }?,
            gpu,
        };
        let module = shader::module(gpu, shader::GBUFFER)?;
        // SAFETY: the module has both entry points, which use what the layout has; pipelines do not need it any more.
        unsafe {
            let raw = build(gpu, module, made.layout);
            gpu.device.destroy_shader_module(module, None);
            made.raw = raw?;
        }
        Ok(made)
    }
}

/// # Safety
/// The module has the entry points `vertex` and `fragment`, which fit the layout and what is drawn.
unsafe fn build(
    gpu: &Gpu,
    module: vk::ShaderModule,
    layout: vk::PipelineLayout,
) -> Result<vk::Pipeline, vk::Result> {
    let stage = |stage, name| {
        vk::PipelineShaderStageCreateInfo::default()
            .stage(stage)
            .module(module)
            .name(name)
    };
    let stages = [
        stage(vk::ShaderStageFlags::VERTEX, c"vertex"),
        stage(vk::ShaderStageFlags::FRAGMENT, c"fragment"),
    ];
    let bindings =
        [vk::VertexInputBindingDescription::default().stride(size_of::<Vertex>() as u32)];
    let attribute = |location, format, offset: usize| {
        vk::VertexInputAttributeDescription::default()
            .location(location)
            .format(format)
            .offset(offset as u32)
    };
    let three = vk::Format::R32G32B32_SFLOAT;
    let attributes = [
        attribute(0, three, offset_of!(Vertex, position)),
        attribute(1, three, offset_of!(Vertex, normal)),
        attribute(2, three, offset_of!(Vertex, albedo)),
        attribute(3, vk::Format::R32_UINT, offset_of!(Vertex, object)),
    ];
    let vertices = vk::PipelineVertexInputStateCreateInfo::default()
        .vertex_binding_descriptions(&bindings)
        .vertex_attribute_descriptions(&attributes);
    let triangles = vk::PipelineInputAssemblyStateCreateInfo::default()
        .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let viewport = vk::PipelineViewportStateCreateInfo::default()
        .viewport_count(1)
        .scissor_count(1);
    let faces = vk::PipelineRasterizationStateCreateInfo::default()
        .cull_mode(vk::CullModeFlags::BACK)
        .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
        .line_width(1.0);
    let samples = vk::PipelineMultisampleStateCreateInfo::default()
        .rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let depth = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(true)
        .depth_write_enable(true)
        .depth_compare_op(vk::CompareOp::LESS);
    let replaced = [vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::RGBA); COLORS.len()];
    let colors = vk::PipelineColorBlendStateCreateInfo::default().attachments(&replaced);
    let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
    let mut targets = vk::PipelineRenderingCreateInfo::default()
        .color_attachment_formats(&COLORS)
        .depth_attachment_format(DEPTH);
    let info = [vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&vertices)
        .input_assembly_state(&triangles)
        .viewport_state(&viewport)
        .rasterization_state(&faces)
        .multisample_state(&samples)
        .depth_stencil_state(&depth)
        .color_blend_state(&colors)
        .dynamic_state(&dynamic)
        .layout(layout)
        .push_next(&mut targets)];
    let cache = vk::PipelineCache::null();
    // SAFETY: the caller's promise; pointers in `info` are to locals.
    let made = unsafe { gpu.device.create_graphics_pipelines(cache, &info, None) };
    // One was asked for: with an error comes none.
    made.map(|made| made[0]).map_err(|(_, error)| error)
}

impl Drop for Pipeline<'_> {
    fn drop(&mut self) {
        // SAFETY: the frames that used them are done: their owner waits for them, and goes first. Null is no harm.
        unsafe {
            self.gpu.device.destroy_pipeline(self.raw, None);
            self.gpu.device.destroy_pipeline_layout(self.layout, None);
        }
    }
}
