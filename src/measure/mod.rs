//! Measurements over many frames: what each costs and does, how soon the light has converged, and whether a camera that
//! moves sees holes.
//!
//! [`stress`] is the talk's stress test, from an empty cache to converged; [`roam`] sends the camera along a
//! [`CameraPath`]. Both are commands of the program.
mod convergence;
mod frame;
mod holes;
mod path;
mod report;
mod roam;
mod stress;
#[cfg(test)]
mod tests;

pub use convergence::{BlockMeans, converged_from};
pub use frame::{FrameMeter, FrameRow};
pub use holes::{COVERED, HoleRow, Holes, SETTLES};
pub use path::{CameraPath, MOST_FRAME, PathError};
pub use report::{csv, group_plot, or_empty, plot_of};
pub use roam::{RoamRow, roam};
pub use stress::{Stress, StressError, StressRow, stress};
