//! What measuring can fail with.
use crate::RenderError;
use crate::compare::CompareError;
use crate::picture::PictureError;
use crate::words::counted;
use std::path::PathBuf;
use thiserror::Error;

/// Why the elements could not be measured.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BenchError {
    /// A frame, or the truth.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The truth could not be read.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// Nothing can be compared with the truth.
    #[error("{of}: {source}")]
    Truth {
        /// The truth's file, or the scene that it was path-traced of.
        of: String,
        /// Why not.
        source: CompareError,
    },
    /// A picture could not be compared with the truth.
    #[error("{configuration} after {} against the truth: {source}", counted(*frames, "frame"))]
    Compare {
        /// Configuration.
        configuration: String,
        /// Frames.
        frames: u32,
        /// Why not.
        source: CompareError,
    },
    /// A picture is broken.
    #[error(
        "{configuration} after {}: {} of E NaN or infinite; please report this with the command line",
        counted(*frames, "frame"), counted(*count as u64, "pixel")
    )]
    NotFinite {
        /// Configuration.
        configuration: String,
        /// Frames.
        frames: u32,
        /// Pixels.
        count: usize,
    },
    /// The truth does not have a pixel for so many of the picture's.
    #[error(
        "the truth {} has {}x{} pixels, the picture {}x{}: the picture's sides must be the truth's times one odd \
         whole number, so that the truth's pixels have their centres in the picture; choose another --size",
        path.display(), truth[0], truth[1], size[0], size[1]
    )]
    TruthSize {
        /// The truth.
        path: PathBuf,
        /// Its width and height.
        truth: [u32; 2],
        /// Width and height of the picture.
        size: [u32; 2],
    },
}
