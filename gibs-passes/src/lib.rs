//! The stages of surfel global illumination (GIBS, SIGGRAPH 2021), their CPU kernels, and the frames that wire them.
pub mod accel;
pub mod data;
pub mod device;
pub mod frame;
pub mod scene;
pub mod shared;
pub mod simd;
pub mod stages;
