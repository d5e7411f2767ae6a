//! Real-time global illumination with surfels (GIBS, SIGGRAPH 2021): one typed stage graph on wgpu, Vulkan and the
//! CPU.
//!
//! [`Gi`] is what an engine puts into its own frame; [`Renderer`] renders a [`gibs_passes::scene::Scene`] from a [`view::View`] on any [`gibs_graph::Backend`];
//! [`backends::open`] finds one. [`gltf_import::load`] and [`builtin::by_name`] make scenes.
pub mod backends;
pub mod builtin;
mod channels;
pub mod cli;
pub mod compare;
pub mod gi;
pub mod gltf_import;
pub mod picture;
mod query;
pub mod reference;
pub mod renderer;
pub mod view;

pub use gi::{Gi, HostImage};
pub use gibs_graph as graph;
pub use gibs_passes as passes;
pub use gibs_shaders as shaders;
pub use query::Irradiance;
pub use renderer::{RenderError, Renderer};

/// Compiles the program in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// Runs the programs in the guide to extending.
#[cfg(doctest)]
#[doc = include_str!("../docs/extending.md")]
struct Extending;

/// Runs the programs in the guide to embedding.
#[cfg(doctest)]
#[doc = include_str!("../docs/embedding.md")]
struct Embedding;
