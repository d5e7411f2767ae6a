//! Frames of several runs, timed and not in turns.
use super::memory::memory;
use super::statistics::{Figure, Interval};
use super::trace::TimedFrame;
use super::work::work;
use super::{Cost, FrameCost, Profile, StageCost, Work};
use crate::conditions::{settings_map, view_value};
use crate::stages::{fold, group_of, stage_of};
use crate::statistics::quantile;
use crate::view::View;
use crate::{RenderError, Renderer};
use gibs_graph::{Backend, Schedule};
use gibs_passes::frame::Settings;
use gibs_passes::scene::Scene;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How much to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Runs, each with an executable of its own and from an empty cache, at least 1. Their differences are the noise.
    pub runs: u32,
    /// Measured frames of a run, at least 1. As many are run without timing their steps, in turns.
    pub frames: u32,
    /// Frames of a run before the measured ones.
    pub warm_up: u32,
    /// Seed of the first run; each has its own.
    pub seed: u32,
}

/// What is known after a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// Frames done.
    pub done: u32,
    /// Frames in all.
    pub of: u32,
    /// The groups so far, with medians and shares.
    pub groups: Vec<Cost>,
    /// Median of the frame so far, milliseconds; `None` before the first measured frame.
    pub frame_ms: Option<f64>,
}

/// Times of frames: for each run, for each frame.
#[derive(Clone, Debug, Default)]
struct Samples {
    /// Wall time with the steps timed, milliseconds.
    timed: Vec<Vec<f64>>,
    /// Wall time without, milliseconds.
    untimed: Vec<Vec<f64>>,
    /// Milliseconds of each step; `None` of steps that have no time.
    steps: Vec<Vec<Vec<Option<f64>>>>,
}

impl Options {
    /// Frames that [`measure`] runs.
    fn all_frames(&self) -> u32 {
        let of_run = self.warm_up.saturating_add(self.frames.saturating_mul(2));
        of_run.saturating_mul(self.runs)
    }
}

/// Least time between two words to `progress`.
const BETWEEN_WORDS: Duration = Duration::from_millis(200);

/// Measures the frame. `progress` hears of it a few times a second, and of the last frame. Beside the profile come the timed frames of the first run.
///
/// # Errors
/// [`RenderError`]; [`RenderError::NoFrame`] without runs or frames.
pub fn measure(
    backend: &dyn Backend,
    (name, scene): (&str, &Scene),
    view: &View,
    settings: &Settings,
    options: &Options,
    mut progress: impl FnMut(&Progress),
) -> Result<(Profile, Vec<TimedFrame>), RenderError> {
    let mut samples = Samples::default();
    let mut frames = Vec::new();
    let mut last = None;
    let mut done = 0;
    let mut heard = Instant::now();
    for run in 0..options.runs {
        let seed = options.seed.wrapping_add(run);
        let mut renderer = Renderer::new(backend, scene, view, options.size, settings, seed)?;
        let schedule = Arc::clone(renderer.executable().schedule());
        samples.timed.push(Vec::new());
        samples.untimed.push(Vec::new());
        samples.steps.push(Vec::new());
        let began = Instant::now();
        for frame in 0..options
            .warm_up
            .saturating_add(options.frames.saturating_mul(2))
        {
            let measured = frame >= options.warm_up;
            // The first of a pair, then the second of the next, so that what drifts is in neither.
            let timed = measured && matches!((frame - options.warm_up) % 4, 0 | 3);
            renderer.executable().measure(timed);
            let start = Instant::now();
            renderer.frame()?;
            renderer.wait()?;
            let wall = start.elapsed();
            if timed {
                let times = renderer.executable().timings()?.unwrap_or_default();
                let mut steps = vec![None; schedule.steps.len()];
                for time in &times {
                    if let Some(step) = steps.get_mut(time.step) {
                        *step = Some(time.time.as_secs_f64() * 1e3);
                    }
                }
                push(&mut samples.timed, wall.as_secs_f64() * 1e3);
                push(&mut samples.steps, steps);
                if run == 0 {
                    frames.push(TimedFrame {
                        start: start - began,
                        wall,
                        steps: times,
                    });
                }
            } else if measured {
                push(&mut samples.untimed, wall.as_secs_f64() * 1e3);
            }
            done += 1;
            // What it hears takes a look at all samples so far.
            if done == options.all_frames() || heard.elapsed() >= BETWEEN_WORDS {
                progress(&Progress {
                    done,
                    of: options.all_frames(),
                    groups: samples.groups(&schedule),
                    frame_ms: samples.median(),
                });
                heard = Instant::now();
            }
        }
        last = Some(renderer);
    }
    let Some(mut renderer) = last.filter(|_| options.frames > 0) else {
        return Err(RenderError::NoFrame {
            what: "profile".into(),
        });
    };
    let work = work(&mut renderer)?;
    // After that, which runs a frame: both are of the same one.
    let counters = renderer.counters()?;
    let schedule = Arc::clone(renderer.executable().schedule());
    let stages = samples.stages(&schedule, &work);
    let steps = samples.steps(&schedule, &work);
    let device = backend.device();
    let profile = Profile {
        version: env!("CARGO_PKG_VERSION").into(),
        scene: name.into(),
        view: view_value(view),
        backend: backend.name().into(),
        device: device.name.clone(),
        driver: device.driver.clone(),
        notes: device.notes.clone(),
        size: options.size,
        settings: settings_map(settings),
        runs: options.runs,
        seed: options.seed,
        frames: options.frames,
        warm_up: options.warm_up,
        frame: samples.frame(&work),
        memory: memory(&schedule, device.kind == "cpu"),
        counters,
        groups: samples.groups(&schedule),
        stages,
        steps,
    };
    Ok((profile, frames))
}

fn push<T>(runs: &mut [Vec<T>], value: T) {
    if let Some(run) = runs.last_mut() {
        run.push(value);
    }
}

impl Samples {
    /// The time of some steps together, in every frame; `None` where none of them has one.
    fn sum(&self, steps: &[usize]) -> Option<Figure> {
        let frame = |frame: &Vec<Option<f64>>| -> f64 {
            steps.iter().filter_map(|&step| frame[step]).sum()
        };
        let all = self.steps.iter().flatten();
        let mut times = all.flat_map(|frame| steps.iter().map(|&step| frame[step]));
        times.any(|time| time.is_some()).then(|| {
            let runs = self.steps.iter();
            let runs = runs.map(|run| run.iter().map(frame).collect());
            Figure::of(&runs.collect::<Vec<_>>())
        })
    }

    /// Of the timed frames, milliseconds.
    fn median(&self) -> Option<f64> {
        quantile(&self.timed.concat(), 0.5)
    }

    fn all(&self) -> Option<Figure> {
        let first = self.steps.iter().flatten().next()?;
        self.sum(&(0..first.len()).collect::<Vec<_>>())
    }

    fn cost(&self, name: String, steps: &[usize], all: f64) -> Cost {
        let ms = self.sum(steps);
        Cost {
            name,
            share: ms.as_ref().map_or(0.0, |ms| ms.median) / all.max(1e-9),
            ms,
        }
    }

    fn groups(&self, schedule: &Schedule) -> Vec<Cost> {
        let all = self.all().map_or(0.0, |all| all.median);
        let groups = fold((0..schedule.steps.len()).map(|step| group_of(schedule, step)));
        let groups = groups.into_iter();
        groups
            .map(|(name, steps)| self.cost(name, &steps, all))
            .collect()
    }

    fn stages(&self, schedule: &Schedule, work: &[Work]) -> Vec<StageCost> {
        let all = self.all().map_or(0.0, |all| all.median);
        let names = (0..schedule.steps.len()).map(|step| {
            let group = group_of(schedule, step);
            (group, stage_of(&schedule.steps[step].label))
        });
        let stages = fold(names).into_iter();
        stages
            .map(|((group, name), steps)| StageCost {
                group,
                cost: self.cost(name, &steps, all),
                times: steps.len() as u32,
                work: steps.iter().map(|&step| work[step]).sum(),
            })
            .collect()
    }

    fn steps(&self, schedule: &Schedule, work: &[Work]) -> Vec<StageCost> {
        let all = self.all().map_or(0.0, |all| all.median);
        let steps = schedule.steps.iter().enumerate();
        steps
            .map(|(step, found)| StageCost {
                group: group_of(schedule, step),
                cost: self.cost(found.label.clone(), &[step], all),
                times: 1,
                work: work[step],
            })
            .collect()
    }

    fn frame(&self, work: &[Work]) -> FrameCost {
        let tracing: Vec<usize> = (0..work.len())
            .filter(|&step| work[step].rays > 0)
            .collect();
        let frames = || self.timed.iter().flatten().zip(self.steps.iter().flatten());
        let sum = |steps: &[Option<f64>]| -> f64 { steps.iter().flatten().sum() };
        let shares = frames().map(|(wall, steps)| sum(steps) / wall.max(1e-9));
        let shares: Vec<f64> = shares.collect();
        let traced =
            |steps: &[Option<f64>]| -> f64 { tracing.iter().filter_map(|&step| steps[step]).sum() };
        let over = frames().map(|(wall, steps)| wall / traced(steps));
        let over: Vec<f64> = over.filter(|over| over.is_finite()).collect();
        let steps_ms = self.all();
        let runs = self.timed.iter().zip(&self.untimed);
        let pairs = runs.map(|(timed, untimed)| {
            let pairs = timed.iter().copied().zip(untimed.iter().copied());
            pairs.collect()
        });
        let pairs: Vec<Vec<(f64, f64)>> = pairs.collect();
        FrameCost {
            wall_ms: Figure::of(&self.untimed),
            timed_ms: Figure::of(&self.timed),
            covered: steps_ms.as_ref().and_then(|_| quantile(&shares, 0.5)),
            over_tracing: quantile(&over, 0.5),
            steps_ms,
            tracing_ms: self.sum(&tracing),
            overhead: Interval::of_paired_runs(&pairs),
        }
    }
}

impl std::iter::Sum for Work {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |sum, work| Self {
            invocations: sum.invocations + work.invocations,
            items: match (sum.items, work.items) {
                (None, None) => None,
                (a, b) => Some(a.unwrap_or_default() + b.unwrap_or_default()),
            },
            rays: sum.rays + work.rays,
            bytes_read: sum.bytes_read + work.bytes_read,
            bytes_written: sum.bytes_written + work.bytes_written,
            bytes_held: sum.bytes_held + work.bytes_held,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of frames with known times: medians of the untimed and the timed ones, what steps cover, and what a frame takes over its rays.
    #[test]
    fn a_frame_s_figures_are_of_the_frames_that_they_say() {
        let samples = Samples {
            timed: vec![vec![10.0, 20.0], vec![12.0, 40.0], vec![16.0, 10.0]],
            untimed: vec![vec![5.0, 10.0], vec![6.0, 20.0], vec![8.0, 5.0]],
            // A step that traces, one that does not, and one without time.
            steps: vec![
                vec![
                    vec![Some(4.0), Some(4.0), None],
                    vec![Some(8.0), Some(8.0), None],
                ],
                vec![
                    vec![Some(6.0), Some(3.0), None],
                    vec![Some(10.0), Some(20.0), None],
                ],
                vec![
                    vec![Some(4.0), Some(8.0), None],
                    vec![Some(5.0), Some(4.0), None],
                ],
            ],
        };
        let rays = |rays| Work {
            rays,
            ..Work::default()
        };
        let frame = samples.frame(&[rays(7), rays(0), rays(0)]);
        // 5, 5, 6, 8, 10, 20 and 10, 10, 12, 16, 20, 40.
        assert_eq!(frame.wall_ms.median, 7.0);
        assert_eq!(frame.timed_ms.median, 14.0);
        // 4, 4, 5, 6, 8, 10.
        assert_eq!(frame.tracing_ms.map(|ms| ms.median), Some(5.5));
        // 8, 9, 9, 12, 16, 30.
        assert_eq!(frame.steps_ms.map(|ms| ms.median), Some(10.5));
        // 8/10, 16/20, 9/12, 30/40, 12/16, 9/10.
        assert_eq!(frame.covered, Some((0.75 + 0.8) / 2.0));
        // 10/4, 20/8, 12/6, 40/10, 16/4, 10/5.
        assert_eq!(frame.over_tracing, Some(2.5));
        // Each timed frame takes twice what the one beside it does.
        assert!((frame.overhead.ratio - 2.0).abs() < 1e-12);
        let [low, high] = frame.overhead.bounds.expect("of three runs");
        assert!((low - 2.0).abs() < 1e-9 && (high - 2.0).abs() < 1e-9);
    }
}
