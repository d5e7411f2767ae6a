//! The Vulkan backend on whatever device is there, every call watched by the validation layer.
mod adoption;
mod errors;
mod frames;
mod host;
mod stages;
mod state;
mod support;
mod transfers;
mod validation;
