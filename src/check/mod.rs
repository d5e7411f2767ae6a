//! Backends held against each other on frames of this crate.
//!
//! [`gibs_graph::check`](crate::graph::check) is the kit, for any graph and any backend. Here are the frames to run it on:
//! [`cases`] makes them of a scene. Any `impl Backend` can take part:
//!
//! ```no_run
//! use gibs::check::{Plan, cases, check};
//! use gibs::graph::check::{CheckOptions, Participant, Verdict};
//! use gibs::{backends, builtin};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let oracle = backends::open(backends::Choice::Cpu)?;
//! let mine = backends::open(backends::Choice::Vulkan)?; // or a backend of your own
//! let scene = builtin::by_name("cornell").ok_or("no such scene")?;
//! let mut cases = cases(&[("cornell", &scene)], &Plan::default(), oracle.as_ref())?;
//! let participants = [Participant::new(oracle.as_ref()), Participant::new(mine.as_ref())];
//! let checked = check(&mut cases, &participants, &CheckOptions::default(), |_, _, _| {})?;
//! assert!(checked.report.gaps(&cases, &participants).is_empty());
//! assert!(checked.report.verdict() < Verdict::Differs);
//! # Ok(())
//! # }
//! ```
mod cases;
mod html;
mod summary;
mod table;

pub use cases::{Plan, cases, surfels};
pub use gibs_graph::check::*;
pub use html::html;
pub(crate) use summary::word;
pub use summary::{NotRun, Summary};
pub use table::{Row, Worst};
