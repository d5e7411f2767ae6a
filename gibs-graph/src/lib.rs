//! A graph of typed compute stages, compiled to a schedule that any backend can run.
//!
//! A frame is recorded with [`Graph`]: resources are [`Buffer`] handles, and each handle is one *version* of a
//! resource. Stages, declared with [`stage!`], borrow the handles that they read and consume the handles that they
//! write, giving back the next version; so a stale read or a double write does not compile. [`Graph::compile`] turns
//! the recording into a [`Schedule`]: dead stages removed, the rest ordered, hazards found. A [`Backend`] makes a
//! schedule into an [`Executable`], which runs frames.
//!
//! This crate knows no device, no shader tool and no rendering: kernels are data ([`KernelSource`]), and shaders are
//! checked through the [`ShaderCompiler`] trait.
#![warn(missing_docs)]
// What the macros of this crate write names it, also in this crate.
extern crate self as gibs_graph;

mod acceleration;
mod backend;
mod capabilities;
pub mod check;
mod comparator;
mod compile;
mod declare;
mod element;
mod error;
mod export;
mod graph;
mod handle;
mod image_view;
mod kernel;
mod kind;
mod null;
mod port;
mod recorder;
mod schedule;
mod shader;
mod stage;
mod stage_words;
mod step;
mod texel;
mod view;

pub use acceleration::{
    AccelerationInstance, AccelerationPlan, AccelerationSource, AccelerationTriangle, BottomLevel,
};
pub use backend::{
    Backend, BackendError, DeviceInfo, Executable, StepTime, check_image, check_range, check_step,
    lent, unknown_step,
};
pub use capabilities::Capabilities;
pub use comparator::{Comparator, Floats, Lists, Order, Ports};
pub use element::{DispatchArgs, Element, Field, Layout, Scalar};
pub use error::{GraphError, GraphErrors};
pub use graph::{Dispatch, Graph, MAX_GROUPS, groups_for};
pub use handle::{Acceleration, Buffer, Image, Previous, State};
pub use image_view::{ImageStore, ImageView};
pub use kernel::{CpuKernel, KernelSource, WgslSource, Workgroup, Workgroups};
pub use kind::{Initial, Kind};
pub use null::NullBackend;
pub use port::{Access, Port};
pub use recorder::Recorder;
pub use schedule::{ImageShape, Output, Resource, ResourceId, Schedule, Usage};
pub use shader::ShaderCompiler;
pub use stage::{Stage, StageInfo, next_view};
pub use step::{Action, Binding, DispatchSize, DispatchStep, Hazard, HazardKind, Step, features};
pub use texel::{
    Float, ImageFormat, Rgba8Unorm, Rgba16Float, Rgba32Float, Sampled, Stored, Texel, Uint,
};
pub use view::{AtomicView, RawView, ReadView, WriteMap, WriteView};

pub use {bytemuck, glam};
