//! What each element of the technique gains and costs: error and time with it and without, at equal budgets of rays, beside path
//! tracing with as many rays.
mod baseline;
mod configuration;
mod error;
mod frames;
mod report;
mod statistics;
#[cfg(test)]
mod tests;
mod truth;

pub use configuration::{Configuration, configurations};
pub use error::BenchError;
pub use report::{csv, plot, table};
pub use statistics::{Mean, Spread};
pub use truth::{TRUTH_STEPS, Truth};

use crate::view::View;
use baseline::{BASELINES, Budget, trace_paths};
use frames::{Run, run};
use gibs_graph::Backend;
use gibs_passes::scene::Scene;
use serde::Serialize;

/// What to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// What to compare; the first is what times are held against and whose rays path tracing gets.
    pub configurations: Vec<Configuration>,
    /// Frames after which errors are reported, each at least 1.
    pub frames: Vec<u32>,
    /// Independent repetitions, at least 1.
    pub seeds: u32,
}

/// How wrong a configuration is after so many frames, and what they took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct After {
    /// Frames from an empty cache.
    pub frames: u32,
    /// Whether these frames were asked for; else they are there for the plot.
    pub asked: bool,
    /// Errors of indirect irradiance, as of [`crate::compare::Metrics`].
    pub errors: Errors,
    /// Rays whose closest hit was sought, a frame, in the mean: of surfels and of paths that go on, or segments of traced
    /// paths. Without those to primary surfaces, which are the same everywhere, and without shadow rays.
    pub rays: f64,
    /// Median time of a frame, milliseconds.
    pub milliseconds: f64,
    /// The frame's time over that of the first configuration.
    pub ratio: Spread,
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

/// One configuration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name.
    pub name: String,
    /// What is different, in words.
    pub about: String,
    /// Errors and times, by rising frames: those asked for, and powers of two up to the last one.
    pub after: Vec<After>,
}

/// The frames after which errors are measured, and whether they were asked for: those, and powers of two up to the largest.
fn checkpoints(asked: &[u32]) -> Vec<(u32, bool)> {
    let last = asked.iter().copied().max().unwrap_or(1).max(1);
    let powers = (0..32).map(|n| 1 << n).take_while(|power| *power < last);
    let mut all: Vec<u32> = powers.chain(asked.iter().copied()).collect();
    all.sort_unstable();
    all.dedup();
    all.into_iter()
        .map(|frames| (frames, asked.contains(&frames)))
        .collect()
}

/// Frames that [`measure`] renders, for a bar of progress.
pub fn work(options: &Options) -> u64 {
    let last = options.frames.iter().copied().max().unwrap_or(0);
    u64::from(last) * options.configurations.len() as u64 * u64::from(options.seeds)
}

/// Measures all configurations, and path tracing with the rays of the first one, in two ways. The configurations take turns frame by frame, so
/// that whatever else the machine does falls on all of them. `progress` hears of every frame.
///
/// # Errors
/// [`BenchError`].
pub fn measure(
    backend: &dyn Backend,
    scene: &Scene,
    view: &View,
    truth: &Truth,
    options: &Options,
    mut progress: impl FnMut(),
) -> Result<Vec<Row>, BenchError> {
    let checkpoints = checkpoints(&options.frames);
    let mut runs: Vec<Vec<Run>> = vec![Vec::new(); options.configurations.len()];
    let mut traced = BASELINES.map(|_| Vec::new());
    for seed in 0..options.seeds {
        let job = frames::Job {
            backend,
            scene,
            view,
            truth,
            size: options.size,
            checkpoints: &checkpoints,
            seed,
        };
        let of_seed = run(&job, &options.configurations, &mut progress)?;
        if let Some(first) = of_seed.first() {
            let budgets = checkpoints.iter().map(|&(frames, asked)| Budget {
                frames,
                asked,
                rays: first.rays(frames),
                seconds: first.seconds(frames),
            });
            for (baseline, traced) in BASELINES.iter().zip(&mut traced) {
                traced.push(trace_paths(baseline, &job, budgets.clone())?);
            }
        }
        for (all, run) in runs.iter_mut().zip(of_seed) {
            all.push(run);
        }
    }
    let mut rows = Vec::new();
    for (configuration, own) in options.configurations.iter().zip(&runs) {
        let after = checkpoints.iter().map(|&(frames, asked)| After {
            frames,
            asked,
            errors: Errors::of(own.iter().filter_map(|run| run.errors(frames))),
            rays: Mean::of(own.iter().map(|run| run.rays(frames))).mean / f64::from(frames),
            milliseconds: Spread::of(own.iter().flat_map(|run| run.times(frames))).median * 1e3,
            ratio: Spread::of(
                own.iter()
                    .zip(&runs[0])
                    .flat_map(|(run, first)| run.ratios(first, frames)),
            ),
        });
        rows.push(Row {
            name: configuration.name.clone(),
            about: configuration.about.clone(),
            after: after.collect(),
        });
    }
    let baselines = BASELINES.iter().zip(&traced);
    rows.extend(baselines.filter_map(|(each, traced)| baseline::row(each, &checkpoints, traced)));
    Ok(rows)
}
