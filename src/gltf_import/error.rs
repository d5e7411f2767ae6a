//! Why a file could not be imported.
use gibs_passes::scene::SceneDataError;
use std::path::{Path, PathBuf};

/// Why a glTF file could not be imported. The text names the file, the element, the value and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// A file could not be read.
    #[error("cannot read {}: {source}; check that the file is there and may be read", file.display())]
    Read {
        /// The glTF file or one that it refers to.
        file: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// The file is no glTF 2.0.
    #[error("{} is not a readable glTF 2.0 file: {problem}", file.display())]
    Format {
        /// The glTF file.
        file: PathBuf,
        /// What is wrong, and where.
        problem: String,
    },
    /// The file says that it makes no sense without extensions that are not supported.
    #[error("{} requires {names}, which gibs does not support; {remedy}", file.display())]
    Extensions {
        /// The glTF file.
        file: PathBuf,
        /// The extensions, separated by commas.
        names: String,
        /// What to do about them.
        remedy: String,
    },
    /// Parts of the file contradict each other.
    #[error("{}: {element}: {problem}", file.display())]
    Content {
        /// The glTF file.
        file: PathBuf,
        /// The part, by its place in the JSON.
        element: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The file is sound as glTF, but its numbers make no scene.
    #[error("{}: {source}", file.display())]
    Scene {
        /// The glTF file.
        file: PathBuf,
        /// What is wrong.
        source: SceneDataError,
    },
}

impl ImportError {
    /// An [`ImportError::Content`].
    pub(super) fn content(
        file: &Path,
        element: impl Into<String>,
        problem: impl Into<String>,
    ) -> Self {
        Self::Content {
            file: file.to_owned(),
            element: element.into(),
            problem: problem.into(),
        }
    }
}
