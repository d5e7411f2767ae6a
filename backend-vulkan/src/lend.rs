//! What a host lends, and what it sees of an executable's memory.
use crate::bound::Bound;
use crate::executable::VulkanExecutable;
use crate::imports::{Import, ImportedImage};
use ash::vk;
use gibs_graph::{BackendError, Kind, Resource, ResourceId, check_image, check_range, lent};

/// Something that cannot be done as things stand.
pub(crate) fn refused(
    what: impl Into<String>,
    reason: impl Into<String>,
    remedy: impl Into<String>,
) -> BackendError {
    BackendError::Refused {
        what: what.into(),
        reason: reason.into(),
        remedy: remedy.into(),
    }
}

impl VulkanExecutable {
    /// The Vulkan buffer of a resource, of a history the current allocation, for engines that use it in place. `None`
    /// where the device has none. It stays valid until the executable is dropped or adopts another schedule, and its content is
    /// that of the last frame once [`Executable::wait`](gibs_graph::Executable::wait) returned, or, of a frame that
    /// [`VulkanExecutable::record`] recorded, behind it on the queue. Of a transient, only an output's lasts.
    pub fn buffer(&self, resource: ResourceId) -> Option<vk::Buffer> {
        let bound = Bound {
            stores: &self.stores,
            imports: &self.imports,
        };
        bound.buffer(resource, self.parity)
    }

    /// Has frames use an image of the host for an image resource, from the next one on that is run or recorded, until
    /// another takes its place or [`VulkanExecutable::forget_imports`] is called. What the resource's own image held,
    /// if there is one, stays there.
    ///
    /// Each frame takes the image as its `entry` says, and leaves it as its `exit` says. Images may change every frame:
    /// once a combination of them was used, using it again makes nothing and allocates nothing.
    ///
    /// # Errors
    /// [`BackendError::Refused`] if there is no such resource, if it is a buffer, or if the layout of `exit` is none that
    /// an image can be brought to.
    ///
    /// # Safety
    /// - Image and view belong to the backend's device, and outlive every frame that uses them; the view exists until
    ///   [`VulkanExecutable::forget_imports`] is called, or the executable is dropped.
    /// - The view is two-dimensional, of the first level and layer, as large as the resource (Vulkan says no image's size,
    ///   so this cannot be checked here), and of a format that
    ///   stages can have: for [`ImageFormat::Float`](gibs_graph::ImageFormat::Float) one of floats, normalized
    ///   integers or depths; for [`ImageFormat::Uint`](gibs_graph::ImageFormat::Uint) one of unsigned integers; else
    ///   the same format. The image was made to be sampled, or, for an export, for storage.
    /// - The queue's family owns the image, and it is in the entry's layout when a frame starts, also for
    ///   [`Executable::run_step`](gibs_graph::Executable::run_step). No image is lent for two resources at a time.
    pub unsafe fn import_image(
        &mut self,
        resource: ResourceId,
        lent: ImportedImage,
    ) -> Result<(), BackendError> {
        let Resource { key, image, .. } = self.resource(resource)?;
        let Some(shape) = image else {
            return Err(refused(
                format!("importing an image for `{key}`"),
                "it is a buffer",
                "use import_buffer",
            ));
        };
        let layout = lent.exit.layout;
        if [vk::ImageLayout::UNDEFINED, vk::ImageLayout::PREINITIALIZED].contains(&layout) {
            return Err(refused(
                format!("importing an image for `{key}`"),
                format!("no image can be brought to the layout {layout:?} of its exit"),
                "give the layout in which it is used next, or GENERAL",
            ));
        }
        let stored = shape.format.is_stored();
        self.imports.set(resource, Import::Image { lent, stored });
        Ok(())
    }

    /// Has frames use a buffer of the host for an input, as [`VulkanExecutable::import_image`] does for images. The
    /// host orders its writes before each frame on the queue; every frame begins with a barrier behind all of them.
    ///
    /// # Errors
    /// [`BackendError::Refused`] if there is no such resource, if it is an image, or no input.
    ///
    /// # Safety
    /// - The buffer belongs to the backend's device, and exists until [`VulkanExecutable::forget_imports`] is called,
    ///   or the executable is dropped; the queue's family owns it.
    /// - It has at least as many bytes as the resource, and was made for every use that the schedule has for it:
    ///   uniform, storage, sizes of indirect dispatches.
    pub unsafe fn import_buffer(
        &mut self,
        resource: ResourceId,
        lent: vk::Buffer,
    ) -> Result<(), BackendError> {
        let Resource {
            key, kind, image, ..
        } = self.resource(resource)?;
        let (reason, remedy) = match (image, kind) {
            _ if self.stores.structures.uses(resource) => (
                "an acceleration structure is built from what is uploaded to it",
                "upload its content",
            ),
            (None, Kind::Input) => {
                self.imports.set(resource, Import::Buffer(lent));
                return Ok(());
            }
            (Some(_), _) => ("it is an image", "use import_image"),
            (None, _) => (
                "it is no input",
                "use the executable's own buffer in place, which `buffer` gives",
            ),
        };
        Err(refused(
            format!("importing a buffer for `{key}`"),
            reason,
            remedy,
        ))
    }

    /// Has frames use the executable's own memory again, and lets go of everything that was lent since the last call.
    /// Waits for frames that were run.
    ///
    /// # Errors
    /// The device failed.
    ///
    /// # Safety
    /// Every frame that was recorded since is done, or will never be submitted.
    pub unsafe fn forget_imports(&mut self) -> Result<(), BackendError> {
        self.stream.finish()?;
        self.imports.clear();
        self.program.forget();
        for frame in &mut self.frames {
            frame.recorded = None;
        }
        // SAFETY: what was run is done, by the wait above, and what was recorded by the caller's promise; frames are
        // looked up and recorded again before they are next submitted.
        unsafe { self.descriptors.forget() }
    }

    /// Fails where the host has the memory of a resource.
    pub(crate) fn refuse_lent(&self, resource: ResourceId, done: &str) -> Result<(), BackendError> {
        match self.imports.get(resource) {
            None => Ok(()),
            Some(_) => Err(lent(self.resource(resource)?, done)),
        }
    }

    /// Replaces all texels of an own image by values.
    pub(crate) fn upload_image(
        &mut self,
        id: ResourceId,
        values: &[u8],
    ) -> Result<(), BackendError> {
        let resource = &self.schedule.resources[id as usize];
        check_image(resource, values.len())?;
        self.stores.make_image(id, resource, &mut self.stream)?;
        match (self.stores.image(id), resource.image) {
            (Some(image), Some(shape)) => {
                let texels = shape.format.encode(values);
                self.stream.write_image(image, &texels)
            }
            _ => Ok(()),
        }
    }

    /// The values of an own image.
    pub(crate) fn read_image(&mut self, id: ResourceId) -> Result<Vec<u8>, BackendError> {
        let resource = &self.schedule.resources[id as usize];
        self.stores.make_image(id, resource, &mut self.stream)?;
        match (self.stores.image(id), resource.image) {
            (Some(image), Some(shape)) => Ok(shape.format.decode(&self.stream.read_image(image)?)),
            _ => Ok(Vec::new()),
        }
    }

    fn resource(&self, id: ResourceId) -> Result<&Resource, BackendError> {
        check_range(&self.schedule, id, 0, 0)?;
        Ok(&self.schedule.resources[id as usize])
    }
}
