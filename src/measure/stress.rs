//! The talk's stress test: from an empty cache to converged (GIBS, "Stress Test Settings").
use super::{BlockMeans, FrameMeter, FrameRow};
use crate::compare::{CompareError, CompareOptions, compare};
use crate::picture::Picture;
use crate::{RenderError, Renderer};
use glam::Vec4;
use serde::Serialize;
use thiserror::Error;

/// Why a stress test stopped.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StressError {
    /// A frame could not be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A frame could not be compared with the truth.
    #[error(transparent)]
    Compare(#[from] CompareError),
}

/// One frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StressRow {
    /// What it cost and did.
    #[serde(flatten)]
    pub frame: FrameRow,
    /// Block error of indirect irradiance: against the truth, or against the last frame of the run where there is none.
    /// `None` where there is nothing to compare.
    pub error: Option<f64>,
    /// Mean relative error per pixel against the truth.
    pub mape: Option<f64>,
}

/// A run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stress {
    /// Groups of the frame's stages.
    pub groups: Vec<String>,
    /// A row for each frame.
    pub rows: Vec<StressRow>,
}

/// Runs a new renderer, or one that was reset, for so many frames; `each` is called after every one. The error is the block error of
/// [`Metrics`](crate::compare::Metrics), against the `truth` at the centres of its pixels, or else against the last frame,
/// which then has none.
///
/// # Errors
/// As [`Renderer::frame`], and of a truth as [`compare()`].
pub fn stress(
    renderer: &mut Renderer,
    frames: u32,
    truth: Option<&Picture>,
    mut each: impl FnMut(),
) -> Result<Stress, StressError> {
    let mut meter = FrameMeter::new(renderer);
    let mut rows = Vec::new();
    let mut blocks = Vec::new();
    for _ in 0..frames {
        let mut row = StressRow {
            frame: meter.frame(renderer)?,
            error: None,
            mape: None,
        };
        match truth {
            Some(truth) => {
                let metrics = against(renderer, truth)?;
                row.error = metrics.0.is_finite().then_some(metrics.0);
                row.mape = metrics.1.is_finite().then_some(metrics.1);
            }
            None => {
                let irradiance: Vec<Vec4> = renderer.output("irradiance")?;
                let width = renderer.gi().size()[0] as usize;
                blocks.push(BlockMeans::of(
                    &renderer.output("points")?,
                    &irradiance,
                    width,
                ));
            }
        }
        rows.push(row);
        each();
    }
    // Of itself, the last frame says nothing.
    if let Some((last, before)) = blocks.split_last() {
        for (row, blocks) in rows.iter_mut().zip(before) {
            row.error = blocks.error(last);
        }
    }
    Ok(Stress {
        groups: meter.groups(),
        rows,
    })
}

/// Block error and mean relative error per pixel of the last frame.
fn against(renderer: &mut Renderer, truth: &Picture) -> Result<(f64, f64), StressError> {
    let irradiance: Vec<Vec4> = renderer.output("irradiance")?;
    let [width, height] = renderer.gi().size();
    let mut ours = Picture::new(width, height);
    let plane = |c: usize| irradiance.iter().map(|e| e[c]).collect();
    ours.set_rgb("E", [0, 1, 2].map(plane))
        .map_err(RenderError::from)?;
    let options = CompareOptions {
        centers: true,
        ..CompareOptions::default()
    };
    let metrics = compare(&ours, truth, &options)?.metrics;
    Ok((metrics.block_error, metrics.mape))
}
