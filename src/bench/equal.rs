//! How much path tracing needs for the error that surfels have.
use super::baseline::{Budget, Tracer};
use super::{BenchError, Mean};
use crate::compare::Metrics;
use serde::Serialize;

/// What path tracing needs for the error that the first configuration has after so many frames. Every seed is held against its own.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EqualError {
    /// The baseline.
    pub baseline: String,
    /// Frames of the first configuration.
    pub frames: u32,
    /// `rel_mse` or `mape`.
    pub metric: &'static str,
    /// Its error there.
    pub error: Mean,
    /// Seeds with which path tracing did not get there. Their part in the figures below is the most that was tried, and what is
    /// needed is more.
    pub unreached: u32,
    /// Seeds with which one sample per pixel was better than sought: their part is one sample, and what is needed is less.
    pub fewer: u32,
    /// Samples per pixel. Like the three below without an interval where any seed's part is a bound.
    pub samples: Mean,
    /// Rays.
    pub rays: Mean,
    /// Seconds.
    pub seconds: Mean,
    /// Seconds over those of the first configuration.
    pub times: Mean,
}

/// One seed's part of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Needed {
    frames: u32,
    metric: &'static str,
    error: f64,
    need: Need,
    rays: f64,
    seconds: f64,
    times: f64,
}

/// Errors that are looked for: name, value, and by which power of the samples it falls where noise is all of it.
type Sought = (&'static str, fn(&Metrics) -> f64, f64);
const SOUGHT: [Sought; 2] = [("rel_mse", |m| m.rel_mse, 1.0), ("mape", |m| m.mape, 0.5)];

/// An error this close, as a ratio less one, is found; between it and the sought one, errors are straight lines of logarithms.
const CLOSE: f64 = 0.05;

/// Most renders of a search.
const MOST_RENDERS: u32 = 16;

/// Samples beyond the most so far, as a factor, at most: a guess from few samples is a rough one.
const MOST_GROWTH: f64 = 64.0;

/// What a search found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Need {
    /// Samples per pixel.
    pub samples: f64,
    /// Whether they suffice.
    pub reached: bool,
    /// Whether the fewest that there are more than suffice.
    pub fewer: bool,
}

/// Rendered samples, ascending, and what came of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Curve {
    points: Vec<Point>,
    /// Seconds of a sample in the render with most samples.
    seconds: f64,
}

#[derive(Clone, Debug)]
pub(super) struct Point {
    pub samples: u32,
    pub errors: Metrics,
    pub rays: f64,
}

/// Finds what is needed for the errors after frames that were asked for. Only the truth's pixels are rendered, each path of which stands
/// for as many as the picture has pixels for one of the truth's; `seconds_per_ray` is of whole pictures. `limit` is the most
/// seconds that one render may take.
pub(super) fn needed(
    tracer: &Tracer<'_>,
    goals: &[(Budget, Metrics)],
    seconds_per_ray: f64,
    limit: f64,
) -> Result<Vec<Needed>, BenchError> {
    let truth = tracer.job.truth;
    let size = truth.size();
    let mut curve = Curve::default();
    let mut all = Vec::new();
    for (budget, metrics) in goals {
        for (metric, value, power) in SOUGHT {
            let goal = value(metrics);
            let need = search(&mut curve, value, power, goal, limit, |samples| {
                let done = tracer.sample(size, samples)?;
                let report = tracer.errors(&done.picture, budget.frames)?;
                let point = Point {
                    samples,
                    errors: report.metrics,
                    rays: done.rays,
                };
                Ok::<_, BenchError>((point, done.seconds))
            })?;
            let rays = rays(&need, curve.rays_per_sample(), truth.step());
            all.push(Needed::of(
                budget,
                (metric, goal),
                need,
                rays,
                seconds_per_ray,
            ));
        }
    }
    Ok(all)
}

/// Rays of whole pictures, where only one pixel of `step` times `step` was rendered.
pub(super) fn rays(need: &Need, per_sample: f64, step: u32) -> f64 {
    need.samples * per_sample * f64::from(step).powi(2)
}

impl Needed {
    pub(super) fn of(
        budget: &Budget,
        (metric, error): (&'static str, f64),
        need: Need,
        rays: f64,
        seconds_per_ray: f64,
    ) -> Self {
        let seconds = rays * seconds_per_ray;
        Self {
            frames: budget.frames,
            metric,
            error,
            need,
            rays,
            seconds,
            times: seconds / budget.seconds,
        }
    }
}

impl Curve {
    fn add(&mut self, point: Point, seconds: f64) {
        let at = self.points.partition_point(|p| p.samples < point.samples);
        if at == self.points.len() {
            self.seconds = seconds / f64::from(point.samples.max(1));
        }
        self.points.insert(at, point);
    }

    /// Of the render with most samples.
    fn rays_per_sample(&self) -> f64 {
        self.points
            .last()
            .map_or(0.0, |p| p.rays / f64::from(p.samples.max(1)))
    }

    /// The most samples whose error is above the goal, and the fewest beyond them, whose error is not.
    fn around(&self, value: fn(&Metrics) -> f64, goal: f64) -> [Option<(u32, f64)>; 2] {
        let figures = |p: &Point| (p.samples, value(&p.errors));
        let above = self.points.iter().rposition(|p| value(&p.errors) > goal);
        let next = above.map_or(0, |i| i + 1);
        [
            above.and_then(|i| self.points.get(i)).map(figures),
            self.points.get(next).map(figures),
        ]
    }
}

/// The samples with which `value` falls to the goal: doubled and more until it is below, then between by straight lines of logarithms,
/// until a render comes close.
pub(super) fn search<E>(
    curve: &mut Curve,
    value: fn(&Metrics) -> f64,
    power: f64,
    goal: f64,
    limit: f64,
    mut render: impl FnMut(u32) -> Result<(Point, f64), E>,
) -> Result<Need, E> {
    for _ in 0..MOST_RENDERS {
        let next = match curve.around(value, goal) {
            [None, None] => 1,
            // The fewest that there are suffice.
            [None, Some((samples, _))] if samples <= 1 => break,
            [None, Some((samples, error))] => {
                let guess = f64::from(samples) * (error / goal).powf(1.0 / power) * 0.8;
                (guess as u32).clamp(1, samples - 1)
            }
            [Some((samples, error)), None] => {
                let most = (limit / curve.seconds.max(1e-12)).min(f64::from(u32::MAX / 2));
                if f64::from(samples) * 1.1 >= most {
                    break;
                }
                let factor = 1.1 * (error / goal).powf(1.0 / power);
                let guess = f64::from(samples) * factor.clamp(1.5, MOST_GROWTH);
                (guess.min(most) as u32).max(samples + 1)
            }
            [Some(above), Some(below)] => {
                let near = [above, below].map(|(_, error)| (error / goal).ln().abs() < CLOSE);
                if near[0] || near[1] || below.0 <= above.0 + 1 {
                    break;
                }
                (between(above, below, goal).round() as u32).clamp(above.0 + 1, below.0 - 1)
            }
        };
        let (point, seconds) = render(next)?;
        curve.add(point, seconds);
    }
    Ok(match curve.around(value, goal) {
        [Some(above), Some(below)] => Need {
            samples: between(above, below, goal),
            reached: true,
            fewer: false,
        },
        [None, Some((samples, error))] => Need {
            samples: f64::from(samples),
            reached: true,
            fewer: samples <= 1 && (error / goal).ln() < -CLOSE,
        },
        [Some((samples, _)), None] => Need {
            samples: f64::from(samples),
            reached: false,
            fewer: false,
        },
        [None, None] => Need {
            samples: 0.0,
            reached: false,
            fewer: false,
        },
    })
}

/// Where the straight line of logarithms through two points meets the goal.
fn between(above: (u32, f64), below: (u32, f64), goal: f64) -> f64 {
    let [from, to] = [above.0, below.0].map(|samples| f64::from(samples).ln());
    let fall = (above.1 / below.1).ln();
    let share = match fall > 0.0 {
        true => ((above.1 / goal).ln() / fall).clamp(0.0, 1.0),
        false => 0.5,
    };
    (from + (to - from) * share).exp()
}

/// Over seeds; `all` has an element for each.
pub(super) fn over_seeds(baseline: &str, all: &[Vec<Needed>]) -> Vec<EqualError> {
    let Some(first) = all.first() else {
        return Vec::new();
    };
    let of = |i: usize| {
        let each = || all.iter().filter_map(move |seed| seed.get(i));
        let mean = |value: fn(&Needed) -> f64| Mean::of(each().map(value));
        let seeds = |is: fn(&Need) -> bool| each().filter(|n| is(&n.need)).count() as u32;
        let one = each().next()?;
        let (unreached, fewer) = (seeds(|need| !need.reached), seeds(|need| need.fewer));
        let found = |value: fn(&Needed) -> f64| match unreached + fewer {
            0 => mean(value),
            _ => mean(value).without_interval(),
        };
        Some(EqualError {
            baseline: baseline.into(),
            frames: one.frames,
            metric: one.metric,
            error: mean(|n| n.error),
            unreached,
            fewer,
            samples: found(|n| n.need.samples),
            rays: found(|n| n.rays),
            seconds: found(|n| n.seconds),
            times: found(|n| n.times),
        })
    };
    (0..first.len()).filter_map(of).collect()
}
