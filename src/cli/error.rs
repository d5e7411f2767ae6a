//! What a command can fail with.
use crate::RenderError;
use crate::backends::UnknownBackend;
use crate::bench::BenchError;
use crate::check::{CaptureError, CheckError};
use crate::cli::compare::CompareCommandError;
use crate::cli::output::warning;
use crate::compare::CompareError;
use crate::gltf_import::ImportError;
use crate::measure::{PathError, StressError};
use crate::picture::{PictureError, WriteError};
use crate::profile::ProfileError;
use crate::view::ViewError;
use gibs_graph::BackendError;
use gibs_passes::frame::SettingError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a command did not succeed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CommandError {
    /// Comparing.
    #[error(transparent)]
    Compare(Box<CompareCommandError>),
    /// Reading a scene.
    #[error(transparent)]
    Scene(#[from] ImportError),
    /// Reading a view.
    #[error(transparent)]
    View(#[from] ViewError),
    /// A picture file.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// Writing a file.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Rendering.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Measuring the elements of the technique.
    #[error(transparent)]
    Bench(#[from] BenchError),
    /// A backend.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// A backend's name.
    #[error(transparent)]
    Name(#[from] UnknownBackend),
    /// A setting.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A settings file.
    #[error("the settings file {} cannot be used: {message}; it is TOML with the keys that `gibs settings` lists", path.display())]
    SettingsFile {
        /// File.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// Two options that decide about one setting.
    #[error("`--set {key}=..` and `{option}` both decide about `{key}`; give one of them")]
    SetTwice {
        /// Setting.
        key: String,
        /// The other option.
        option: String,
    },
    /// An option's value.
    #[error("{option} cannot be `{value}`: {want}")]
    Value {
        /// Option.
        option: &'static str,
        /// Value given.
        value: String,
        /// What it takes.
        want: String,
    },
    /// Neither a file nor a built-in scene.
    #[error("there is no scene `{name}`: give the path of a .gltf or .glb file, or one of {names}")]
    NoScene {
        /// What was given.
        name: String,
        /// Built-in scenes.
        names: String,
    },
    /// Neither a file nor a built-in environment.
    #[error(
        "there is no environment `{name}`: give the path of a .hdr or .exr map, or one of {names}"
    )]
    NoEnvironment {
        /// What was given.
        name: String,
        /// Built-in environments.
        names: String,
    },
    /// Reading a camera path.
    #[error(transparent)]
    Path(#[from] PathError),
    /// Reading a profile.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// A stress test.
    #[error(transparent)]
    Stress(#[from] StressError),
    /// A truth that frames cannot be compared with.
    #[error("the frames against {}: {source}", truth.display())]
    Truth {
        /// The truth.
        truth: PathBuf,
        /// Why not.
        source: CompareError,
    },
    /// The truth is of something else.
    #[error(
        "--truth {}: {elsewhere} of {of} pixels show another surface than the scene does; give a truth of this scene and view",
        truth.display()
    )]
    OtherTruth {
        /// The truth.
        truth: PathBuf,
        /// Pixels that show another surface.
        elsewhere: usize,
        /// Of how many that are compared.
        of: usize,
    },
    /// Surfels lost slots or shared them.
    #[error(
        "{errors} slots were lost or given twice, summed over the frames; please report this with the command line"
    )]
    Slots {
        /// Slots, in every frame that they were wrong in.
        errors: u64,
    },
    /// Standard output takes no more.
    #[error("the result could not be printed: {source}; check where standard output goes")]
    Output {
        /// What the system said.
        source: std::io::Error,
    },
    /// Backends differ, or the check is not what it should be.
    #[error(
        "the check failed: {differences} differences, {gaps} places that were not looked at, {unmet} expected differences \
         that did not come"
    )]
    Check {
        /// Ports at which a pair of backends differs.
        differences: usize,
        /// Places that the check did not look at.
        gaps: usize,
        /// Expected differences that did not come.
        unmet: usize,
    },
    /// Two backends part.
    #[error("{a} and {b} part")]
    Parted {
        /// One.
        a: &'static str,
        /// The other.
        b: &'static str,
    },
    /// Equal words are asked for, and one of the two that would run them is not.
    #[error("--same-spirv compares vulkan with wgpu; name both in --backends, or none")]
    SameWordsOfOne,
    /// Two backends differ on a capture, and on the smaller one that was made of it.
    #[error("`{stage}` on {backend} differs from {other}; {} is the smaller capture that shows it", file.display())]
    Reduced {
        /// Stage.
        stage: String,
        /// Backend.
        backend: &'static str,
        /// The other.
        other: &'static str,
        /// The smaller capture.
        file: PathBuf,
    },
    /// A capture would be written over by what is made of it.
    #[error("{} is the capture itself; give --reduce another file", file.display())]
    ReducedOntoItself {
        /// Capture.
        file: PathBuf,
    },
    /// A replayed stage gives something else than it did.
    #[error(
        "`{stage}` on {backend} differs from what {oracle} made of it, the first participant of the capture"
    )]
    Replay {
        /// Stage.
        stage: String,
        /// Backend.
        backend: &'static str,
        /// First participant of the capture.
        oracle: String,
    },
    /// A replayed stage changed what it only reads.
    #[error("`{stage}` on {backend} changed what it only reads: {}", buffers.join(", "))]
    Scribbled {
        /// Stage.
        stage: String,
        /// Backend.
        backend: &'static str,
        /// Buffers.
        buffers: Vec<String>,
    },
    /// There is no difference to keep.
    #[error("{}: {a} and {b} agree on it, so there is nothing to reduce; name the two that differ", capture.display())]
    NothingToReduce {
        /// Capture.
        capture: PathBuf,
        /// One backend.
        a: &'static str,
        /// The other.
        b: &'static str,
    },
    /// A capture of a stage that this program does not have.
    #[error(
        "{} is a capture of the stage `{stage}`, which this program does not have; replay it with the program that wrote it, \
         or write one anew with `gibs check --report DIR --capture NAME`", capture.display()
    )]
    NoSuchStage {
        /// Capture.
        capture: PathBuf,
        /// Type name of its stage.
        stage: String,
    },
    /// A capture of a stage that has other ports now.
    #[error(
        "{} is a capture of `{stage}`, which is not as it was captured: {problem}; replay it with the program that wrote it, \
         or write it anew with `gibs check --report DIR --capture {stage}`", capture.display()
    )]
    StageChanged {
        /// Capture.
        capture: PathBuf,
        /// Type name of its stage.
        stage: String,
        /// What differs.
        problem: String,
    },
    /// A capture without results.
    #[error(
        "{} holds no results to compare with, so nothing was checked; write one that does with `gibs check --report DIR --capture {stage}`",
        capture.display()
    )]
    NoResults {
        /// Capture.
        capture: PathBuf,
        /// Type name of its stage.
        stage: String,
    },
    /// A check could not be made.
    #[error(transparent)]
    CheckKit(#[from] CheckError),
    /// A capture.
    #[error(transparent)]
    Capture(#[from] CaptureError),
    /// Output that is not a number.
    #[error(
        "{count} of {pixels} pixels of the picture are not finite; please report this with the command line"
    )]
    NonFinite {
        /// Pixels.
        count: usize,
        /// All pixels.
        pixels: usize,
    },
}

impl From<CompareCommandError> for CommandError {
    fn from(error: CompareCommandError) -> Self {
        Self::Compare(Box::new(error))
    }
}

impl CommandError {
    /// 1 where a check failed, 2 for bad usage or bad input.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Compare(error) => error.exit_code(),
            Self::NonFinite { .. }
            | Self::Slots { .. }
            | Self::Check { .. }
            | Self::Parted { .. }
            | Self::Replay { .. }
            | Self::Scribbled { .. }
            | Self::Reduced { .. }
            | Self::Bench(BenchError::NotFinite { .. }) => 1,
            _ => 2,
        }
    }
}

/// What failed of several things that were tried one after the other.
#[derive(Debug, Default)]
pub(super) struct Failures(Option<CommandError>);

impl Failures {
    /// Keeps the first; a warning tells of any other.
    pub fn add(&mut self, error: CommandError) {
        match &self.0 {
            None => self.0 = Some(error),
            Some(_) => warning!("{error}"),
        }
    }

    /// The first.
    pub fn first(self) -> Result<(), CommandError> {
        self.0.map_or(Ok(()), Err)
    }
}
