//! What a backend is.
use crate::{Capabilities, Resource, ResourceId, Schedule};
use serde::Serialize;
use std::any::Any;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;

/// Runs schedules on some device. It may be shared between threads.
pub trait Backend: Send + Sync {
    /// Short name: `cpu`, `wgpu`, `vulkan`.
    fn name(&self) -> &str;

    /// The device behind it.
    fn device(&self) -> &DeviceInfo;

    /// What the device allows. [`Backend::prepare`] holds every schedule against it, with [`Capabilities::check`],
    /// before it builds or allocates anything.
    fn capabilities(&self) -> &Capabilities;

    /// Allocates everything that `schedule` needs and builds its kernels. States and histories hold their initial
    /// values, everything else zero.
    ///
    /// # Errors
    /// A kernel that the device refuses, a limit that the schedule exceeds, not enough memory.
    fn prepare(&self, schedule: Arc<Schedule>) -> Result<Box<dyn Executable>, BackendError>;
}

/// A schedule that is ready to run. A backend's own type behind it is found through `dyn Any`:
/// `(exec as Box<dyn Any>).downcast()`.
///
/// Calls take effect in order: an upload before [`Executable::run`] is seen by that frame. It may move to another
/// thread between calls, such as an engine's render thread.
pub trait Executable: Any + Send {
    /// The schedule.
    fn schedule(&self) -> &Arc<Schedule>;

    /// Replaces bytes of a resource from `offset` on, in bytes. Of a history, the current allocation; of an image, all
    /// of its values, [`Texel::Value`](crate::Texel::Value)s row by row.
    ///
    /// # Errors
    /// Out of range, or the device failed.
    fn upload(
        &mut self,
        resource: ResourceId,
        offset: u64,
        bytes: &[u8],
    ) -> Result<(), BackendError>;

    /// Runs one frame.
    ///
    /// # Errors
    /// The device failed.
    fn run(&mut self) -> Result<(), BackendError>;

    /// Begins a frame that is run step by step, with [`Executable::run_step`]: histories make the value of the last frame
    /// that of the frame before, as [`Executable::run`] does before its first step.
    ///
    /// # Errors
    /// As [`Executable::run`].
    fn rotate(&mut self) -> Result<(), BackendError>;

    /// Runs one step of the frame alone, without clearing or rotating anything else. For lockstep checks.
    ///
    /// # Errors
    /// As [`Executable::run`].
    fn run_step(&mut self, step: usize) -> Result<(), BackendError>;

    /// Waits for all work and returns the bytes of a resource; of a history, the value that the last frame made; of an
    /// image, its values. A transient that is no output may have lost its value to one that shares its memory; see
    /// [`Graph::keep_transients`](crate::Graph::keep_transients).
    ///
    /// # Errors
    /// The device failed.
    fn read(&mut self, resource: ResourceId) -> Result<Vec<u8>, BackendError>;

    /// Sets every state and history to its initial value.
    ///
    /// # Errors
    /// The device failed.
    fn reset(&mut self) -> Result<(), BackendError>;

    /// Waits for all work that was started.
    ///
    /// # Errors
    /// The device failed.
    fn wait(&mut self) -> Result<(), BackendError>;

    /// Turns measuring time per step on or off; nothing happens where the backend cannot.
    fn measure(&mut self, on: bool) {
        let _ = on;
    }

    /// Time per step of the last frame that finished while measuring; `None` where nothing was measured. Waits for it.
    ///
    /// # Errors
    /// The device failed.
    fn timings(&mut self) -> Result<Option<Vec<StepTime>>, BackendError> {
        Ok(None)
    }

    /// Whether a host has lent memory that stands in for the resource's own, in ways that the backend's own type offers.
    fn lent(&self, resource: ResourceId) -> bool {
        let _ = resource;
        false
    }

    /// Runs `schedule` from now on, as if it had been prepared anew, but with the content of every persistent resource
    /// that [`Schedule::adoptions`] names. What a host has lent is forgotten.
    ///
    /// # Errors
    /// As [`Backend::prepare`]; the executable is then as it was, and goes on with its schedule.
    fn adopt(&mut self, schedule: Arc<Schedule>) -> Result<(), BackendError>;
}

/// Time that one step took.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct StepTime {
    /// Index into [`Schedule::steps`].
    pub step: usize,
    /// From the start of the frame's first measured step, by the clock that `time` is from.
    pub start: Duration,
    /// From start to end on the device.
    pub time: Duration,
}

/// What a backend runs on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DeviceInfo {
    /// Device name, as the driver gives it.
    pub name: String,
    /// Driver and version.
    pub driver: String,
    /// `cpu`, `integrated`, `discrete`, `virtual` or `software`.
    pub kind: String,
    /// Time per step can be measured on the device.
    pub timestamps: bool,
    /// Rays can be traced by hardware.
    pub ray_query: bool,
    /// Anything else worth knowing, such as SIMD width or thread count.
    pub notes: Vec<String>,
}

/// What a backend can fail with.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BackendError {
    /// The backend is not there.
    #[error("the {backend} backend is not available: {reason}; {remedy}")]
    Unavailable {
        /// Backend.
        backend: String,
        /// What was missing.
        reason: String,
        /// What to do.
        remedy: String,
    },
    /// A limit of the device is exceeded.
    #[error("{what} needs {need}, the device `{device}` allows {limit}; {remedy}")]
    Limit {
        /// Stage or resource.
        what: String,
        /// What is needed.
        need: u64,
        /// What is allowed.
        limit: u64,
        /// Device.
        device: String,
        /// What to do.
        remedy: String,
    },
    /// A kernel could not be built.
    #[error("stage `{stage}`: {message}")]
    Kernel {
        /// Stage.
        stage: String,
        /// What the compiler or the driver said.
        message: String,
    },
    /// Memory ran out.
    #[error(
        "out of memory on `{device}` allocating {bytes} bytes for `{resource}`; use fewer surfels or rays, a smaller picture or scene, or another backend"
    )]
    OutOfMemory {
        /// Device.
        device: String,
        /// Resource.
        resource: String,
        /// Bytes asked for.
        bytes: u64,
    },
    /// The device failed or was lost.
    #[error("the device `{device}` failed: {message}")]
    Device {
        /// Device.
        device: String,
        /// What the driver said.
        message: String,
    },
    /// The caller asked for bytes that are not there.
    #[error("`{resource}` has {bytes} bytes, {offset}..{end} was asked for; stay within them")]
    Range {
        /// Resource.
        resource: String,
        /// Its size.
        bytes: u64,
        /// First byte asked for.
        offset: u64,
        /// End of the bytes asked for.
        end: u64,
    },
    /// The caller asked for something that cannot be done as things stand.
    #[error("{what}: {reason}; {remedy}")]
    Refused {
        /// What was asked for, or of what.
        what: String,
        /// Why not.
        reason: String,
        /// What to do.
        remedy: String,
    },
    /// Two workgroups wrote one element, or two invocations of one; found in the CPU backend's checking mode.
    #[error(
        "stage `{stage}`, port `{port}`: the bytes at {offset} were written twice, by two workgroups or by two invocations of one; let one invocation write each element, once"
    )]
    WriteConflict {
        /// Stage.
        stage: String,
        /// Port.
        port: String,
        /// Byte offset in the resource.
        offset: u64,
    },
}

/// Checks an upload against the size of a resource.
///
/// # Errors
/// [`BackendError::Range`]; [`BackendError::Refused`] where the schedule has no such resource.
pub fn check_range(
    schedule: &Schedule,
    resource: ResourceId,
    offset: u64,
    len: usize,
) -> Result<(), BackendError> {
    let Some(found) = schedule.resources.get(resource as usize) else {
        return Err(BackendError::Refused {
            what: format!("resource {resource} of `{}`", schedule.name),
            reason: format!("the schedule has {} resources", schedule.resources.len()),
            remedy: "take the number from `Schedule::resource` or `Schedule::output`".into(),
        });
    };
    match offset.checked_add(len as u64) {
        Some(end) if end <= found.bytes => Ok(()),
        end => Err(BackendError::Range {
            resource: found.key.clone(),
            bytes: found.bytes,
            offset,
            end: end.unwrap_or(u64::MAX),
        }),
    }
}

/// Checks that a schedule has a step.
///
/// # Errors
/// [`BackendError::Refused`].
pub fn check_step(schedule: &Schedule, step: usize) -> Result<(), BackendError> {
    let steps = schedule.steps.len();
    if step < steps {
        return Ok(());
    }
    Err(BackendError::Refused {
        what: format!("step {step} of `{}`", schedule.name),
        reason: format!("the schedule has {steps} steps"),
        remedy: "take the number from `Schedule::steps`".into(),
    })
}

/// Checks an upload to an image: it takes all values at once.
///
/// # Errors
/// [`BackendError::Refused`].
pub fn check_image(image: &Resource, len: usize) -> Result<(), BackendError> {
    if len as u64 == image.bytes {
        return Ok(());
    }
    Err(BackendError::Refused {
        what: format!("writing `{}`", image.key),
        reason: format!("{len} bytes were given, it has {}", image.bytes),
        remedy: "write the whole image, a value per texel".into(),
    })
}

/// The error of reading or writing a resource whose memory a host has lent; `done` is `read` or `written`. Only the host
/// knows when its own work is done with it, so backends leave it to the host.
pub fn lent(resource: &Resource, done: &str) -> BackendError {
    BackendError::Refused {
        what: format!("`{}` cannot be {done}", resource.key),
        reason: "the host has lent it".into(),
        remedy: "use it where the host has it".into(),
    }
}

/// The error of a step that a backend does not know, because the graph is newer than it.
pub fn unknown_step(label: &str) -> BackendError {
    BackendError::Refused {
        what: format!("the step `{label}`"),
        reason: "the backend does not know steps of its kind".into(),
        remedy: "use a backend and a graph that were released together".into(),
    }
}
