//! The engine's renderer: a G-buffer by rasterization, with a far plane at depth 1.
use super::engine::{World, look};
use super::gpu::Gpu;
use super::memory::{Buffer, Image};
use super::pipeline::{COLORS, DEPTH, Pipeline};
use gibs::passes::scene::Camera;
use gibs_backend_vulkan::ash::vk;
use glam::camera::rh::proj::vulkan::perspective;
use std::error::Error;

/// Distance of the near plane, metres.
pub const NEAR: f32 = 0.1;
/// Distance of the far plane, metres.
pub const FAR: f32 = 100.0;

/// In which layout, and by what, the colours of a G-buffer are written.
pub const COLOR_LAYOUT: vk::ImageLayout = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
pub const COLOR_STAGE: vk::PipelineStageFlags = vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT;
pub const COLOR_ACCESS: vk::AccessFlags = vk::AccessFlags::COLOR_ATTACHMENT_WRITE;
/// The same for depths.
pub const DEPTH_LAYOUT: vk::ImageLayout = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
pub const DEPTH_STAGE: vk::PipelineStageFlags = vk::PipelineStageFlags::from_raw(
    vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS.as_raw()
        | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS.as_raw(),
);
pub const DEPTH_ACCESS: vk::AccessFlags = vk::AccessFlags::from_raw(
    vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_READ.as_raw()
        | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw(),
);

/// Draws the world into a G-buffer.
pub struct Raster<'a> {
    gpu: &'a Gpu,
    pipeline: Pipeline<'a>,
    vertices: Buffer<'a>,
    indices: Buffer<'a>,
    count: u32,
}

/// The G-buffer of one view.
pub struct Gbuffer<'a> {
    pub depth: Image<'a>,
    pub normal: Image<'a>,
    pub albedo: Image<'a>,
    pub objects: Image<'a>,
    size: [u32; 2],
}

impl<'a> Raster<'a> {
    /// # Errors
    /// What the driver says.
    pub fn new(gpu: &'a Gpu, world: &World) -> Result<Self, Box<dyn Error>> {
        let (vertices, indices) = (
            bytemuck::cast_slice(&world.vertices),
            bytemuck::cast_slice(&world.indices),
        );
        Ok(Self {
            gpu,
            pipeline: Pipeline::new(gpu)?,
            vertices: Buffer::holding(gpu, vk::BufferUsageFlags::VERTEX_BUFFER, vertices)?,
            indices: Buffer::holding(gpu, vk::BufferUsageFlags::INDEX_BUFFER, indices)?,
            count: world.indices.len() as u32,
        })
    }

    /// # Errors
    /// What the driver says.
    pub fn gbuffer(&self, size: [u32; 2]) -> Result<Gbuffer<'a>, Box<dyn Error>> {
        let image = |format, drawn| {
            let usage = drawn | vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_SRC;
            Image::new(self.gpu, size, format, usage)
        };
        let color = |i: usize| image(COLORS[i], vk::ImageUsageFlags::COLOR_ATTACHMENT);
        Ok(Gbuffer {
            depth: image(DEPTH, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT)?,
            normal: color(0)?,
            albedo: color(1)?,
            objects: color(2)?,
            size,
        })
    }

    /// Brings a new G-buffer to the layouts in which it is drawn.
    ///
    /// # Safety
    /// The commands are being recorded, and the G-buffer outlives them.
    pub unsafe fn introduce(&self, commands: vk::CommandBuffer, target: &Gbuffer<'_>) {
        let barrier = |image: &Image<'_>, layout, access| {
            vk::ImageMemoryBarrier::default()
                .dst_access_mask(access)
                .new_layout(layout)
                .image(image.raw)
                .subresource_range(image.whole())
        };
        let color = |image| barrier(image, COLOR_LAYOUT, COLOR_ACCESS);
        let barriers = [
            barrier(&target.depth, DEPTH_LAYOUT, DEPTH_ACCESS),
            color(&target.normal),
            color(&target.albedo),
            color(&target.objects),
        ];
        let (from, to) = (
            vk::PipelineStageFlags::TOP_OF_PIPE,
            COLOR_STAGE | DEPTH_STAGE,
        );
        let flags = vk::DependencyFlags::empty();
        // SAFETY: the caller's promise; these stages make these accesses.
        unsafe {
            let device = &self.gpu.device;
            device.cmd_pipeline_barrier(commands, from, to, flags, &[], &[], &barriers);
        }
    }

    /// Draws what the camera sees.
    ///
    /// # Safety
    /// The commands are being recorded, the G-buffer is in the layouts for this, and everything outlives them.
    pub unsafe fn draw(&self, commands: vk::CommandBuffer, target: &Gbuffer<'_>, camera: &Camera) {
        let [width, height] = target.size;
        let projection = perspective(camera.vfov as f32, width as f32 / height as f32, NEAR, FAR);
        let to_clip = projection * look(camera);
        let cleared = |image: &Image<'_>, layout, clear| {
            vk::RenderingAttachmentInfo::default()
                .image_view(image.view)
                .image_layout(layout)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(vk::AttachmentStoreOp::STORE)
                .clear_value(clear)
        };
        let far = vk::ClearDepthStencilValue {
            depth: 1.0,
            stencil: 0,
        };
        let far = vk::ClearValue { depth_stencil: far };
        let depth = cleared(&target.depth, DEPTH_LAYOUT, far);
        let colors = [&target.normal, &target.albedo, &target.objects]
            .map(|image| cleared(image, COLOR_LAYOUT, vk::ClearValue::default()));
        let area = vk::Rect2D::default().extent(vk::Extent2D { width, height });
        let viewport = vk::Viewport::default()
            .width(width as f32)
            .height(height as f32)
            .max_depth(1.0);
        let info = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&colors)
            .depth_attachment(&depth);
        let (device, pipeline) = (&self.gpu.device, &self.pipeline);
        let (point, stage) = (
            vk::PipelineBindPoint::GRAPHICS,
            vk::ShaderStageFlags::VERTEX,
        );
        let matrix = bytemuck::bytes_of(&to_clip);
        // SAFETY: the caller's promise; the indices are those of vertices, and the pipeline was made for all of this.
        unsafe {
            device.cmd_begin_rendering(commands, &info);
            device.cmd_bind_pipeline(commands, point, pipeline.raw);
            device.cmd_set_viewport(commands, 0, &[viewport]);
            device.cmd_set_scissor(commands, 0, &[area]);
            device.cmd_push_constants(commands, pipeline.layout, stage, 0, matrix);
            device.cmd_bind_vertex_buffers(commands, 0, &[self.vertices.raw], &[0]);
            device.cmd_bind_index_buffer(commands, self.indices.raw, 0, vk::IndexType::UINT32);
            device.cmd_draw_indexed(commands, self.count, 1, 0, 0, 0);
            device.cmd_end_rendering(commands);
        }
    }
}
