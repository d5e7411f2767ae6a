//! What an engine has and does: images, buffers and commands.
use super::Engine;
use gibs_backend_vulkan::ImageUse;
use gibs_backend_vulkan::ash::vk;

/// An image of the engine.
#[derive(Clone, Copy)]
pub struct Lent {
    pub image: vk::Image,
    pub view: vk::ImageView,
    pub(super) memory: vk::DeviceMemory,
}

/// A buffer of the engine that it sees itself.
#[derive(Clone, Copy)]
pub struct Room {
    pub buffer: vk::Buffer,
    pub(super) memory: vk::DeviceMemory,
    bytes: u64,
    at: *mut u8,
}

impl Room {
    /// What it holds. Nothing on the device uses it.
    pub fn read(&self) -> Vec<u8> {
        // SAFETY: the memory is mapped and has this many bytes.
        unsafe { std::slice::from_raw_parts(self.at, self.bytes as usize).to_vec() }
    }

    /// Replaces the start. Nothing on the device uses it.
    pub fn write(&self, bytes: &[u8]) {
        assert!(bytes.len() as u64 <= self.bytes);
        // SAFETY: as above.
        unsafe { self.at.copy_from(bytes.as_ptr(), bytes.len()) };
    }
}

pub const TRANSFER_READ: ImageUse = ImageUse {
    layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
    stage: vk::PipelineStageFlags::TRANSFER,
    access: vk::AccessFlags::TRANSFER_READ,
};
pub const TRANSFER_WRITE: ImageUse = ImageUse {
    layout: vk::ImageLayout::TRANSFER_DST_OPTIMAL,
    stage: vk::PipelineStageFlags::TRANSFER,
    access: vk::AccessFlags::TRANSFER_WRITE,
};
/// Nothing that matters was there before.
pub const FRESH: ImageUse = ImageUse {
    layout: vk::ImageLayout::UNDEFINED,
    stage: vk::PipelineStageFlags::empty(),
    access: vk::AccessFlags::empty(),
};

/// All of an image with these aspects.
pub fn whole(aspect_mask: vk::ImageAspectFlags) -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange {
        aspect_mask,
        level_count: 1,
        layer_count: 1,
        ..Default::default()
    }
}

impl Engine {
    fn memory(
        &self,
        needs: vk::MemoryRequirements,
        wanted: vk::MemoryPropertyFlags,
    ) -> vk::DeviceMemory {
        // SAFETY: the device is alive; the type is one that the requirements allow.
        unsafe {
            let offered = self
                .instance
                .get_physical_device_memory_properties(self.physical);
            let kind = (0..offered.memory_type_count).find(|&i| {
                let flags = offered.memory_types[i as usize].property_flags;
                needs.memory_type_bits & 1 << i != 0 && flags.contains(wanted)
            });
            let info = vk::MemoryAllocateInfo::default()
                .allocation_size(needs.size)
                .memory_type_index(kind.unwrap());
            self.device.allocate_memory(&info, None).unwrap()
        }
    }

    /// An image, seen through one aspect.
    pub fn image(
        &self,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
        [width, height]: [u32; 2],
        seen: vk::ImageAspectFlags,
    ) -> Lent {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D {
                width,
                height,
                depth: 1,
            })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST);
        // SAFETY: the device is alive, and the image gets memory before its view.
        let lent = unsafe {
            let image = self.device.create_image(&info, None).unwrap();
            let needs = self.device.get_image_memory_requirements(image);
            let memory = self.memory(needs, vk::MemoryPropertyFlags::empty());
            self.device.bind_image_memory(image, memory, 0).unwrap();
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(whole(seen));
            Lent {
                image,
                view: self.device.create_image_view(&info, None).unwrap(),
                memory,
            }
        };
        self.images.borrow_mut().push(lent);
        lent
    }

    /// A buffer of `bytes` bytes.
    pub fn room(&self, bytes: u64) -> Room {
        let info = vk::BufferCreateInfo::default().size(bytes).usage(
            vk::BufferUsageFlags::STORAGE_BUFFER
                | vk::BufferUsageFlags::UNIFORM_BUFFER
                | vk::BufferUsageFlags::TRANSFER_DST,
        );
        let seen = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        // SAFETY: the device is alive, and the buffer gets memory that can be mapped.
        let room = unsafe {
            let buffer = self.device.create_buffer(&info, None).unwrap();
            let needs = self.device.get_buffer_memory_requirements(buffer);
            let memory = self.memory(needs, seen);
            self.device.bind_buffer_memory(buffer, memory, 0).unwrap();
            let flags = vk::MemoryMapFlags::empty();
            let at = self
                .device
                .map_memory(memory, 0, vk::WHOLE_SIZE, flags)
                .unwrap();
            Room {
                buffer,
                memory,
                bytes,
                at: at.cast(),
            }
        };
        self.buffers.borrow_mut().push(room);
        room
    }

    /// A command buffer that is being recorded.
    pub fn begin(&self) -> vk::CommandBuffer {
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.pool)
            .command_buffer_count(1);
        let once = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the pool belongs to the device.
        unsafe {
            let commands = self.device.allocate_command_buffers(&info).unwrap()[0];
            self.device.begin_command_buffer(commands, &once).unwrap();
            commands
        }
    }

    /// Ends and submits, without waiting.
    pub fn submit(&self, commands: vk::CommandBuffer) {
        let all = [commands];
        let work = [vk::SubmitInfo::default().command_buffers(&all)];
        // SAFETY: the command buffer is being recorded; tests record only what is valid.
        unsafe {
            self.device.end_command_buffer(commands).unwrap();
            self.device
                .queue_submit(self.queue, &work, vk::Fence::null())
                .unwrap();
        }
    }

    /// Fills a color image, of which nothing matters any more, and leaves it to be written by transfers.
    pub fn fill(&self, commands: vk::CommandBuffer, image: vk::Image, color: [f32; 4]) {
        let aspect = vk::ImageAspectFlags::COLOR;
        self.pass(commands, image, aspect, FRESH, TRANSFER_WRITE);
        let value = vk::ClearColorValue { float32: color };
        let layout = TRANSFER_WRITE.layout;
        // SAFETY: the command buffer is being recorded.
        unsafe {
            self.device
                .cmd_clear_color_image(commands, image, layout, &value, &[whole(aspect)])
        };
    }

    /// Waits for everything.
    pub fn wait(&self) {
        // SAFETY: the queue belongs to the device, and nobody else uses it.
        unsafe { self.device.queue_wait_idle(self.queue) }.unwrap();
    }

    /// Brings an image from one use to another.
    pub fn pass(
        &self,
        commands: vk::CommandBuffer,
        image: vk::Image,
        aspect: vk::ImageAspectFlags,
        from: ImageUse,
        to: ImageUse,
    ) {
        let barrier = [vk::ImageMemoryBarrier::default()
            .src_access_mask(from.access)
            .dst_access_mask(to.access)
            .old_layout(from.layout)
            .new_layout(to.layout)
            .image(image)
            .subresource_range(whole(aspect))];
        // Whatever it was used for in frames before is over first.
        let before = from.stage | vk::PipelineStageFlags::ALL_COMMANDS;
        let flags = vk::DependencyFlags::empty();
        // SAFETY: the command buffer is being recorded.
        unsafe {
            self.device
                .cmd_pipeline_barrier(commands, before, to.stage, flags, &[], &[], &barrier)
        };
    }

    /// Copies a color image, readied for it, to `room`.
    pub fn copy(&self, commands: vk::CommandBuffer, image: vk::Image, size: [u32; 2], room: &Room) {
        let region = [vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                layer_count: 1,
                ..Default::default()
            })
            .image_extent(vk::Extent3D {
                width: size[0],
                height: size[1],
                depth: 1,
            })];
        let layout = TRANSFER_READ.layout;
        let visible = [vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(vk::AccessFlags::HOST_READ)];
        // SAFETY: the command buffer is being recorded, and the room is large enough.
        unsafe {
            self.device
                .cmd_copy_image_to_buffer(commands, image, layout, room.buffer, &region);
            self.device.cmd_pipeline_barrier(
                commands,
                vk::PipelineStageFlags::TRANSFER,
                vk::PipelineStageFlags::HOST,
                vk::DependencyFlags::empty(),
                &visible,
                &[],
                &[],
            );
        }
    }
}
