//! What a scene and its settings need of the frame, and what that costs: a frame has stages and buffers for its needs
//! only.
use super::{SceneSizes, SurfelFrame, surfel_frame};
use gibs_graph::{Graph, GraphErrors, Schedule};
use serde::Serialize;
use std::collections::BTreeSet;

/// One thing that a frame may have to do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Need {
    /// What it is.
    pub name: &'static str,
    /// The frame has it.
    pub present: bool,
    /// Where it comes from.
    pub reason: String,
    /// Stages that it adds, or would add.
    pub stages: Vec<String>,
    /// Bytes of device memory that it adds, or would add; negative where memory is shared better with it.
    pub bytes: i64,
}

/// The needs of a frame, found by recording it once more without each of them, or with it.
///
/// # Errors
/// As [`Graph::compile`].
pub fn needs(frame: &SurfelFrame, sizes: &SceneSizes) -> Result<Vec<Need>, GraphErrors> {
    let here = record(frame, sizes)?;
    let settings = &frame.settings;
    let lights = sizes.lights();
    let lit = sizes.with_lights(if lights > 0 { 0 } else { 1 });
    let mut other_paths = frame.clone();
    other_paths.settings.continuations = if settings.continuations > 0 { 0 } else { 8 };
    let mut other_queries = frame.clone();
    other_queries.settings.queries = if settings.queries > 0 { 0 } else { 1024 };
    let counted = |count: u64, what: &str| match count {
        0 => format!("no {what}"),
        1 => format!("1 {what}"),
        n => format!("{n} {what}s"),
    };
    Ok(vec![
        need(
            "direct light",
            lights > 0,
            counted(lights, "light of the scene or the view"),
            &here,
            &record(frame, &lit)?,
        ),
        need(
            "paths beyond a hit",
            settings.continuations > 0,
            format!("the setting continuations = {}", settings.continuations),
            &here,
            &record(&other_paths, sizes)?,
        ),
        need(
            "irradiance at points",
            settings.queries > 0,
            format!("the setting queries = {}", settings.queries),
            &here,
            &record(&other_queries, sizes)?,
        ),
    ])
}

fn record(frame: &SurfelFrame, sizes: &SceneSizes) -> Result<Schedule, GraphErrors> {
    let mut g = Graph::new("surfels");
    surfel_frame(&mut g, frame, sizes);
    g.compile(None)
}

fn need(
    name: &'static str,
    present: bool,
    reason: String,
    here: &Schedule,
    other: &Schedule,
) -> Need {
    let (with, without) = if present {
        (here, other)
    } else {
        (other, here)
    };
    let labels = |schedule: &Schedule| -> BTreeSet<String> {
        let steps = schedule.dispatches();
        steps.map(|(_, step, _)| step.label.clone()).collect()
    };
    let left_out = labels(without);
    let stages = with
        .dispatches()
        .map(|(_, step, _)| step.label.clone())
        .filter(|label| !left_out.contains(label))
        .collect();
    Need {
        name,
        present,
        reason,
        stages,
        bytes: with.bytes(false) as i64 - without.bytes(false) as i64,
    }
}
