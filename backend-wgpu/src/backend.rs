//! The backend: a device that schedules can be prepared for.
use crate::context::{Context, NAME};
use crate::{Options, WgpuExecutable, device};
use gibs_graph::{Backend, BackendError, Capabilities, DeviceInfo, Executable, Schedule};
use std::sync::Arc;

/// A wgpu device as a backend.
pub struct WgpuBackend {
    context: Arc<Context>,
}

impl WgpuBackend {
    /// Opens a device of its own, without a window.
    ///
    /// # Errors
    /// [`BackendError::Unavailable`] if there is no such device, or it lacks what `options` ask for.
    pub fn new(options: Options) -> Result<Self, BackendError> {
        Ok(Self {
            context: Arc::new(device::open(&options)?),
        })
    }

    /// Uses the device and the queue that an engine has; `info` is that of its adapter. The engine's handlers for
    /// errors and for a lost device stay in place. Times per step need `Features::TIMESTAMP_QUERY` on the device.
    pub fn from_device(info: &wgpu::AdapterInfo, device: wgpu::Device, queue: wgpu::Queue) -> Self {
        Self {
            context: Arc::new(device::take(info, device, queue)),
        }
    }

    /// As [`Backend::prepare`], for those who record frames into their own encoder.
    ///
    /// # Errors
    /// As [`Backend::prepare`].
    pub fn prepare_wgpu(&self, schedule: Arc<Schedule>) -> Result<WgpuExecutable, BackendError> {
        WgpuExecutable::new(Arc::clone(&self.context), schedule, None)
    }

    #[cfg(test)]
    pub(crate) fn context(&self) -> &Context {
        &self.context
    }
}

impl Backend for WgpuBackend {
    fn name(&self) -> &str {
        NAME
    }

    fn device(&self) -> &DeviceInfo {
        &self.context.info
    }

    fn capabilities(&self) -> &Capabilities {
        &self.context.capabilities
    }

    fn prepare(&self, schedule: Arc<Schedule>) -> Result<Box<dyn Executable>, BackendError> {
        Ok(Box::new(self.prepare_wgpu(schedule)?))
    }
}

impl std::fmt::Debug for WgpuBackend {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WgpuBackend")
            .field("device", &self.context.info)
            .finish_non_exhaustive()
    }
}
