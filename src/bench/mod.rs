//! Speed against error: what each element of the technique gains and costs, and what path tracing makes of as many rays, as much
//! time, or until it is as right.
mod baseline;
mod cache;
mod configuration;
mod equal;
mod error;
mod frames;
mod key;
mod pareto;
mod pictures;
mod report;
mod row;
mod statistics;
#[cfg(test)]
mod tests;
mod truth;

pub use cache::{CachedReference, TruthCache};
pub use configuration::{Configuration, configurations};
pub use equal::EqualError;
pub use error::BenchError;
pub use pictures::{Pictures, Shot};
pub use report::{
    AboutTruth, BenchReport, Failed, Machine, Measured, csv, equal_error_csv, equal_error_table,
    heading, html, plots, table,
};
pub use row::{After, Errors, Kind, Row};
pub use statistics::{Mean, Spread};
pub use truth::{Look, TRUTH_STEPS, Target, Truth};

use baseline::{BASELINES, Budget, OFF, Traced, Tracer};
use equal::{Needed, needed, over_seeds};
use frames::{Run, run};

/// What to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// What to compare; the first is what times are held against and whose rays, time and error path tracing gets.
    pub configurations: Vec<Configuration>,
    /// Frames after which errors are reported, each at least 1.
    pub frames: Vec<u32>,
    /// Independent repetitions, at least 1.
    pub seeds: u32,
    /// Seconds that one render of the search for equal error may take; none is made where this is 0.
    pub search: f64,
    /// Whether pictures are kept.
    pub pictures: bool,
}

/// What was measured of one scene on one backend.
#[derive(Clone, Debug, Default)]
pub struct Measurement {
    /// A row for each configuration, then for each baseline.
    pub rows: Vec<Row>,
    /// What path tracing needs for the errors after the frames that were asked for.
    pub equal_error: Vec<EqualError>,
    /// Pictures of the first seed, where they were to be kept.
    pub shots: Vec<Shot>,
    /// What the scene has that no device gets.
    pub warnings: Vec<String>,
    /// Baselines that were not measured, since in this scene they are the first one.
    pub same: Vec<String>,
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

/// Measures all configurations, and path tracing in two ways: with the rays of the first one, in its time, and until it is as right.
/// The configurations take turns frame by frame, so that whatever else the machine does falls on all of them; path tracing
/// follows. `progress` hears of every frame.
///
/// # Errors
/// [`BenchError`].
pub fn measure(
    target: &Target<'_>,
    truth: &Truth,
    options: &Options,
    mut progress: impl FnMut(),
) -> Result<Measurement, BenchError> {
    let checkpoints = checkpoints(&options.frames);
    let mut runs: Vec<Vec<Run>> = vec![Vec::new(); options.configurations.len()];
    let mut baselines = BASELINES.map(|_| Traces::default());
    let (mut shots, mut warnings) = (Vec::new(), Vec::new());
    for seed in 0..options.seeds {
        let job = frames::Job {
            backend: target.backend,
            scene: target.scene,
            view: target.view,
            truth,
            size: options.size,
            checkpoints: &checkpoints,
            seed,
            keep: options.pictures && seed == 0,
        };
        let mut of_seed = run(&job, &options.configurations, &mut progress, &mut warnings)?;
        if let Some(first) = of_seed.first_mut() {
            shots.append(&mut first.shots);
            let mut tracers: Vec<Tracer<'_>> = Vec::new();
            for (baseline, traces) in BASELINES.iter().zip(&mut baselines) {
                if traces.same_as_first {
                    continue;
                }
                let tracer = Tracer::new(&job, baseline)?;
                let earlier = tracers.first().filter(|_| seed == 0);
                traces.same_as_first = earlier.is_some_and(|first| tracer.is(first));
                if !traces.same_as_first {
                    shots.extend(traces.add(&tracer, first, options.search)?);
                    tracers.push(tracer);
                }
            }
        }
        for (all, run) in runs.iter_mut().zip(of_seed) {
            all.push(run);
        }
    }
    let mut rows = surfel_rows(options, &checkpoints, &runs);
    let mut equal_error = Vec::new();
    for (baseline, traces) in BASELINES.iter().zip(&baselines) {
        for (kind, traced) in [
            (Kind::EqualRays, &traces.equal_rays),
            (Kind::EqualTime, &traces.equal_time),
        ] {
            let first = runs.first().map_or(&[][..], Vec::as_slice);
            rows.extend(baseline::row(baseline, kind, &checkpoints, traced, first));
        }
        equal_error.extend(over_seeds(baseline.name, &traces.needed));
    }
    pareto::mark(&mut rows);
    let same = BASELINES.iter().zip(&baselines);
    let same = same.filter(|(_, traces)| traces.same_as_first);
    let same = same.map(|(baseline, _)| baseline.name.to_owned()).collect();
    Ok(Measurement {
        rows,
        equal_error,
        shots,
        warnings,
        same,
    })
}

/// What a baseline did, with an element for each seed.
#[derive(Default)]
struct Traces {
    equal_rays: Vec<Vec<Traced>>,
    equal_time: Vec<Vec<Traced>>,
    needed: Vec<Vec<Needed>>,
    /// Nothing was traced: it would be what the first baseline traces.
    same_as_first: bool,
}

impl Traces {
    /// Traces with the next seed, after surfels had their run; returns pictures, where they are kept.
    fn add(
        &mut self,
        tracer: &Tracer<'_>,
        first: &Run,
        search: f64,
    ) -> Result<Vec<Shot>, BenchError> {
        let budgets = tracer
            .job
            .checkpoints
            .iter()
            .map(|&(frames, asked)| Budget {
                frames,
                asked,
                rays: first.rays(frames),
                seconds: first.seconds(frames),
            });
        let rays = tracer.trace(Kind::EqualRays, budgets.clone())?;
        let mut time = tracer.trace(Kind::EqualTime, budgets.clone())?;
        if search > 0.0 {
            let asked = budgets.filter(|budget| budget.asked);
            let goals: Vec<_> = asked
                .filter_map(|budget| Some((budget, first.errors(budget.frames)?)))
                .collect();
            // The longest of whole pictures tells best how long a ray takes in a longer one.
            let longest = time
                .iter()
                .chain(&rays)
                .max_by(|a, b| a.rays.total_cmp(&b.rays));
            let seconds_per_ray = longest.map_or(0.0, |t| t.seconds / t.rays.max(1.0));
            self.needed
                .push(needed(tracer, &goals, seconds_per_ray, search)?);
        }
        let shots = time.iter_mut().filter_map(|t| t.shot.take()).collect();
        self.equal_rays.push(rays);
        self.equal_time.push(time);
        Ok(shots)
    }
}

fn surfel_rows(options: &Options, checkpoints: &[(u32, bool)], runs: &[Vec<Run>]) -> Vec<Row> {
    let Some(first) = runs.first() else {
        return Vec::new();
    };
    let row = |(configuration, own): (&Configuration, &Vec<Run>)| {
        let after = checkpoints.iter().map(|&(frames, asked)| {
            let total_rays = Mean::of(own.iter().map(|run| run.rays(frames))).mean;
            let pairs = || own.iter().zip(first);
            let errors = |run: &Run| run.errors(frames).map_or(f64::NAN, |e| e.mape);
            After {
                frames,
                asked,
                errors: Errors::of(own.iter().filter_map(|run| run.errors(frames))),
                mape_ratio: Mean::of(pairs().map(|(run, first)| errors(run) / errors(first))),
                rays: total_rays / f64::from(frames),
                total_rays,
                milliseconds: Spread::of(own.iter().flat_map(|run| run.times(frames))).median * 1e3,
                seconds: Mean::of(own.iter().map(|run| run.seconds(frames))),
                ratio: Spread::of(pairs().flat_map(|(run, first)| run.ratios(first, frames))),
                taken: None,
                pareto: false,
            }
        });
        Row {
            name: configuration.name.clone(),
            about: configuration.about.clone(),
            kind: match configuration.element {
                Some(_) => Kind::Element,
                None => Kind::Settings,
            },
            after: after.collect(),
        }
    };
    options.configurations.iter().zip(runs).map(row).collect()
}
