//! Frames under way: command buffers, and fences that say when they are done.
use super::gpu::Gpu;
use super::memory::{Buffer, Image};
use gibs_backend_vulkan::ImageUse;
use gibs_backend_vulkan::ash::vk;
use std::error::Error;

/// Frames that may be under way at a time.
const UNDER_WAY: usize = 2;

/// The engine's command buffers. Declared after what they refer to, so that it is dropped first, and waits.
pub struct Frames<'a> {
    gpu: &'a Gpu,
    pool: vk::CommandPool,
    commands: Vec<vk::CommandBuffer>,
    fences: Vec<vk::Fence>,
    current: usize,
}

impl<'a> Frames<'a> {
    /// # Errors
    /// What the driver says.
    pub fn new(gpu: &'a Gpu) -> Result<Self, Box<dyn Error>> {
        let pool = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(gpu.family);
        let fence = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
        // SAFETY: the device is alive, and its queue is of that family.
        unsafe {
            let mut made = Self {
                gpu,
                pool: gpu.device.create_command_pool(&pool, None)?,
                commands: Vec::new(),
                fences: Vec::new(),
                current: 0,
            };
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(made.pool)
                .command_buffer_count(UNDER_WAY as u32);
            made.commands = gpu.device.allocate_command_buffers(&info)?;
            for _ in 0..UNDER_WAY {
                made.fences.push(gpu.device.create_fence(&fence, None)?);
            }
            Ok(made)
        }
    }

    /// Waits until only the last frame is under way, and starts the commands of another.
    ///
    /// # Errors
    /// What the driver says.
    pub fn begin(&mut self) -> Result<vk::CommandBuffer, Box<dyn Error>> {
        self.current = (self.current + 1) % UNDER_WAY;
        let (device, commands) = (&self.gpu.device, self.commands[self.current]);
        let once = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer is not under way once its fence is signaled, and its pool can reset it.
        unsafe {
            device.wait_for_fences(&[self.fences[self.current]], true, u64::MAX)?;
            device.begin_command_buffer(commands, &once)?;
        }
        Ok(commands)
    }

    /// Submits the commands that [`Frames::begin`] started.
    ///
    /// # Errors
    /// What the driver says.
    ///
    /// # Safety
    /// They are valid, and what they refer to outlives this value.
    pub unsafe fn submit(&mut self) -> Result<(), Box<dyn Error>> {
        let (device, fence) = (&self.gpu.device, self.fences[self.current]);
        let commands = [self.commands[self.current]];
        let work = [vk::SubmitInfo::default().command_buffers(&commands)];
        // SAFETY: the commands are being recorded, and the fence is not in use since `begin` waited for it; the rest is
        // the caller's promise.
        unsafe {
            device.end_command_buffer(commands[0])?;
            device.reset_fences(&[fence])?;
            device.queue_submit(self.gpu.queue, &work, fence)?;
        }
        Ok(())
    }

    /// Waits for all frames.
    ///
    /// # Errors
    /// What the driver says.
    pub fn finish(&self) -> Result<(), Box<dyn Error>> {
        // SAFETY: the fences belong to the device; each is signaled or about to be.
        Ok(unsafe {
            self.gpu
                .device
                .wait_for_fences(&self.fences, true, u64::MAX)
        }?)
    }

    /// Waits and returns the bytes of every texel of an image that transfers can read, which has so many bytes to a texel.
    ///
    /// # Errors
    /// What the driver says.
    ///
    /// # Safety
    /// The image has such texels, this size, and was last used as `held` says.
    pub unsafe fn read(
        &mut self,
        image: &Image<'_>,
        [width, height]: [u32; 2],
        texel: usize,
        held: ImageUse,
    ) -> Result<Vec<u8>, Box<dyn Error>> {
        let bytes = texel * width as usize * height as usize;
        let buffer = Buffer::new(self.gpu, vk::BufferUsageFlags::TRANSFER_DST, bytes)?;
        let commands = self.begin()?;
        let all = [vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: image.aspect,
                layer_count: 1,
                ..Default::default()
            })
            .image_extent(vk::Extent3D {
                width,
                height,
                depth: 1,
            })];
        let copied = ImageUse {
            layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
            stage: vk::PipelineStageFlags::TRANSFER,
            access: vk::AccessFlags::TRANSFER_READ,
        };
        let written = [vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(vk::AccessFlags::HOST_READ)];
        let (from, to) = (copied.stage, vk::PipelineStageFlags::HOST);
        let flags = vk::DependencyFlags::empty();
        // SAFETY: the commands are being recorded, the buffer has room for every texel and is read, and goes, after the
        // device is done; the rest is the caller's promise.
        unsafe {
            let device = &self.gpu.device;
            image.pass(commands, held, copied);
            device.cmd_copy_image_to_buffer(commands, image.raw, copied.layout, buffer.raw, &all);
            image.pass(commands, copied, held);
            device.cmd_pipeline_barrier(commands, from, to, flags, &written, &[], &[]);
            self.submit()?;
            self.finish()?;
            Ok(buffer.read())
        }
    }
}

impl Drop for Frames<'_> {
    fn drop(&mut self) {
        let device = &self.gpu.device;
        // SAFETY: nothing is under way after the wait, or the device is lost; each is destroyed once.
        unsafe {
            let _ = device.device_wait_idle();
            for fence in &self.fences {
                device.destroy_fence(*fence, None);
            }
            device.destroy_command_pool(self.pool, None);
        }
    }
}
