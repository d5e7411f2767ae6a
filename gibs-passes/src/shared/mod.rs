//! Functions that several kernels share. Each module has a WGSL module of the same name in `shaders/modules`, written
//! from the same formulas; they agree to the last bit where the device rounds `+ - * / sqrt` correctly.
pub mod batch;
pub mod bounds;
pub mod debug;
pub mod depth;
pub mod emitter;
pub mod environment;
pub mod estimator;
pub mod gbuffer;
pub mod grid;
pub mod guide;
pub mod hash;
pub mod lists;
pub mod lookup;
pub mod mark;
pub mod mixture;
pub mod octahedral;
pub mod portable;
pub mod recycling;
pub mod requests;
pub mod sampling;
pub mod scan;
pub mod sharing;
pub mod sorting;
pub mod surface;
pub mod texture;
pub mod upsample;
