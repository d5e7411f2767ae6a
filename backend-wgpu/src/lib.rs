//! Runs gibs schedules on wgpu: Vulkan, and whatever else wgpu was built with.
//!
//! [`WgpuBackend::new`] picks a device of its own; [`WgpuBackend::from_device`] takes that of an engine, which may then
//! record frames into its own command encoder ([`WgpuExecutable::record`]) and bind the results
//! ([`WgpuExecutable::buffer`]).
//!
//! Every allocation is one buffer, bound as a whole; a history has two, and two bind groups per stage that sees it.
//! wgpu orders dispatches by itself, so a schedule's hazards need no translation here: a compute pass goes on until
//! something other than a dispatch comes.
//!
//! Small uploads are copies at the start of the next frame, from staging buffers that are used again; large ones, and
//! images, go to the queue.
#![deny(unsafe_code)]
#![warn(missing_docs)]
mod backend;
mod buffers;
mod context;
mod device;
mod executable;
mod images;
mod kernels;
mod limits;
mod passthrough;
mod patch;
mod record;
mod steps;
mod stores;
mod structures;
mod timing;
mod uploads;

pub use backend::WgpuBackend;
pub use device::{Options, devices};
pub use executable::WgpuExecutable;
pub use uploads::{RECORDED_UPLOAD, RECORDED_UPLOADS};

pub use wgpu;
