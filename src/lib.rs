//! Real-time global illumination with surfels (GIBS, SIGGRAPH 2021): one typed stage graph on wgpu, Vulkan and the
//! CPU.
//!
//! [`Gi`] is what an engine puts into its own frame; [`Renderer`] renders a [`passes::scene::Scene`] from a
//! [`view::View`] on any [`graph::Backend`]; [`backends::open`] finds one. [`gltf_import::load`] and [`builtin::by_name`]
//! make scenes, [`mod@reference`] path-traces ground truth, [`compare`] measures pictures against each other.
//!
//! # Units and coordinates
//! - One unit of length is a metre as far as defaults go. Light has no scale of its own: all of it times a power of two
//!   gives exactly that much more.
//! - Coordinates are right-handed. There is no up axis but the camera's, and glTF's +Y in files. Angles are in radians,
//!   except where a file format or a command says degrees.
//! - Positions of the host are `f64`. Devices work in `f32`, relative to a *floating origin* near the camera, a multiple
//!   of 16 m along each axis; what comes back from [`Gi`] and [`Renderer`] as a position of the scene is `f64` again.
//! - Colours are linear RGB with Rec. 709 primaries. Irradiance is in W/m^2, radiance in W/(m^2 sr), the sun in W/m^2 at
//!   normal incidence. Only a PNG has exposure and a curve.
//! - Pictures go row by row from the top left.
//!
//! # Determinism
//! The same scene, view, settings, size, seed and sequence of calls give the same bits on one backend and device, whatever
//! the number of threads. Between backends results differ by rounding alone, since WGSL leaves some of it open; pictures
//! agree far closer than two seeds do. No random source of the system is read, and no clock but by [`mod@bench`].
//!
//! # Threads
//! [`Renderer`], [`Gi`] and executables are `Send`: make them on one thread and use them on another. Calls take `&mut
//! self` and happen one after another. Backends are `Send` and `Sync`, and any number of executables may run on one at a
//! time; those of a device share its queue. The CPU backend has a thread pool of its own, and [`Gi`] builds trees on
//! rayon's.
//!
//! # Errors
//! Files, settings, sizes and devices give errors that name the value and the remedy, and no panics. After an error of
//! a call that changes something, things are as they were, unless the device itself failed.
//!
//! # What is stable
//! Versions follow Cargo's reading of semantic versions: before 1.0, a minor version may change any item, a patch none. Not
//! covered are the names and layouts of buffers and stages within a frame, the text of messages, which bits of a picture
//! stay the same between versions, and what the documentation hides. Enums and structs that are `#[non_exhaustive]` grow.
//! Of the program, the keys of settings and JSON, exit codes and channel names count as items. [`cli`] is the program
//! itself, and no interface.
#![warn(missing_docs)]
pub mod backends;
pub mod bench;
pub mod builtin;
mod channels;
pub mod check;
pub mod cli;
pub mod compare;
mod conditions;
mod counters;
pub mod debug;
mod files;
pub mod gi;
pub mod gltf_import;
pub mod guiding;
mod html;
pub mod measure;
pub mod picture;
pub mod plot;
pub mod profile;
mod query;
pub mod reference;
pub mod renderer;
mod stages;
mod statistics;
pub mod view;
mod words;

pub use counters::{Clamped, Counters};
pub use debug::DebugPicture;
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

/// Runs the program in the guide to debugging.
#[cfg(doctest)]
#[doc = include_str!("../docs/debugging.md")]
struct Debugging;

/// Runs the programs in the guide to embedding.
#[cfg(doctest)]
#[doc = include_str!("../docs/embedding.md")]
struct Embedding;
