//! What was measured of one configuration.
use super::{Mean, Spread};
use crate::compare::Metrics;
use serde::Serialize;

/// How wrong a configuration is after so many frames, and what they took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct After {
    /// Frames from an empty cache.
    pub frames: u32,
    /// Whether these frames were asked for; else they are there for the plot.
    pub asked: bool,
    /// Errors of indirect irradiance, as of [`crate::compare::Metrics`].
    pub errors: Errors,
    /// The MAPE over that of the first configuration with the same seed.
    pub mape_ratio: Mean,
    /// Rays whose closest hit was sought, a frame, in the mean: of surfels and of paths that go on, or segments of traced
    /// paths. Without those to primary surfaces, which are the same everywhere, and without shadow rays.
    pub rays: f64,
    /// These rays of all frames so far, in the mean over seeds.
    pub total_rays: f64,
    /// Median time of a frame, milliseconds.
    pub milliseconds: f64,
    /// Time of all frames so far, seconds.
    pub seconds: Mean,
    /// The frame's time over that of the first configuration.
    pub ratio: Spread,
    /// Of path tracing: what it took of the rays or of the time that it was to equal, with the seed that missed it by most.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub taken: Option<f64>,
    /// Whether nothing in the scene, on the backend, has a smaller MAPE in no more seconds, or the same in fewer.
    pub pareto: bool,
}

/// Errors of indirect irradiance per pixel, over seeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "as the fields of `crate::compare::Metrics`")]
pub struct Errors {
    pub rel_mse: Mean,
    pub mape: Mean,
    pub bias: Mean,
    pub p99: Mean,
    pub flip: Mean,
}

impl Errors {
    /// Over seeds.
    pub(super) fn of(metrics: impl Iterator<Item = Metrics>) -> Self {
        let all: Vec<Metrics> = metrics.collect();
        let mean = |of: fn(&Metrics) -> f64| Mean::of(all.iter().map(of));
        Self {
            rel_mse: mean(|m| m.rel_mse),
            mape: mean(|m| m.mape),
            bias: mean(|m| m.bias),
            p99: mean(|m| m.p99),
            flip: mean(|m| m.flip),
        }
    }
}

/// What a row is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Surfels with some settings.
    Settings,
    /// Surfels with an element of the technique switched.
    Element,
    /// Path tracing with the rays of the first row.
    EqualRays,
    /// Path tracing in the time of the first row.
    EqualTime,
}

/// One configuration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name.
    pub name: String,
    /// What is different, in words.
    pub about: String,
    /// What it is of.
    pub kind: Kind,
    /// Errors and times, by rising frames: those asked for, and powers of two up to the last one.
    pub after: Vec<After>,
}
