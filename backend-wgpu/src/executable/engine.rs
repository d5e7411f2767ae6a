//! What an engine with a device of its own does with an executable: lends it images and buffers, records its frames.
use super::WgpuExecutable;
use crate::stores::Import;
use gibs_graph::{BackendError, ResourceId};
use std::sync::Arc;

impl WgpuExecutable {
    /// Takes an image of the engine for an imported or exported one, from the next recorded frame on: a view of the
    /// first mip level of a two-dimensional texture. One that is read needs `TEXTURE_BINDING` and a format of its class
    /// (a depth view needs the aspect `DepthOnly`), one that is written needs `STORAGE_BINDING` and the very format.
    /// Reading it and uploads to it are refused from then on, as for a buffer.
    /// Images that come again and again, as those of a swapchain do, cost bind groups only the first time.
    ///
    /// # Errors
    /// [`BackendError::Refused`]; what else does not fit shows when a frame is recorded.
    pub fn import_image(
        &mut self,
        resource: ResourceId,
        view: &wgpu::TextureView,
    ) -> Result<(), BackendError> {
        self.import(resource, Import::Image(view.clone()))
    }

    /// Takes a buffer of the engine for an input or an output, from the next recorded frame on. It needs the usage
    /// `STORAGE`, or `UNIFORM` or `INDIRECT`, as stages use it. Reading it and uploads to it are refused from then on; what
    /// was uploaded before stays with the backend's own buffer.
    ///
    /// # Errors
    /// [`BackendError::Refused`]; what else does not fit shows when a frame is recorded.
    pub fn import_buffer(
        &mut self,
        resource: ResourceId,
        buffer: &wgpu::Buffer,
    ) -> Result<(), BackendError> {
        self.import(resource, Import::Buffer(buffer.clone()))
    }

    fn import(&mut self, resource: ResourceId, import: Import) -> Result<(), BackendError> {
        if self.stores.set_import(resource, import)? {
            self.steps.unbind();
        }
        Ok(())
    }

    /// Forgets the bind groups of images and buffers that are not in use now: after a resize of the engine's images.
    pub fn forget_imports(&mut self) {
        self.steps.forget();
    }

    /// Records one frame into an engine's encoder, without submitting it. wgpu orders the frame behind what the engine
    /// recorded before it, and what comes after it behind the frame.
    ///
    /// An upload of at most [`RECORDED_UPLOAD`](crate::RECORDED_UPLOAD) bytes to a buffer is recorded at the start of
    /// the next frame. So an engine may record any number of frames, also into one submission, and between them make
    /// such uploads and change imports: each frame sees what was there when it was recorded. Several encoders are
    /// submitted in the order in which frames were recorded into them.
    ///
    /// The rest takes effect ahead of frames that are recorded and not submitted, so submit them first:
    /// - A larger upload, and one of an image, takes effect before everything in the next submission.
    /// - Once [`RECORDED_UPLOADS`](crate::RECORDED_UPLOADS) bytes wait for a frame, the next upload has them submitted.
    /// - [`run`](gibs_graph::Executable::run), [`run_step`](gibs_graph::Executable::run_step),
    ///   [`read`](gibs_graph::Executable::read) and [`reset`](gibs_graph::Executable::reset) submit.
    ///
    /// If the encoder is dropped and not submitted, the uploads that its frames brought along are lost with them.
    /// Histories have rotated all the same, so that the next frame may find the value of an earlier one.
    ///
    /// A frame with such uploads takes a staging buffer of at least 64 KiB. It is used again once the device is done
    /// with it and wgpu was polled or submitted to.
    ///
    /// # Errors
    /// The device failed. What is wrong with the encoder itself shows when it is finished.
    pub fn record(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<(), BackendError> {
        self.steps.bind(&self.context, &mut self.stores)?;
        let context = Arc::clone(&self.context);
        context.guard(|| self.record_frame(encoder))?
    }

    /// Records the uploads that wait for the next frame, without a frame: for an engine that itself reads or writes
    /// [`WgpuExecutable::buffer`], so that they come before what it records next.
    ///
    /// # Errors
    /// As [`WgpuExecutable::record`].
    pub fn record_uploads(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), BackendError> {
        let context = Arc::clone(&self.context);
        context.guard(|| self.uploads.record(&context, encoder))?
    }

    /// The buffer of a resource for an engine to read from, or, of an input, to copy into; of a history, the one that
    /// the last recorded frame wrote. `None` where no stage sees it on the device. Small uploads get there with the next
    /// frame, or [`WgpuExecutable::record_uploads`].
    pub fn buffer(&self, resource: ResourceId) -> Option<&wgpu::Buffer> {
        self.stores.current(resource, self.parity)
    }
}
