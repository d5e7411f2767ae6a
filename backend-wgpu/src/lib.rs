//! Runs gibs schedules on wgpu: Vulkan, and whatever else wgpu was built with.
//!
//! [`WgpuBackend::new`] picks a device of its own; [`WgpuBackend::from_device`] takes that of an engine, which may then
//! record frames into its own command encoder ([`WgpuExecutable::record`]) and bind the results
//! ([`WgpuExecutable::buffer`]).
//!
//! Every allocation is one buffer, bound as a whole; a history has two, and two bind groups per stage that sees it.
//! wgpu orders dispatches by itself, so a schedule's hazards need no translation here: a compute pass goes on until
//! something other than a dispatch comes.
#![deny(unsafe_code)]
mod backend;
mod buffers;
mod context;
mod device;
mod executable;
mod images;
mod kernels;
mod limits;
mod passthrough;
mod stores;
mod timing;

pub use backend::WgpuBackend;
pub use device::{Options, devices};
pub use executable::WgpuExecutable;
pub use passthrough::SAME_SPIRV;

pub use wgpu;
