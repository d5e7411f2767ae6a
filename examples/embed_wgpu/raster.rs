//! The engine's renderer: a G-buffer by rasterization, with reversed depth and no far plane.
use super::engine::{Vertex, World, look};
use super::verdict::Surfaces;
use gibs::passes::scene::Camera;
use gibs_backend_wgpu::wgpu;
use glam::camera::rh::proj::directx::perspective_infinite_reverse;
use wgpu::util::DeviceExt;

/// Distance of the near plane, metres.
pub const NEAR: f32 = 0.1;

const SHADER: &str = "
    @group(0) @binding(0) var<uniform> to_clip: mat4x4<f32>;
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
        @location(0) normal: vec4<f32>,
        @location(1) albedo: vec4<f32>,
        @location(2) object: u32,
    }
    @fragment fn fragment(s: Surface) -> Texels {
        return Texels(vec4(normalize(s.normal), 0.0), vec4(s.albedo, 1.0), s.object);
    }";

/// Draws the world into a G-buffer.
pub struct Raster {
    pipeline: wgpu::RenderPipeline,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
}

/// The G-buffer of one view.
pub struct Gbuffer {
    pub depth: wgpu::TextureView,
    pub normal: wgpu::TextureView,
    pub albedo: wgpu::TextureView,
    pub objects: wgpu::TextureView,
    to_clip: wgpu::Buffer,
    group: wgpu::BindGroup,
}

const COLORS: [wgpu::TextureFormat; 3] = [
    wgpu::TextureFormat::Rgba16Float,
    wgpu::TextureFormat::Rgba8Unorm,
    wgpu::TextureFormat::R32Uint,
];

impl Raster {
    pub fn new(device: &wgpu::Device, world: &World) -> Self {
        let buffer = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: None,
                contents,
                usage,
            })
        };
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("gbuffer"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let targets = COLORS.map(|format| Some(format.into()));
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("gbuffer"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: size_of::<Vertex>() as u64,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Uint32],
                })],
            },
            primitive: wgpu::PrimitiveState {
                cull_mode: Some(wgpu::Face::Back),
                ..Default::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: wgpu::TextureFormat::Depth32Float,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        });
        Self {
            pipeline,
            vertices: buffer(
                bytemuck::cast_slice(&world.vertices),
                wgpu::BufferUsages::VERTEX,
            ),
            indices: buffer(
                bytemuck::cast_slice(&world.indices),
                wgpu::BufferUsages::INDEX,
            ),
            count: world.indices.len() as u32,
        }
    }

    pub fn gbuffer(&self, device: &wgpu::Device, [width, height]: [u32; 2]) -> Gbuffer {
        let view = |format| {
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC;
            texture(device, [width, height], format, usage).create_view(&Default::default())
        };
        let to_clip = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("to clip space"),
            size: 64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: to_clip.as_entire_binding(),
            }],
        });
        Gbuffer {
            depth: view(wgpu::TextureFormat::Depth32Float),
            normal: view(COLORS[0]),
            albedo: view(COLORS[1]),
            objects: view(COLORS[2]),
            to_clip,
            group,
        }
    }

    pub fn draw(
        &self,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        target: &Gbuffer,
        camera: &Camera,
        aspect: f32,
    ) {
        let projection = perspective_infinite_reverse(camera.vfov as f32, aspect, NEAR);
        let to_clip = projection * look(camera);
        queue.write_buffer(&target.to_clip, 0, bytemuck::bytes_of(&to_clip));
        let clear = |view, color| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(color),
                    store: wgpu::StoreOp::Store,
                },
            })
        };
        let black = wgpu::Color::TRANSPARENT;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("gbuffer"),
            color_attachments: &[
                clear(&target.normal, black),
                clear(&target.albedo, black),
                clear(&target.objects, black),
            ],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &target.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &target.group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.count, 0, 0..1);
    }
}

/// A plain texture.
pub fn texture(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// Waits and returns the bytes of every texel, row by row.
pub fn read(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let texel = texture.format().block_copy_size(None);
    let row = texture.width() * texel.ok_or("the texture has several planes")?;
    let stride = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(stride * texture.height()),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(stride),
        rows_per_image: None,
    };
    let target = wgpu::TexelCopyBufferInfo {
        buffer: &buffer,
        layout,
    };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), target, texture.size());
    queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |mapped| {
        if let Err(error) = mapped {
            eprintln!("the picture cannot be read: {error}");
        }
    });
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let bytes = buffer.get_mapped_range(..)?;
    let rows = bytes.chunks_exact(stride as usize);
    Ok(rows
        .flat_map(|bytes| &bytes[..row as usize])
        .copied()
        .collect())
}

/// As [`read`], of texels of four half floats.
pub fn read_halves(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<glam::Vec4>, Box<dyn std::error::Error>> {
    let format = gibs::graph::ImageFormat::Rgba16Float;
    let bytes = read(device, queue, texture)?;
    Ok(bytemuck::pod_collect_to_vec(&format.decode(&bytes)))
}

impl Gbuffer {
    /// What was drawn last.
    pub fn read(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<Surfaces, Box<dyn std::error::Error>> {
        let bytes = |view: &wgpu::TextureView| read(device, queue, view.texture());
        Ok(Surfaces::new(
            &bytes(&self.depth)?,
            read_halves(device, queue, self.normal.texture())?,
            &bytes(&self.albedo)?,
            &bytes(&self.objects)?,
        ))
    }
}
