//! Path tracing with as many rays as surfels had, and in as much time.
use super::frames::{Job, Run};
use super::pictures::Shot;
use super::{After, BenchError, Errors, Kind, Mean, Row, Spread};
use crate::compare::{Metrics, Report};
use crate::picture::Picture;
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
    pub frames: u32,
    pub errors: Metrics,
    pub rays: f64,
    pub seconds: f64,
    /// Seconds over those of the surfels.
    ratio: f64,
    /// Rays over those of the surfels.
    rays_ratio: f64,
    pub shot: Option<Shot>,
}

/// A way to trace paths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Baseline {
    pub name: &'static str,
    about: &'static str,
    emitters: bool,
}

/// Path tracing as the reference does it, and without samples of emitters and the sky. Sun and lights, which no ray meets by chance, are
/// sampled by both.
pub(super) const BASELINES: [Baseline; 2] = [
    Baseline {
        name: "path tracing",
        about: "path tracing with a ray to an emitter or the sky at each vertex",
        emitters: true,
    },
    Baseline {
        name: "brute force",
        about: "path tracing without rays to emitters and the sky",
        emitters: false,
    },
];

/// Samples per pixel of the run that tells how long paths are and how long they take.
const PILOT: u32 = 8;

/// A time that is this much off, over the sought one, is tried once more; a time or rays that stay so are named.
pub(super) const OFF: f64 = 0.05;

/// Of ratios over what was sought, the one that missed by most; seeds that missed to either side do not make up for each other.
fn farthest(ratios: impl Iterator<Item = f64>) -> f64 {
    let by_log = |a: &f64, b: &f64| a.ln().abs().total_cmp(&b.ln().abs());
    ratios.max_by(by_log).unwrap_or(1.0)
}

/// Traces paths of one baseline with one seed.
pub(super) struct Tracer<'a> {
    pub job: &'a Job<'a>,
    pub baseline: &'a Baseline,
    /// Rays of a sample of every pixel.
    rays: f64,
    /// Seconds of a sample of every pixel.
    seconds: f64,
    /// What the pilot run saw.
    pilot: Picture,
}

/// A picture and what it took.
pub(super) struct Sampled {
    pub picture: Picture,
    /// Segments of all paths. Neither the ray to the primary surface counts, which is traced once for all samples, nor those to
    /// lights and emitters.
    pub rays: f64,
    /// Without preparing the scene and the primary surfaces.
    pub seconds: f64,
}

impl<'a> Tracer<'a> {
    /// With a pilot run, after another one in which drivers may compile kernels.
    pub fn new(job: &'a Job<'a>, baseline: &'a Baseline) -> Result<Self, BenchError> {
        let mut tracer = Self {
            job,
            baseline,
            rays: 0.0,
            seconds: 0.0,
            pilot: Picture::default(),
        };
        tracer.sample(job.size, 1)?;
        let pilot = tracer.sample(job.size, PILOT)?;
        tracer.rays = (pilot.rays / f64::from(PILOT)).max(1.0);
        tracer.seconds = (pilot.seconds / f64::from(PILOT)).max(1e-9);
        tracer.pilot = pilot.picture;
        Ok(tracer)
    }

    /// Whether it traces the very paths of another one: where nothing emits that a ray could be sent to, the baselines are
    /// one.
    pub fn is(&self, other: &Self) -> bool {
        let light = |tracer: &Self| tracer.pilot.rgb("E").map(|rgb| rgb.map(<[f32]>::to_vec));
        match (light(self), light(other)) {
            (Ok(own), Ok(other)) => own == other,
            _ => false,
        }
    }

    /// Renders so many samples per pixel.
    pub fn sample(&self, size: [u32; 2], samples: u32) -> Result<Sampled, BenchError> {
        let options = ReferenceOptions {
            size,
            samples,
            seed: self.job.seed,
            emitters: self.baseline.emitters,
        };
        let mut start = Instant::now();
        let progress = |frames, _| {
            // Before that, scene and primary surfaces are prepared.
            if frames == 0 {
                start = Instant::now();
            }
        };
        let job = self.job;
        let (picture, certainty) = reference(job.backend, job.scene, job.view, &options, progress)?;
        Ok(Sampled {
            picture,
            rays: certainty.segments as f64,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// The errors of a picture.
    pub fn errors(&self, picture: &Picture, frames: u32) -> Result<Report, BenchError> {
        self.job.truth.errors(picture, self.baseline.name, frames)
    }

    /// Traces with each of the budgets, where it buys a sample per pixel or was asked for: with as many samples as come
    /// closest to it, at least one.
    pub fn trace(
        &self,
        kind: Kind,
        budgets: impl Iterator<Item = Budget>,
    ) -> Result<Vec<Traced>, BenchError> {
        let mut traced = Vec::new();
        for budget in budgets {
            let samples = match kind {
                Kind::EqualTime => budget.seconds / self.seconds,
                _ => budget.rays / self.rays,
            };
            let samples = samples.round() as u32;
            if samples == 0 && !budget.asked {
                continue;
            }
            let rendered = samples.max(1);
            let mut done = self.sample(self.job.size, rendered)?;
            if kind == Kind::EqualTime {
                // Few samples take longer each than many: a picture is done when its longest path is.
                let better = f64::from(rendered) * budget.seconds / done.seconds;
                let better = (better.round() as u32).max(1);
                let off = (done.seconds / budget.seconds - 1.0).abs();
                if off > OFF && better != rendered {
                    let again = self.sample(self.job.size, better)?;
                    if (again.seconds / budget.seconds - 1.0).abs() < off {
                        done = again;
                    }
                }
            }
            let report = self.errors(&done.picture, budget.frames)?;
            let at = (budget.frames, budget.asked && kind == Kind::EqualTime);
            traced.push(Traced {
                frames: budget.frames,
                errors: report.metrics,
                rays: done.rays,
                seconds: done.seconds,
                ratio: done.seconds / budget.seconds,
                rays_ratio: done.rays / budget.rays.max(1.0),
                shot: self
                    .job
                    .shot(&name(self.baseline, kind), at, &done.picture, &report),
            });
        }
        Ok(traced)
    }
}

fn name(baseline: &Baseline, kind: Kind) -> String {
    let what = match kind {
        Kind::EqualTime => "equal time",
        _ => "equal rays",
    };
    format!("{}, {what}", baseline.name)
}

/// The row of a baseline; `traced` has an element for each seed, as has `first`, the runs of the first configuration. Time and rays of a frame are those of the picture spread evenly
/// over the frames that the surfels had.
pub(super) fn row(
    baseline: &Baseline,
    kind: Kind,
    checkpoints: &[(u32, bool)],
    traced: &[Vec<Traced>],
    first: &[Run],
) -> Option<Row> {
    let after = checkpoints.iter().filter_map(|&(frames, asked)| {
        let all = || traced.iter().flatten().filter(move |t| t.frames == frames);
        all().next()?;
        let pairs = traced.iter().zip(first).filter_map(|(traced, run)| {
            let own = traced.iter().find(|t| t.frames == frames)?;
            Some(own.errors.mape / run.errors(frames)?.mape)
        });
        let per_frame = 1.0 / f64::from(frames);
        let rays = Mean::of(all().map(|t| t.rays)).mean;
        Some(After {
            frames,
            asked,
            errors: Errors::of(all().map(|t| t.errors)),
            mape_ratio: Mean::of(pairs),
            rays: rays * per_frame,
            total_rays: rays,
            milliseconds: Spread::of(all().map(|t| t.seconds)).median * per_frame * 1e3,
            seconds: Mean::of(all().map(|t| t.seconds)),
            ratio: Spread::of(all().map(|t| t.ratio)),
            taken: Some(match kind {
                Kind::EqualTime => farthest(all().map(|t| t.ratio)),
                _ => farthest(all().map(|t| t.rays_ratio)),
            }),
            pareto: false,
        })
    });
    let after: Vec<After> = after.collect();
    let budget = match kind {
        Kind::EqualTime => "in the time of the first row",
        _ => "with the rays of the first row",
    };
    (!after.is_empty()).then(|| Row {
        name: name(baseline, kind),
        about: format!("{}, {budget}", baseline.about),
        kind,
        after,
    })
}

#[cfg(test)]
mod tests {
    use super::farthest;

    #[test]
    fn misses_to_either_side_do_not_make_up_for_each_other() {
        assert_eq!(farthest([1.0, 1.25, 0.7].into_iter()), 0.7);
        assert_eq!(farthest([1.5, 1.0, 1.0].into_iter()), 1.5);
        assert_eq!(farthest([].into_iter()), 1.0);
    }
}
