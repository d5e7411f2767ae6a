//! The frames: stages wired into graphs.
mod inputs;
mod reference;
mod settings;
mod surfels;
mod trace;

pub use reference::{ReferenceUpdate, gbuffer_frame, reference_frame, upload_reference};
pub use inputs::{FrameUpdate, SceneInputs, SceneSizes, upload_frame, upload_scene};
pub use settings::{Settings, SettingError, SettingInfo};
pub use surfels::{SurfelFrame, surfel_frame};
