//! Why a picture could not be rendered.
use crate::picture::PictureError;
use gibs_graph::{BackendError, GraphErrors};
use gibs_passes::data::HostGbufferError;
use gibs_passes::device::DeviceSceneError;
use gibs_passes::frame::SettingError;
use gibs_passes::scene::SceneDataError;
use thiserror::Error;

/// Why a picture could not be rendered.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The scene breaks a promise of its types, or has no usable geometry.
    #[error("the scene `{scene}` cannot be traced: {source}")]
    Scene {
        /// Scene.
        scene: String,
        /// Why not.
        source: DeviceSceneError,
    },
    /// The camera, the sun or the sky of a view has a value that none can have.
    #[error("the view cannot be rendered: {source}")]
    View {
        /// What is wrong.
        source: SceneDataError,
    },
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The frame's graph is wrong.
    #[error(transparent)]
    Graph(#[from] GraphErrors),
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// A picture is too small or too large.
    #[error("the picture cannot be {width}x{height}: each side takes 1 to {most} pixels")]
    Size {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// Largest side.
        most: u32,
    },
    /// What is said of an engine's G-buffer does not fit the frame.
    #[error("{problem}; pass `Some` for Screen::Imported and `None` for Screen::Traced")]
    Host {
        /// What is wrong.
        problem: &'static str,
    },
    /// An executable is not the one that a [`Gi`](crate::gi::Gi) prepared everything for.
    #[error(
        "the executable runs another schedule than `Gi::schedule`; pass the one that was prepared from this `Gi`'s \
         schedule and that every change since then went through"
    )]
    Executable,
    /// More than lights changed.
    #[error(
        "the scene `{scene}` differs from what is lit in more than its lights: {difference}; call `set_scene`"
    )]
    Lights {
        /// Scene.
        scene: String,
        /// The first difference.
        difference: String,
    },
    /// There is nothing to read yet.
    #[error(
        "`{what}` cannot be read: no frame has run since the start or the last change; call `frame` first"
    )]
    NoFrame {
        /// The output asked for.
        what: String,
    },
    /// The frame draws no debug view.
    #[error("the frame draws no debug view; name one in the setting `debug`")]
    NoDebugView,
    /// An engine's G-buffer cannot be read as it is described.
    #[error(transparent)]
    Gbuffer(#[from] HostGbufferError),
    /// Irradiance cannot be asked for like this.
    #[error("irradiance of {points} points with {normals} normals: {problem}")]
    Queries {
        /// Points given.
        points: usize,
        /// Normals given.
        normals: usize,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A picture could not be made of the channels.
    #[error(transparent)]
    Picture(#[from] PictureError),
}
