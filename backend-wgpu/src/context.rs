//! A device as everything here sees it: with errors as values.
use crate::kernels::KernelCache;
use crate::limits;
use gibs_graph::{BackendError, Capabilities, DeviceInfo};
use gibs_shaders::Compiler;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Name of the backend.
pub(crate) const NAME: &str = "wgpu";

/// What to do about a device that went away.
const LOST: &str = "it was lost while work was under way; start again, with less work per frame if the driver timed out";

/// A device, its queue, and the kernels built for it. Shared by a backend and its executables.
pub(crate) struct Context {
    pub info: DeviceInfo,
    pub capabilities: Capabilities,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub compiler: Compiler,
    pub kernels: Mutex<KernelCache>,
    /// Kernels go to the driver as SPIR-V words.
    pub same_spirv: bool,
    faults: Arc<Mutex<Faults>>,
}

/// What the device reported outside of any call.
#[derive(Default)]
struct Faults {
    /// Why the device was lost; from then on every call fails.
    lost: Option<String>,
    /// An error that no scope caught; the next call returns it.
    stray: Option<String>,
}

/// Whose device it is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Owner {
    /// Made here: its error handlers are ours.
    Gibs,
    /// Made by an engine, whose error handlers are left alone.
    Engine,
}

impl Context {
    pub fn new(
        info: DeviceInfo,
        device: wgpu::Device,
        queue: wgpu::Queue,
        owner: Owner,
        same_spirv: bool,
    ) -> Self {
        let faults = Arc::new(Mutex::new(Faults::default()));
        if owner == Owner::Gibs {
            listen(&device, &faults);
        }
        Self {
            info,
            capabilities: limits::capabilities(&device.limits(), device.features()),
            device,
            queue,
            compiler: Compiler::new(),
            kernels: Mutex::default(),
            same_spirv,
            faults,
        }
    }

    /// Runs `work` and returns what wgpu reported about it as a failure of the device.
    pub fn guard<T>(&self, work: impl FnOnce() -> T) -> Result<T, BackendError> {
        self.guard_as(work, |error| self.failed(&said(&error)))
    }

    /// As [`Context::guard`], with a say in what an error means.
    pub fn guard_as<T>(
        &self,
        work: impl FnOnce() -> T,
        means: impl FnOnce(wgpu::Error) -> BackendError,
    ) -> Result<T, BackendError> {
        self.check()?;
        let scopes = [
            wgpu::ErrorFilter::OutOfMemory,
            wgpu::ErrorFilter::Internal,
            wgpu::ErrorFilter::Validation,
        ]
        .map(|filter| self.device.push_error_scope(filter));
        let made = work();
        // Innermost first. Of several errors, running out of memory is the cause and the others are consequences.
        let caught = scopes
            .into_iter()
            .rev()
            .filter_map(|scope| pollster::block_on(scope.pop()))
            .last();
        self.check()?;
        caught.map_or(Ok(made), |error| Err(means(error)))
    }

    /// Waits until `submission`, or everything submitted so far, has finished.
    pub fn wait(&self, submission: Option<wgpu::SubmissionIndex>) -> Result<(), BackendError> {
        let poll = wgpu::PollType::Wait {
            submission_index: submission,
            timeout: None,
        };
        // wgpu panics when the device is lost while it waits for it.
        let polled = self.guard(|| catch_unwind(AssertUnwindSafe(|| self.device.poll(poll))))?;
        match polled {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(error)) => Err(self.failed(&error.to_string())),
            Err(_) => Err(self.failed(LOST)),
        }
    }

    /// The device failed.
    pub fn failed(&self, message: &str) -> BackendError {
        BackendError::Device {
            device: self.info.name.clone(),
            message: message.into(),
        }
    }

    /// Fails if the device is lost, or once for an error that nothing caught.
    fn check(&self) -> Result<(), BackendError> {
        let mut faults = lock(&self.faults);
        let stray = faults.stray.take();
        match faults.lost.clone().or(stray) {
            Some(message) => Err(self.failed(&message)),
            None => Ok(()),
        }
    }
}

/// Locks; a panic elsewhere leaves nothing half-done behind these locks.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What wgpu said, without the heading that all its messages share.
pub(crate) fn said(error: &wgpu::Error) -> String {
    let text = error.to_string();
    text.strip_prefix("Validation Error\n\nCaused by:\n")
        .unwrap_or(&text)
        .trim()
        .into()
}

fn listen(device: &wgpu::Device, faults: &Arc<Mutex<Faults>>) {
    let stray = Arc::clone(faults);
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        // The first is the cause.
        lock(&stray).stray.get_or_insert_with(|| said(&error));
    }));
    let lost = Arc::clone(faults);
    device.set_device_lost_callback(move |reason, message| {
        lock(&lost)
            .lost
            .get_or_insert_with(|| format!("it was lost ({reason:?}): {message}"));
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::buffers::out_of_memory;
    use crate::{Options, WgpuBackend};

    /// A backend, or nothing on a machine without a driver; `GIBS_STRICT=1` makes that a failure.
    fn backend() -> Option<WgpuBackend> {
        match WgpuBackend::new(Options::default()) {
            Ok(backend) => Some(backend),
            Err(error) if std::env::var("GIBS_STRICT").as_deref() == Ok("1") => panic!("{error}"),
            Err(error) => {
                println!("not run: {error}");
                None
            }
        }
    }

    fn bad_buffer(context: &Context) -> wgpu::Buffer {
        context.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("bad"),
            size: 16,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        })
    }

    #[test]
    fn an_error_in_a_scope_is_returned_and_gone() {
        let Some(backend) = backend() else { return };
        let context = backend.context();
        assert!(matches!(
            context.guard(|| bad_buffer(context)),
            Err(BackendError::Device { .. })
        ));
        assert!(context.guard(|| ()).is_ok());
    }

    #[test]
    fn a_stray_error_is_returned_by_the_next_call_once() {
        let Some(backend) = backend() else { return };
        let context = backend.context();
        let _ = bad_buffer(context);
        assert!(matches!(
            context.wait(None),
            Err(BackendError::Device { .. })
        ));
        assert!(context.wait(None).is_ok());
    }

    #[test]
    fn a_lost_device_fails_every_call() {
        let Some(backend) = backend() else { return };
        let context = backend.context();
        context.device.destroy();
        let _ = context.device.poll(wgpu::PollType::Poll);
        for _ in 0..2 {
            assert!(matches!(
                context.wait(None),
                Err(BackendError::Device { .. })
            ));
        }
    }

    /// Memory cannot be made to run out alike on every machine; what wgpu says then is one error, raised here.
    #[test]
    fn memory_that_runs_out_names_the_resource() {
        let Some(backend) = backend() else { return };
        let error = wgpu::Error::OutOfMemory {
            source: "no room".into(),
        };
        let refused = out_of_memory(backend.context(), "numbers", 4096, &error);
        assert!(
            matches!(&refused, BackendError::OutOfMemory { resource, bytes: 4096, .. } if resource == "numbers"),
            "{refused}"
        );
    }
}
