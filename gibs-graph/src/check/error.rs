//! Why a check could not be made. That something differs is no error but a result.
use crate::BackendError;
use std::path::PathBuf;
use thiserror::Error;

/// Why backends could not be compared.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CheckError {
    /// There is nothing to compare with.
    #[error(
        "a check takes two backends or more, {found} found; name others, or install a driver for them"
    )]
    TooFew {
        /// Backends that took part.
        found: usize,
    },
    /// Two participants are one.
    #[error(
        "`{a}` and `{b}` are the same backend on the same device ({device}): comparing it with itself would say nothing; \
         leave one out"
    )]
    Same {
        /// One.
        a: String,
        /// The other.
        b: String,
        /// Their device.
        device: String,
    },
    /// A backend goes by the name of another.
    #[error("the backend called `{name}` says that it is `{backend}`; begin its name with that")]
    Mislabelled {
        /// Name that it takes part under.
        name: String,
        /// Name that it has.
        backend: String,
    },
    /// Transients of the frame share memory.
    #[error(
        "`{case}`: `{resource}` shares its memory, so that what a step wrote may be gone before it is read; call \
         `Graph::keep_transients` before compiling"
    )]
    Shared {
        /// Case.
        case: String,
        /// Resource.
        resource: String,
    },
    /// No step has the name that was asked for.
    #[error(
        "no step or stage that is checked has `{stage}` in its name{}; `gibs graph SCENE` lists those of a scene",
        or(near)
    )]
    NoStage {
        /// What was asked for.
        stage: String,
        /// Names that come near it.
        near: Vec<String>,
    },
    /// A backend failed while it was checked.
    #[error("`{case}`, frame {frame}, `{step}` on {backend}: {source}")]
    Backend {
        /// Case.
        case: String,
        /// Frame, from 0.
        frame: u32,
        /// Step, or what else was done.
        step: String,
        /// Participant.
        backend: String,
        /// What it said.
        source: Box<BackendError>,
    },
    /// What is fed to the frame could not be made.
    #[error("`{case}`, frame {frame}: {source}")]
    Feed {
        /// Case.
        case: String,
        /// Frame, from 0.
        frame: u32,
        /// Why not.
        source: Box<BackendError>,
    },
    /// A capture is not usable.
    #[error(transparent)]
    Capture(#[from] CaptureError),
    /// A list of expected differences is not usable.
    #[error("{file}: {problem}; see docs/checking.md")]
    Expectations {
        /// File.
        file: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
}

/// Why a capture cannot be written, read or run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CaptureError {
    /// The file cannot be opened or read.
    #[error(
        "{file} cannot be read: {source}; give a file that `gibs check --report` or `gibs bisect` has written, and that this \
         user may read"
    )]
    Read {
        /// File.
        file: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The file cannot be written.
    #[error(
        "{file} cannot be written: {source}; name a file in a folder that exists and that this user may write to"
    )]
    Write {
        /// File.
        file: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The file is a folder.
    #[error("{file} is a folder; name one of the captures in it, which end in .npz")]
    Folder {
        /// Folder.
        file: PathBuf,
    },
    /// The file is no capture.
    #[error(
        "{file} is no capture that this program can read: {problem}; write it anew with `gibs check` or `gibs bisect`"
    )]
    Format {
        /// File.
        file: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// The stage does not exist.
    #[error("no stage is called `{stage}`; pass the stages of the program that wrote the capture")]
    UnknownStage {
        /// Type name of the stage.
        stage: String,
    },
    /// The stage has changed since.
    #[error("stage `{stage}` is not as it was captured: {problem}; write the capture anew")]
    Changed {
        /// Type name of the stage.
        stage: String,
        /// What differs.
        problem: String,
    },
    /// The capture runs no kernel.
    #[error("step `{step}` runs no kernel, so there is nothing to capture")]
    NoKernel {
        /// Step.
        step: String,
    },
    /// A backend failed.
    #[error("`{stage}` on {backend}: {source}")]
    Backend {
        /// Label of the captured step.
        stage: String,
        /// Backend.
        backend: String,
        /// What it said.
        source: Box<BackendError>,
    },
}

/// Adds names to a sentence that says that there is none of the name that was asked for.
fn or(near: &[String]) -> String {
    match near {
        [] => String::new(),
        names => format!("; near it are `{}`", names.join("`, `")),
    }
}
