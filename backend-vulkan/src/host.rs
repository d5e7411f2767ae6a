//! Frames in command buffers of a host.
use crate::barriers::{Barrier, close, open};
use crate::executable::VulkanExecutable;
use crate::lend::refused;
use ash::vk;
use gibs_graph::BackendError;

impl VulkanExecutable {
    /// Says what the host does with buffers of this executable after a frame that [`VulkanExecutable::record`] recorded:
    /// the frame ends with a barrier that makes what it wrote visible to these accesses of these pipeline stages. At
    /// first, to any read of anything (`ALL_COMMANDS`, `MEMORY_READ`). Lent images have an exit of their own.
    pub fn set_exit(&mut self, stage: vk::PipelineStageFlags, access: vk::AccessFlags) {
        self.exit = match stage.is_empty() {
            // No stage at all waits for nothing, which is what this one does.
            true => (
                vk::PipelineStageFlags::BOTTOM_OF_PIPE,
                vk::AccessFlags::empty(),
            ),
            false => (stage, access),
        };
    }

    /// Records one frame, with everything that was uploaded before, into a command buffer of the host, and submits
    /// nothing. Frames of several executables may follow each other in one command buffer.
    ///
    /// The frame begins behind everything before it on the queue, and sees what that wrote. It ends with a barrier for
    /// what the host does next ([`VulkanExecutable::set_exit`]). Pipeline, descriptor sets and push constants for
    /// compute are not those from before.
    ///
    /// Uploads come along if they are small: at most 64 KiB each and 1 MiB together, at offsets and of sizes that are
    /// multiples of 4. Others are recorded here, and with them resets; [`Executable::wait`] sends them off.
    ///
    /// Times of a measured frame ([`Executable::measure`]) can be read once the host has waited for it.
    ///
    /// [`Executable::measure`]: gibs_graph::Executable::measure
    /// [`Executable::wait`]: gibs_graph::Executable::wait
    ///
    /// # Errors
    /// [`BackendError::Refused`] while uploads that do not come along, or a reset, were not sent off, or what rays are
    /// traced in changed: [`Executable::wait`] builds it, too;
    /// [`BackendError::OutOfMemory`]; the device failed. Then nothing was recorded.
    ///
    /// # Safety
    /// - `commands` is a primary command buffer of the backend's device and queue family that is being recorded, outside
    ///   of a render pass.
    /// - It is submitted once, to the backend's queue, in order with the other frames of this executable, and before
    ///   anything else of this executable is called than uploads that come along, [`Executable::measure`], `record`, the
    ///   imports and `set_exit`.
    /// - At most two recorded frames of this executable are under way at a time.
    /// - Every recorded frame is done before the executable is dropped, or adopts a schedule. The executable itself waits only
    ///   for what it submitted.
    pub unsafe fn record(&mut self, commands: vk::CommandBuffer) -> Result<(), BackendError> {
        if self.stream.is_open() || self.stores.structures.is_stale() {
            return Err(refused(
                format!("recording a frame of `{}`", self.schedule.name),
                "large uploads or a reset before it are recorded, but not submitted, or an acceleration structure is not built",
                "call wait() once after uploading a scene or resetting",
            ));
        }
        let parity = 1 - self.parity;
        self.resolve(parity)?;
        self.start_timer()?;
        let timer = self.timer.as_ref().filter(|_| self.measuring);
        let device = &self.stream.device;
        let written = &mut self.stream.staging.written;
        // SAFETY: the caller's promise; everything that the program refers to lives as long as this value or was lent
        // for as long as frames may use it.
        unsafe {
            open(&device.raw, commands);
            if !self.stream.pending.is_empty() {
                written.clear();
                self.stream.pending.record(&device.raw, commands, written);
                Barrier::FULL.record(&device.raw, commands);
            }
            self.program.record_frame(device, commands, parity, timer);
            let (stage, access) = self.exit;
            close(&device.raw, commands, stage, access);
        }
        if let Some(timer) = self.timer.as_mut().filter(|_| self.measuring) {
            timer.submitted(parity, None);
        }
        self.parity = parity;
        Ok(())
    }
}
