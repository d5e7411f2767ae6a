//! What reading a profile can fail with.
use super::FORMAT;
use crate::words::printable;
use std::path::PathBuf;
use thiserror::Error;

/// Why a profile cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ProfileError {
    /// The file cannot be read.
    #[error("the profile {} cannot be read: {source}; write one with `gibs profile SCENE --json`", path.display())]
    Read {
        /// File.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is no profile.
    #[error("the profile {} cannot be read: {source}; write one with `gibs profile SCENE --json`", path.display())]
    Parse {
        /// File.
        path: PathBuf,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// It is JSON of something else.
    #[error("{} is {found}, no profile; write one with `gibs profile SCENE --json`", path.display())]
    Other {
        /// File.
        path: PathBuf,
        /// What it is.
        found: &'static str,
    },
    /// It is of another version.
    #[error(
        "the profile {} has the format {found}, this program reads {FORMAT}; write it anew with `gibs profile SCENE --json`",
        path.display()
    )]
    Format {
        /// File.
        path: PathBuf,
        /// Its format.
        found: String,
    },
    /// It has nothing of any backend.
    #[error("the profile {} is empty; write it anew with `gibs profile SCENE --json`", path.display())]
    Empty {
        /// File.
        path: PathBuf,
    },
    /// It has a figure that nobody measured.
    #[error(
        "the profile {} has {found} for `{}`; write it anew with `gibs profile SCENE --json`",
        path.display(),
        printable(name)
    )]
    Figure {
        /// File.
        path: PathBuf,
        /// What the figure is of.
        name: String,
        /// What is wrong with it.
        found: String,
    },
    /// It has nothing of a backend.
    #[error("the profile {} has nothing of the backend {backend}, only of {}; measure one of these", path.display(), printable(&found.join(", ")))]
    Backend {
        /// File.
        path: PathBuf,
        /// Backend measured now.
        backend: String,
        /// Backends in the file.
        found: Vec<String>,
    },
}
