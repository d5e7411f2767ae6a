//! Images that the backend makes itself, where no host gives one.
use crate::buffers::{create_readback, map};
use crate::context::{Context, said};
use gibs_graph::{BackendError, ImageFormat, ImageShape, Resource};
use wgpu::{TextureFormat, TextureUsages};

/// An image with its view.
#[derive(Clone)]
pub(crate) struct Image {
    texture: wgpu::Texture,
    pub view: wgpu::TextureView,
    shape: ImageShape,
}

/// How a stage binds an image.
pub(crate) fn binding_type(format: ImageFormat) -> wgpu::BindingType {
    if format.is_stored() {
        return wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format: texture_format(format),
            view_dimension: wgpu::TextureViewDimension::D2,
        };
    }
    let sample_type = match format {
        ImageFormat::Uint => wgpu::TextureSampleType::Uint,
        // Of all floats the least is asked for, which depths and 32-bit floats can give, too.
        _ => wgpu::TextureSampleType::Float { filterable: false },
    };
    wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    }
}

fn texture_format(format: ImageFormat) -> TextureFormat {
    match format {
        ImageFormat::Uint => TextureFormat::Rgba32Uint,
        ImageFormat::Rgba16Float => TextureFormat::Rgba16Float,
        ImageFormat::Rgba8Unorm => TextureFormat::Rgba8Unorm,
        _ => TextureFormat::Rgba32Float,
    }
}

impl Image {
    /// A zero image for a resource.
    pub fn new(
        context: &Context,
        resource: &Resource,
        shape: ImageShape,
    ) -> Result<Self, BackendError> {
        let used = if shape.format.is_stored() {
            TextureUsages::STORAGE_BINDING
        } else {
            TextureUsages::TEXTURE_BINDING
        };
        let descriptor = wgpu::TextureDescriptor {
            label: Some(&resource.key),
            size: extent(shape),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: texture_format(shape.format),
            usage: used | TextureUsages::COPY_SRC | TextureUsages::COPY_DST,
            view_formats: &[],
        };
        let texture = context.guard_as(
            || context.device.create_texture(&descriptor),
            |error| match error {
                wgpu::Error::OutOfMemory { .. } => BackendError::OutOfMemory {
                    device: context.info.name.clone(),
                    resource: resource.key.clone(),
                    bytes: resource.len * u64::from(shape.format.texel_bytes()),
                },
                other => context.failed(&said(&other)),
            },
        )?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Self {
            texture,
            view,
            shape,
        })
    }

    /// Replaces all texels by values, before whatever is submitted next.
    pub fn write(&self, context: &Context, values: &[u8]) -> Result<(), BackendError> {
        let texels = self.shape.format.encode(values);
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(self.row_bytes()),
            rows_per_image: None,
        };
        context.guard(|| {
            context.queue.write_texture(
                self.texture.as_image_copy(),
                &texels,
                layout,
                extent(self.shape),
            );
        })
    }

    /// Waits for everything submitted so far and returns the values of all texels.
    pub fn read(&self, context: &Context) -> Result<Vec<u8>, BackendError> {
        let row = self.row_bytes();
        let stride = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let rows = self.shape.size[1];
        let size = u64::from(stride) * u64::from(rows);
        let staging = context.guard(|| create_readback(&context.device, size))?;
        let submission = context.guard(|| {
            let mut encoder = context
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(stride),
                rows_per_image: None,
            };
            let target = wgpu::TexelCopyBufferInfo {
                buffer: &staging,
                layout,
            };
            encoder.copy_texture_to_buffer(
                self.texture.as_image_copy(),
                target,
                extent(self.shape),
            );
            context.queue.submit([encoder.finish()])
        })?;
        let padded = map(context, &staging, size, Some(submission))?;
        let texels: Vec<u8> = padded
            .chunks_exact(stride as usize)
            .flat_map(|padded| &padded[..row as usize])
            .copied()
            .collect();
        Ok(self.shape.format.decode(&texels))
    }

    fn row_bytes(&self) -> u32 {
        self.shape.size[0] * self.shape.format.texel_bytes()
    }
}

fn extent(shape: ImageShape) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width: shape.size[0],
        height: shape.size[1],
        depth_or_array_layers: 1,
    }
}
