//! Runs gibs schedules on Vulkan 1.2 and newer: the WGSL kernels as SPIR-V, through ash.
//!
//! [`VulkanBackend::new`] makes a device of its own, [`VulkanBackend::from_host`] uses the one that an engine already
//! has. [`VulkanExecutable`] is what a schedule becomes: buffers, pipelines, and one command buffer per parity of the
//! rotating histories, recorded once and submitted again every frame. Barriers stand only where the schedule found a
//! hazard.
//!
//! An engine can lend its images and buffers to an executable ([`VulkanExecutable::import_image`],
//! [`VulkanExecutable::import_buffer`]), use those of the executable in place ([`VulkanExecutable::buffer`]), and have
//! frames recorded into its own command buffers ([`VulkanExecutable::record`]).
//!
//! The Vulkan loader is opened at run time, so a program with this backend starts on a machine without one.
#![deny(clippy::undocumented_unsafe_blocks)]
#![warn(missing_docs)]
mod adapter;
mod backend;
mod barriers;
mod bound;
mod cache;
mod descriptors;
mod device;
mod executable;
mod host;
mod image;
mod image_transfer;
mod imports;
mod instance;
mod kernels;
mod lend;
mod limits;
mod memory;
mod pending;
mod pools;
mod rays;
mod record;
mod spirv;
mod storage;
mod stream;
mod structures;
mod timing;
mod transfer;
mod validation;

pub use ash;
pub use backend::{Options, VulkanBackend};
pub use executable::VulkanExecutable;
pub use imports::{ImageUse, ImportedImage};
pub use validation::ValidationLog;
