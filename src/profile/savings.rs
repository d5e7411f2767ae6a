//! What a frame saves by leaving out what its scene does not need.
use super::statistics::Interval;
use crate::statistics::quantile;
use crate::view::View;
use crate::{Gi, RenderError, Renderer};
use gibs_graph::{Backend, BackendError};
use gibs_passes::frame::Need;
use serde::Serialize;
use std::time::Instant;

/// A need of the frame, and what it costs or would cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Saving {
    /// The need, and what it adds or would add.
    #[serde(flatten)]
    pub need: Need,
    /// What it would add to a frame; `None` where that was not measured.
    pub time: Option<SavedTime>,
    /// Why not, where measuring was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_measured: Option<&'static str>,
}

/// What a need adds to a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SavedTime {
    /// Median frame without it, milliseconds.
    pub without_ms: f64,
    /// Milliseconds: what `ratio` adds to that.
    pub ms: f64,
    /// The frame with it over the frame without, in the geometric mean over pairs of frames.
    pub ratio: Interval,
}

/// What is saved by each need that is left out, and what each that is there costs. The time of those that are left out is
/// measured where `measure` says on which backend and over how many frames: after as many to warm up, in turns with the
/// frame as it is. What the scene does not have, such as a light, is then there without any power.
///
/// # Errors
/// [`RenderError`]; the backend refuses a frame, or fails.
pub fn savings(
    gi: &Gi,
    view: &View,
    measure: Option<(&dyn Backend, u32)>,
    mut progress: impl FnMut(u32, u32),
) -> Result<Vec<Saving>, RenderError> {
    let needs = gi.needs()?;
    let mut all: Vec<Saving> = needs
        .into_iter()
        .map(|need| Saving {
            need,
            time: None,
            not_measured: None,
        })
        .collect();
    let Some((backend, frames)) = measure.filter(|(_, frames)| *frames > 0) else {
        return Ok(all);
    };
    let left_out = all.iter().filter(|saving| !saving.need.present).count() as u32;
    let mut done = 0;
    for (saving, variant) in all.iter_mut().zip(gi.variants()) {
        if saving.need.present {
            continue;
        }
        saving.not_measured = unfaithful(backend, gi, variant.name);
        if saving.not_measured.is_some() {
            done += frames * 2;
            progress(done, left_out * frames * 2);
            continue;
        }
        let mut with = match Renderer::of(backend, gi.variant(&variant)?, view) {
            // The device does not have what it takes, or too little of it.
            Err(RenderError::Backend(
                BackendError::Refused { .. } | BackendError::Limit { .. },
            )) => {
                saving.not_measured = Some("the device does not have what it takes");
                done += frames * 2;
                progress(done, left_out * frames * 2);
                continue;
            }
            made => made?,
        };
        let mut without = Renderer::of(backend, gi.again()?, view)?;
        let mut times = [Vec::new(), Vec::new()];
        for frame in 0..frames * 2 {
            // The two take turns at being first.
            for turn in 0..2 {
                let which = (turn + frame) as usize % 2;
                let renderer = [&mut with, &mut without];
                let [with, without] = renderer;
                let renderer = if which == 0 { with } else { without };
                let start = Instant::now();
                renderer.frame()?;
                renderer.wait()?;
                if frame >= frames {
                    times[which].push(start.elapsed().as_secs_f64() * 1e3);
                }
            }
            done += 1;
            progress(done, left_out * frames * 2);
        }
        let [with, without] = times;
        let usual = quantile(&without, 0.5).unwrap_or_default();
        let ratio = Interval::of_pairs(with.into_iter().zip(without));
        saving.time = Some(SavedTime {
            without_ms: usual,
            ms: usual * (ratio.ratio - 1.0),
            ratio,
        });
    }
    Ok(all)
}

/// Why the frame with a need would not tell what the need costs.
fn unfaithful(backend: &dyn Backend, gi: &Gi, need: &str) -> Option<&'static str> {
    match need {
        // The CPU backend takes a frame with ray queries, and traces in software.
        "ray queries" if !backend.device().ray_query => Some("the device has no ray queries"),
        // A third of the rays would go to an emitter without power, and end where they begin.
        "emitter sampling" if gi.scene().emitters.power <= 0.0 => {
            Some("without emitters its rays are not traced, so that the frame gets shorter by it")
        }
        _ => None,
    }
}
