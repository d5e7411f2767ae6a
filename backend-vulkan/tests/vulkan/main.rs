//! The Vulkan backend on whatever device is there, every call watched by the validation layer.
mod adoption;
mod engine;
mod errors;
mod frames;
mod homes;
mod host;
mod images;
mod imports;
mod lent_buffers;
mod recording;
mod stages;
mod state;
mod support;
mod transfers;
mod validation;
