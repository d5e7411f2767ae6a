//! Path tracing with as many rays as surfels had.
use super::frames::Job;
use super::{After, BenchError, Errors, Mean, Row, Spread};
use crate::compare::Metrics;
use crate::reference::{ReferenceOptions, reference};
use std::time::Instant;

/// What the first configuration had up to a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    pub frames: u32,
    pub asked: bool,
    pub rays: f64,
    pub seconds: f64,
}

/// What path tracing did with it.
#[derive(Clone, Debug)]
pub(super) struct Traced {
    frames: u32,
    errors: Metrics,
    rays: f64,
    seconds: f64,
    /// Seconds over those of the surfels.
    ratio: f64,
}

/// A way to trace paths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Baseline {
    name: &'static str,
    about: &'static str,
    emitters: bool,
}

/// Path tracing as the reference does it, and without samples of emitters and the sky. Sun and lights, which no ray meets by chance, are
/// sampled by both.
pub(super) const BASELINES: [Baseline; 2] = [
    Baseline {
        name: "path tracing",
        about: "path tracing with the rays of the first row",
        emitters: true,
    },
    Baseline {
        name: "brute force",
        about: "the same without rays to emitters and the sky",
        emitters: false,
    },
];

/// Samples per pixel of the run that tells how long paths are.
const PILOT: u32 = 8;

/// Path traces the picture with each of the budgets, where it buys a sample per pixel or was asked for: with as many samples as
/// come closest to it, at least one.
///
/// A sample of a pixel takes as many rays as its path has segments; one pilot run tells how many that is in the mean. Of a path
/// neither the ray to the primary surface counts, which is traced once for all samples, nor those to lights and emitters.
pub(super) fn trace_paths(
    baseline: &Baseline,
    job: &Job<'_>,
    budgets: impl Iterator<Item = Budget>,
) -> Result<Vec<Traced>, BenchError> {
    let render = |samples, seed| {
        let options = ReferenceOptions {
            size: job.size,
            samples,
            seed,
            emitters: baseline.emitters,
        };
        let mut start = Instant::now();
        let progress = |frames, _| {
            // Before that, scene and primary surfaces are prepared.
            if frames == 0 {
                start = Instant::now();
            }
        };
        let done = reference(job.backend, job.scene, job.view, &options, progress);
        done.map(|(picture, certainty)| (picture, certainty, start.elapsed().as_secs_f64()))
    };
    let per_sample = {
        let (_, certainty, _) = render(PILOT, job.seed)?;
        (certainty.segments as f64 / f64::from(PILOT)).max(1.0)
    };
    let mut traced = Vec::new();
    for budget in budgets {
        let samples = (budget.rays / per_sample).round() as u32;
        if samples == 0 && !budget.asked {
            continue;
        }
        let (picture, certainty, seconds) = render(samples.max(1), job.seed)?;
        traced.push(Traced {
            frames: budget.frames,
            errors: job.truth.errors(&picture, baseline.name, budget.frames)?,
            rays: certainty.segments as f64,
            seconds,
            ratio: seconds / budget.seconds,
        });
    }
    Ok(traced)
}

/// The row of a baseline; `traced` has an element for each seed. Time and rays are spread evenly over the frames that the
/// surfels had.
pub(super) fn row(
    baseline: &Baseline,
    checkpoints: &[(u32, bool)],
    traced: &[Vec<Traced>],
) -> Option<Row> {
    let after = checkpoints.iter().filter_map(|&(frames, asked)| {
        let all = || traced.iter().flatten().filter(move |t| t.frames == frames);
        all().next()?;
        let per_frame = 1.0 / f64::from(frames);
        Some(After {
            frames,
            asked,
            errors: Errors::of(all().map(|t| t.errors)),
            rays: Mean::of(all().map(|t| t.rays)).mean * per_frame,
            milliseconds: Spread::of(all().map(|t| t.seconds)).median * per_frame * 1e3,
            ratio: Spread::of(all().map(|t| t.ratio)),
        })
    });
    let after: Vec<After> = after.collect();
    (!after.is_empty()).then(|| Row {
        name: baseline.name.into(),
        about: baseline.about.into(),
        after,
    })
}
