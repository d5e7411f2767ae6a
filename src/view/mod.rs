//! A view: what a picture of a scene needs beside the scene. Camera, size, sun, sky, and the moment of its clips.
//!
//! View files are JSON; [`View::load`] reads them and [`View::to_json`] writes them. Without a file,
//! [`View::framing`] finds a view that shows the scene.
mod environment;
mod framing;
mod json;
#[cfg(test)]
mod tests;

pub(crate) use environment::load as load_environment;

use gibs_passes::scene::{Camera, Environment, Sun};
use std::path::PathBuf;

/// Width and height of a picture where nothing asks for others, pixels.
pub const DEFAULT_RESOLUTION: [u32; 2] = [1280, 720];

/// Largest width or height that a view may ask for, pixels.
pub const MAX_RESOLUTION: u32 = 8192;

/// How a scene is seen and lit from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The scene file that the view was made for, if it names one.
    pub scene: Option<PathBuf>,
    /// Where the picture is taken from.
    pub camera: Camera,
    /// Width and height, pixels, each at least 1.
    pub resolution: [u32; 2],
    /// The sun, if it shines.
    pub sun: Option<Sun>,
    /// What rays see that leave the scene.
    pub environment: Environment,
    /// Clips that pose the scene: `(index into Scene::animations, seconds)`, applied in order.
    pub animation: Vec<(usize, f64)>,
    /// Factor on radiance for display only; above zero.
    pub exposure: f32,
    /// What was put right or made up on the way to this view, one sentence each.
    pub warnings: Vec<String>,
}

/// Why a view could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// A file could not be opened or read.
    #[error("cannot read {}: {source}; check that the path is right and that the file may be read", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not JSON, lacks a field, or has a field of the wrong kind or of an unknown name.
    #[error("{} is not a view: {source}; correct that line of the file", file.display())]
    Format {
        /// The view file.
        file: PathBuf,
        /// What is wrong, and at which line and column.
        source: serde_json::Error,
    },
    /// A field has a value that no view can have.
    #[error("{}: `{field}` is {value}: {remedy}", file.display())]
    Field {
        /// The view file.
        file: PathBuf,
        /// The field, with its parents, as in `camera.position`.
        field: &'static str,
        /// Its value.
        value: String,
        /// What to write instead.
        remedy: String,
    },
    /// An environment map could not be used.
    #[error("environment map {}: {problem}; {remedy}", file.display())]
    Environment {
        /// The image file.
        file: PathBuf,
        /// What is wrong with it.
        problem: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// The view holds something that a view file cannot.
    #[error("this view cannot be written: {field} is {value}; {remedy}")]
    Unwritable {
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// What to do about it.
        remedy: &'static str,
    },
}

impl View {
    /// What a camera sees, without sun or sky.
    pub fn of(camera: Camera) -> Self {
        Self {
            scene: None,
            camera,
            resolution: DEFAULT_RESOLUTION,
            sun: None,
            environment: Environment::default(),
            animation: Vec::new(),
            exposure: 1.0,
            warnings: Vec::new(),
        }
    }
}
