//! Why a scene cannot be brought to a device.
use crate::accel::BuildError;
use crate::scene::SceneDataError;
use thiserror::Error;

/// What is wrong with what a [`super::DeviceScene`] is to be made from.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum DeviceSceneError {
    /// The scene breaks a promise of its types.
    #[error(transparent)]
    Scene(SceneDataError),
    /// The sun, the sky or the place to look from has a value that none can have.
    #[error(transparent)]
    View(SceneDataError),
    /// The pose is of another scene.
    #[error(
        "the pose has {found} transforms for {expected} nodes; make it with `Scene::pose` of the same scene"
    )]
    Pose {
        /// Transforms in the pose.
        found: usize,
        /// Nodes of the scene.
        expected: usize,
    },
    /// No tree can be built from the geometry.
    #[error(transparent)]
    Geometry(#[from] BuildError),
}
