//! Images and buffers that a host lends to an executable, for frames to use in place.
use ash::vk;
use gibs_graph::ResourceId;

/// An image of a host. See [`VulkanExecutable::import_image`](crate::VulkanExecutable::import_image).
///
/// Only the first level and layer are touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImportedImage {
    /// The image.
    pub image: vk::Image,
    /// A view of the aspect that stages see: of an image with depth and stencil, the depth.
    pub view: vk::ImageView,
    /// Every aspect that the image has, also those that the view leaves out: layouts change for all of them together.
    pub aspect: vk::ImageAspectFlags,
    /// How the image comes into each frame. The layout may be `UNDEFINED` where what it held does not matter, as for an
    /// export that is written all over.
    pub entry: ImageUse,
    /// How each frame leaves it.
    pub exit: ImageUse,
}

/// A use of an image outside of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageUse {
    /// Layout.
    pub layout: vk::ImageLayout,
    /// Pipeline stages of the use, which the queue must have; none where nothing needs to wait.
    pub stage: vk::PipelineStageFlags,
    /// What they do with it.
    pub access: vk::AccessFlags,
}

/// What stands in for a resource's own memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Import {
    Buffer(vk::Buffer),
    Image {
        lent: ImportedImage,
        /// Stages write it.
        stored: bool,
    },
}

/// Everything that is lent at the moment.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Imports(Vec<(ResourceId, Import)>);

/// Barriers that are recorded at once, without room on the heap.
const CHUNK: usize = 16;

impl Imports {
    /// What stands in for a resource.
    pub fn get(&self, resource: ResourceId) -> Option<Import> {
        let found = self.0.iter().find(|(id, _)| *id == resource);
        found.map(|(_, import)| *import)
    }

    /// Has `import` stand in for a resource, in place of what did so before.
    pub fn set(&mut self, resource: ResourceId, import: Import) {
        match self.0.iter_mut().find(|(id, _)| *id == resource) {
            Some((_, old)) => *old = import,
            None => self.0.push((resource, import)),
        }
    }

    /// Nothing stands in for anything any more.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Becomes what `other` is, in the memory that is there.
    pub fn copy(&mut self, other: &Self) {
        self.0.clone_from(&other.0);
    }

    /// Records that the images come to the frame.
    ///
    /// # Safety
    /// `commands` is a command buffer of `device` that is being recorded, and all images are as their entry says.
    pub unsafe fn enter(&self, device: &ash::Device, commands: vk::CommandBuffer) {
        // SAFETY: the caller's promise.
        unsafe {
            self.pass(device, commands, |lent, stored| {
                (lent.entry, inside(stored))
            })
        };
    }

    /// Records that the images go back to the host.
    ///
    /// # Safety
    /// As [`Imports::enter`], which was recorded before.
    pub unsafe fn leave(&self, device: &ash::Device, commands: vk::CommandBuffer) {
        // SAFETY: the caller's promise.
        unsafe { self.pass(device, commands, |lent, stored| (inside(stored), lent.exit)) };
    }

    unsafe fn pass(
        &self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        uses: impl Fn(&ImportedImage, bool) -> (ImageUse, ImageUse),
    ) {
        let mut images = self.0.iter().filter_map(|(_, import)| match import {
            Import::Image { lent, stored } => Some((lent, *stored)),
            Import::Buffer(_) => None,
        });
        loop {
            let mut barriers = [vk::ImageMemoryBarrier::default(); CHUNK];
            // A frame begins behind all work on the queue, and its stages wait for that. So what waits for them is behind
            // that, too, whatever the host says.
            let mut before = vk::PipelineStageFlags::COMPUTE_SHADER;
            let mut after = vk::PipelineStageFlags::empty();
            let mut count = 0;
            for (barrier, (lent, stored)) in barriers.iter_mut().zip(&mut images) {
                let (from, to) = uses(lent, stored);
                before |= from.stage;
                after |= to.stage;
                *barrier = barrier_between(lent, from, to);
                count += 1;
            }
            if count == 0 {
                return;
            }
            if after.is_empty() {
                after = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
            }
            let flags = vk::DependencyFlags::empty();
            let barriers = &barriers[..count];
            // SAFETY: the caller's promise; the stages make the accesses, as whoever lent the images promised.
            unsafe {
                device.cmd_pipeline_barrier(commands, before, after, flags, &[], &[], barriers);
            }
            if count < CHUNK {
                return;
            }
        }
    }
}

/// The layout in which stages see an image that was lent.
pub(crate) fn layout(stored: bool) -> vk::ImageLayout {
    match stored {
        true => vk::ImageLayout::GENERAL,
        false => vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
    }
}

/// How the stages of a frame use an image that was lent.
fn inside(stored: bool) -> ImageUse {
    ImageUse {
        layout: layout(stored),
        stage: vk::PipelineStageFlags::COMPUTE_SHADER,
        access: match stored {
            true => vk::AccessFlags::SHADER_WRITE,
            false => vk::AccessFlags::SHADER_READ,
        },
    }
}

fn barrier_between(
    lent: &ImportedImage,
    from: ImageUse,
    to: ImageUse,
) -> vk::ImageMemoryBarrier<'static> {
    vk::ImageMemoryBarrier::default()
        .src_access_mask(from.access)
        .dst_access_mask(to.access)
        .old_layout(from.layout)
        .new_layout(to.layout)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(lent.image)
        .subresource_range(vk::ImageSubresourceRange {
            aspect_mask: lent.aspect,
            ..crate::image::COLOR
        })
}
