//! A camera on its way through a scene.
use super::{CameraPath, FrameMeter, FrameRow, HoleRow, Holes};
use crate::{RenderError, Renderer};
use serde::Serialize;

/// One frame of a flight.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RoamRow {
    /// What it cost and did.
    #[serde(flatten)]
    pub frame: FrameRow,
    /// What it showed.
    #[serde(flatten)]
    pub holes: HoleRow,
}

/// Sends the camera of a new renderer, or of one that was reset, along a path; `each` is called after every frame. Gives the groups of the frame's
/// stages, and a row for each frame.
///
/// # Errors
/// As [`Renderer::frame`], and what `each` says.
pub fn roam<E: From<RenderError>>(
    renderer: &mut Renderer,
    path: &CameraPath,
    frames: u32,
    mut each: impl FnMut(&mut Renderer, &RoamRow) -> Result<(), E>,
) -> Result<(Vec<String>, Vec<RoamRow>), E> {
    let mut meter = FrameMeter::new(renderer);
    let mut holes = Holes::default();
    let mut rows = Vec::new();
    for frame in 0..frames {
        renderer.set_camera(path.camera(f64::from(frame)));
        let row = RoamRow {
            frame: meter.frame(renderer)?,
            holes: holes.frame(renderer)?,
        };
        each(renderer, &row)?;
        rows.push(row);
    }
    Ok((meter.groups(), rows))
}
