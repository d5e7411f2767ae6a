//! Frames of all configurations in turn, their errors, times and rays.
use super::pictures::Shot;
use super::{BenchError, Configuration, Truth};
use crate::compare::{HEAT_FULL_SCALE, Metrics, Report};
use crate::picture::Picture;
use crate::view::View;
use crate::{RenderError, Renderer};
use gibs_graph::Backend;
use gibs_passes::scene::Scene;
use std::time::Instant;

/// What is rendered.
pub(super) struct Job<'a> {
    pub backend: &'a dyn Backend,
    pub scene: &'a Scene,
    pub view: &'a View,
    pub truth: &'a Truth,
    pub size: [u32; 2],
    pub checkpoints: &'a [(u32, bool)],
    pub seed: u32,
    /// Whether pictures are kept.
    pub keep: bool,
}

impl Job<'_> {
    /// The picture after frames that were asked for, if pictures are kept.
    pub fn shot(
        &self,
        name: &str,
        (frames, asked): (u32, bool),
        picture: &Picture,
        report: &Report,
    ) -> Option<Shot> {
        (self.keep && asked).then(|| Shot {
            name: name.into(),
            frames,
            picture: picture.clone(),
            heat: report.heat_map(HEAT_FULL_SCALE),
            mape: report.metrics.mape,
        })
    }
}

/// The frames of one configuration with one seed.
#[derive(Clone, Debug, Default)]
pub(super) struct Run {
    /// Seconds of each frame.
    seconds: Vec<f64>,
    /// Rays of each frame.
    rays: Vec<u64>,
    /// Errors after so many frames.
    errors: Vec<(u32, Metrics)>,
    /// Pictures after frames that were asked for; of the first configuration, where they are kept.
    pub shots: Vec<Shot>,
}

impl Run {
    /// Rays of the first frames together.
    pub fn rays(&self, frames: u32) -> f64 {
        let first = self.rays.iter().take(frames as usize);
        first.sum::<u64>() as f64
    }

    /// Seconds that the first frames took together.
    pub fn seconds(&self, frames: u32) -> f64 {
        self.seconds.iter().take(frames as usize).sum()
    }

    /// Seconds of each of the first frames.
    pub fn times(&self, frames: u32) -> impl Iterator<Item = f64> {
        self.seconds.iter().copied().take(frames as usize)
    }

    /// Times over those of another run, frame by frame.
    pub fn ratios(&self, other: &Self, frames: u32) -> impl Iterator<Item = f64> {
        let pairs = self.times(frames).zip(other.times(frames));
        pairs.map(|(own, other)| own / other)
    }

    /// Errors after so many frames.
    pub fn errors(&self, frames: u32) -> Option<Metrics> {
        let found = self.errors.iter().find(|(after, _)| *after == frames);
        found.map(|(_, metrics)| *metrics)
    }
}

/// Renders all configurations with one seed. `warnings` become those of the scene.
pub(super) fn run(
    job: &Job<'_>,
    configurations: &[Configuration],
    progress: &mut impl FnMut(),
    warnings: &mut Vec<String>,
) -> Result<Vec<Run>, BenchError> {
    let mut renderers = configurations
        .iter()
        .map(|configuration| started(job, configuration))
        .collect::<Result<Vec<_>, RenderError>>()?;
    let of_first = renderers.first().map_or(&[][..], Renderer::warnings);
    *warnings = of_first.to_vec();
    let count = renderers.len();
    let mut runs = vec![Run::default(); count];
    let last = job.checkpoints.last().map_or(0, |(frames, _)| *frames);
    for frame in 1..=last {
        // Every other frame backwards, so that nobody always finds caches as the same other one left them.
        for turn in 0..count {
            let i = match frame % 2 {
                0 => count - 1 - turn,
                _ => turn,
            };
            let start = Instant::now();
            renderers[i].frame()?;
            renderers[i].wait()?;
            runs[i].seconds.push(start.elapsed().as_secs_f64());
            runs[i].rays.push(rays(&mut renderers[i])?);
            if let Some(at) = job.checkpoints.iter().find(|(after, _)| *after == frame) {
                let picture = renderers[i].picture()?;
                let name = &configurations[i].name;
                let report = job.truth.errors(&picture, name, frame)?;
                runs[i].errors.push((frame, report.metrics));
                if i == 0 {
                    let shot = job.shot(name, *at, &picture, &report);
                    runs[i].shots.extend(shot);
                }
            }
            progress();
        }
    }
    Ok(runs)
}

/// A renderer before its first frame, but warm: the first configuration would pay for all that have the same kernels.
fn started(job: &Job<'_>, configuration: &Configuration) -> Result<Renderer, RenderError> {
    let mut renderer = Renderer::new(
        job.backend,
        job.scene,
        job.view,
        job.size,
        &configuration.settings,
        job.seed,
    )?;
    renderer.warm_up()?;
    Ok(renderer)
}

/// Rays of the last frame: of surfels, and of paths that went on beyond hits.
fn rays(renderer: &mut Renderer) -> Result<u64, RenderError> {
    let counters = renderer.counters()?;
    Ok(u64::from(counters.rays) + u64::from(counters.continued))
}
