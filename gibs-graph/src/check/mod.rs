//! The cross-check kit: backends held against each other stage by stage, from equal inputs.
//!
//! [`check`] runs a frame in lockstep on several backends. Before each step all of them hold the same bytes; after it, what
//! the step wrote is read back from each, every pair is held to the port's [`Comparator`](crate::Comparator), and all go on
//! from what the first backend made, so that no difference is carried on. [`bisect`] finds where two backends that run on
//! their own part. Either writes a [`Capture`]: one stage with its inputs and outputs, which [`replay`] runs alone on any
//! backend, and [`reduce`] shrinks.
//!
//! # What is a difference
//! The comparator of a port says how far floats may be apart; integers may not. An element beyond that is *undecided* where
//! the first backend itself gives as different a value once its inputs are moved by one rounding: a threshold that is met by
//! chance, a difference of nearly equal numbers. Up to [`undecided_cap`] of the elements of a port may be. Everything else
//! differs.
mod bisect;
mod capture;
mod case;
mod compare;
mod condition;
mod contents;
mod error;
mod expectation;
mod isolate;
mod judge;
mod leaves;
mod lockstep;
mod near;
mod npz;
mod reduce;
mod replay;
mod report;
mod run;
mod untouched;

pub use bisect::{Parting, Way, bisect};
pub use capture::{Capture, CapturedBuffer, CapturedSize, Origin};
pub use case::{Case, Participant, Upload, UploadLog};
pub use compare::{Comparison, Difference, UNWRITTEN, apart, compare};
pub use condition::undecided_cap;
pub use error::{CaptureError, CheckError};
pub use expectation::{Expectation, Expectations};
pub use reduce::{Reduced, reduce};
pub use replay::{Replayed, replay, verify};
pub use report::{CaseReport, Gap, Lane, PairReport, PortReport, Report, StepReport, Verdict};
pub use run::{CheckOptions, Checked, check, record};
