//! The frames: stages wired into graphs.
mod elements;
mod inputs;
mod needs;
mod probes;
mod reference;
mod settings;
mod surfels;
mod trace;

pub use crate::shared::debug::{DebugScale, DebugView, UnknownDebugView};
pub use elements::{ELEMENTS, TechniqueElement};
pub use inputs::{
    FrameUpdate, SceneInputs, SceneSizes, pixel_angle, upload, upload_frame, upload_scene,
    upload_scene_where,
};
pub use needs::{Need, Variant, needs, variants};
pub use probes::{MOST_PLACES, ProbeFrame, probe_frame, upload_probe_frame, upload_probes};
pub use reference::{ReferenceUpdate, gbuffer_frame, reference_frame, upload_reference};
pub use settings::{SettingError, SettingInfo, Settings};
pub use surfels::{Light, Screen, SurfelFrame, SurfelOutputs, surfel_frame};
