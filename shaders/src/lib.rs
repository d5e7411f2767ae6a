//! The WGSL kernels of gibs, and the tools that make them fit for devices.
//!
//! [`stages`] has one kernel per file in `stages/`, and [`MODULES`] the modules in `modules/` that they import. Adding a
//! file is enough; the build script finds and validates it. [`compose`] makes one plain WGSL text of a kernel and its
//! modules.
//!
//! With the feature `compiler`, [`Compiler`] composes and validates kernels of any origin with naga, gives WGSL and
//! SPIR-V, and holds a kernel against the ports of its stage when a graph is compiled.
//!
//! Conventions: a kernel has one entry point, `@compute fn main`. Its bindings are dense from 0 in group 0. Each
//! port of the stage is a global of the same name; where that is a reserved word of WGSL, an underscore follows
//! (`target_`).
pub mod compose;

#[cfg(feature = "compiler")]
mod check;
#[cfg(feature = "compiler")]
mod compiler;
#[cfg(feature = "compiler")]
mod error;
#[cfg(feature = "compiler")]
mod layout;
#[cfg(feature = "compiler")]
mod names;
#[cfg(feature = "compiler")]
mod parallel;
#[cfg(feature = "compiler")]
mod reflect;
#[cfg(feature = "compiler")]
mod validate;

#[cfg(feature = "compiler")]
pub use compiler::{CompiledKernel, Compiler, SPIRV};
#[cfg(feature = "compiler")]
pub use error::ShaderError;
#[cfg(feature = "compiler")]
pub use parallel::on_all_cores;
#[cfg(feature = "compiler")]
pub use validate::WgslError;

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
