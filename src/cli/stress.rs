//! `gibs stress`: from an empty cache to converged.
use super::CommandError;
use super::error::Failures;
use super::output::{prepare_folder, progress, say};
use super::run::{Totals, checked, elsewhere, median, prepare};
use super::scene::{Loaded, SceneArgs, TechniqueArgs, ray_budget};
use crate::backends::{self, Choice};
use crate::conditions::{Renders, Subject};
use crate::measure::{
    Stress, StressError, StressRow, converged_from, csv, group_plot, or_empty, plot_of, stress,
};
use crate::picture::{Picture, replace_file};
use crate::plot::Axis;
use crate::words::{counted, scene_name};
use gibs_graph::Backend;
use gibs_passes::frame::Settings;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Measure how soon light converges from an empty cache, and what that costs
///
/// The stress test of the talk: from no surfel to converged. Surfels have no far plane and rays no longest distance.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Ray budgets of a frame; each is a run of its own [default: 100000]
    #[arg(long, value_name = "N,..", value_delimiter = ',', value_parser = ray_budget)]
    rays: Vec<u32>,
    #[command(flatten)]
    settings: TechniqueArgs,
    /// auto, cpu, wgpu or vulkan
    #[arg(long, default_value = "auto")]
    backend: Choice,
    /// Frames of a run
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    frames: u32,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// The truth (OpenEXR) to measure the error against, at its pixels' centres [default: the last frame of the run]
    #[arg(long, value_name = "REF.exr")]
    truth: Option<PathBuf>,
    /// Block error from which on the light counts as converged, once it stays below
    #[arg(long, value_name = "PERCENT", default_value_t = 5.0, value_parser = percent)]
    converged: f64,
    /// Write plots, and every frame as stress.csv, into this folder
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Print JSON, with every frame
    #[arg(long)]
    json: bool,
}

fn percent(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if value > 0.0 && f64::is_finite(value) => Ok(value),
        _ => Err("give a percentage above zero".into()),
    }
}

/// The run of one budget.
#[derive(Debug, Serialize)]
struct Run {
    #[serde(flatten)]
    subject: Subject,
    #[serde(flatten)]
    renders: Renders,
    seed: u32,
    budget: u32,
    /// What the error is against.
    against: String,
    /// Against a truth: from where on the picture is right, within the limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    converged: Option<Option<Converged>>,
    /// Against the last frame: from where on the picture stays what it is, right or not.
    #[serde(skip_serializing_if = "Option::is_none")]
    settled: Option<Option<Converged>>,
    /// The limit, as a fraction.
    limit: f64,
    totals: Totals,
    #[serde(flatten)]
    stress: Stress,
}

/// Where the error stays below the limit.
#[derive(Debug, Serialize)]
struct Converged {
    /// Frames that had to run.
    frames: usize,
    /// Their time, from the start of each until the device was done.
    seconds: f64,
}

/// The file in the folder of a report that has all figures.
const TABLE: &str = "stress.csv";

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let settings = args.settings.load(args.rays.first().copied())?;
    let mut budgets = Vec::new();
    for (index, budget) in args.rays.iter().enumerate() {
        // Twice the same would be one run, and one row of the report.
        if args.rays[..index].contains(budget) {
            continue;
        }
        let mut settings = settings.clone();
        settings.set("rays", &budget.to_string())?;
        budgets.push(settings);
    }
    if budgets.is_empty() {
        budgets.push(settings);
    }
    if let Some(folder) = &args.report {
        prepare_folder(folder, TABLE)?;
    }
    let truth = args
        .truth
        .as_ref()
        .map(|path| Picture::read_exr(path))
        .transpose()?;
    let backend = backends::open(args.backend)?;
    let loaded = args.scene.load()?;
    if let Some((path, truth)) = args.truth.as_ref().zip(truth.as_ref()) {
        elsewhere(backend.as_ref(), &loaded, truth, path)?;
    }
    let (mut runs, mut failures) = (Vec::new(), Failures::default());
    for settings in &budgets {
        // What was measured is not lost when another budget fails.
        match one(backend.as_ref(), &loaded, settings, truth.as_ref(), args) {
            Ok(run) => {
                if !args.json {
                    say!("{}", table(&run, args));
                }
                runs.push(run);
            }
            Err(error) => failures.add(error),
        }
    }
    if runs.is_empty() {
        return failures.first();
    }
    if args.json {
        say!(
            "{}",
            serde_json::to_string_pretty(&runs).unwrap_or_default()
        );
    }
    if let Some(folder) = &args.report
        && let Err(error) = write(folder, &scene_name(&args.scene.scene), &runs, args)
    {
        failures.add(error);
    }
    for run in &runs {
        if let Err(error) = run.totals.judge() {
            failures.add(error);
        }
    }
    failures.first()
}

/// The run of one budget.
fn one(
    backend: &dyn Backend,
    loaded: &Loaded,
    settings: &Settings,
    truth: Option<&Picture>,
    args: &Args,
) -> Result<Run, CommandError> {
    let settings = &checked(settings);
    let mut renderer = prepare(backend, loaded, settings, args.seed)?;
    let bar = progress(u64::from(args.frames), "rendering");
    let done = stress(&mut renderer, args.frames, truth, || bar.inc(1));
    bar.finish_and_clear();
    let stress = done.map_err(|error| match (error, &args.truth) {
        (StressError::Compare(source), Some(truth)) => CommandError::Truth {
            truth: truth.clone(),
            source,
        },
        (error, _) => error.into(),
    })?;
    // Without a truth the others are held against the last frame.
    let judged = stress
        .rows
        .len()
        .saturating_sub(usize::from(truth.is_none()));
    let errors = stress.rows[..judged].iter().map(|row| row.error);
    let converged = converged_from(errors, args.converged / 100.0).map(|first| Converged {
        frames: first + 1,
        seconds: stress.rows[..=first]
            .iter()
            .map(|row| row.frame.ms)
            .sum::<f64>()
            * 1e-3,
    });
    let (converged, settled) = match truth {
        Some(_) => (Some(converged), None),
        None => (None, Some(converged)),
    };
    Ok(Run {
        subject: Subject::new(&args.scene.scene, &loaded.view, loaded.size, settings),
        renders: Renders::with(backend),
        seed: args.seed,
        budget: settings.rays,
        against: match &args.truth {
            Some(truth) => truth.display().to_string(),
            None => "the last frame".into(),
        },
        converged,
        settled,
        limit: args.converged / 100.0,
        totals: Totals::of(settings.surfels, stress.rows.iter().map(|row| &row.frame)),
        stress,
    })
}

fn table(run: &Run, args: &Args) -> String {
    let rows = &run.stress.rows;
    let [width, height] = run.subject.size;
    let mut text = format!(
        "{} on {} ({}): {width}x{height}, {} rays a frame, no far plane\n",
        args.scene.scene, run.renders.backend, run.renders.device, run.budget
    );
    let limit = args.converged;
    // Its own last frame tells that a picture no longer changes, not that it is right.
    let word = if args.truth.is_some() {
        "converged"
    } else {
        "settled"
    };
    text += &match run.converged.iter().chain(&run.settled).flatten().next() {
        Some(at) => format!(
            "{word} after {}, {}: from there on the block error against {} stays below {limit} %\n",
            counted(at.frames as u64, "frame"),
            match at.seconds {
                short if short < 1.0 => format!("{:.1} ms", short * 1e3),
                long => format!("{long:.2} s"),
            },
            run.against
        ),
        None if rows.iter().all(|row| row.error.is_none()) => {
            format!(
                "no indirect light: there is no block error against {}\n",
                run.against
            )
        }
        None => format!(
            "not {word} after {} frames: the block error against {} does not stay below {limit} %\n",
            rows.len(),
            run.against
        ),
    };
    let totals = &run.totals;
    text += &format!(
        "{} births, {} starved, at most {} holes in crowded cells; most live {} of {}; {} slot errors\n",
        totals.births,
        totals.starved,
        totals.crowded,
        totals.most_live,
        totals.surfels,
        totals.slot_errors
    );
    text += "\nAfter so many frames: error, MAPE and live surfels; births and medians of times since the row above.\n frames      error    MAPE    live  births  frame ms";
    for group in &run.stress.groups {
        text += &format!(" {group:>10}");
    }
    // Stretches that double: most happens at the beginning.
    let (mut first, mut length) = (0, 1);
    while first < rows.len() {
        let part = &rows[first..(first + length).min(rows.len())];
        text += &("\n".to_owned() + &line(part, run.stress.groups.len()));
        first += part.len();
        length = first;
    }
    text + "\n"
}

/// Some frames: error and surfels after the last, medians of times, births in all.
fn line(part: &[StressRow], groups: usize) -> String {
    let Some(last) = part.last() else {
        return String::new();
    };
    let percent = |value: Option<f64>| match value {
        Some(value) => format!("{:6.2} %", value * 100.0),
        None => "       -".into(),
    };
    let births: u64 = part.iter().map(|row| u64::from(row.frame.births)).sum();
    let mut text = format!(
        "{:>7}   {} {} {:>7} {births:>7} {:>9}",
        last.frame.frame + 1,
        percent(last.error),
        percent(last.mape),
        last.frame.live,
        median(part.iter().map(|row| row.frame.ms), 1),
    );
    for group in 0..groups {
        let times = part.iter().filter_map(|row| row.frame.groups_ms.get(group));
        text += &format!(" {:>10}", median(times.copied(), 2));
    }
    text
}

fn write(folder: &Path, scene: &str, runs: &[Run], args: &Args) -> Result<(), CommandError> {
    let Some(first) = runs.first() else {
        return Ok(());
    };
    let rows = runs.iter().flat_map(|run| {
        run.stress.rows.iter().map(|row| {
            let after = [row.error, row.mape].map(or_empty);
            (vec![run.budget.to_string()], &row.frame, after.to_vec())
        })
    });
    let text = csv(&first.stress.groups, &["budget"], &["error", "mape"], rows);
    replace_file(&folder.join(TABLE), text.as_bytes())?;
    for run in runs {
        let title = format!(
            "{scene}: cost from an empty cache, {} rays a frame",
            run.budget
        );
        let frames = run.stress.rows.iter().map(|row| &row.frame);
        let plot = group_plot(&title, &run.stress.groups, frames);
        let name = format!("cost-{}.svg", run.budget);
        replace_file(&folder.join(name), plot.svg().as_bytes())?;
    }
    let curve = |run: &Run| {
        let point = |row: &StressRow| Some([f64::from(row.frame.frame + 1), row.error? * 100.0]);
        let points = run.stress.rows.iter().filter_map(point).collect();
        (format!("{} rays", run.budget), points)
    };
    let against = match args.truth {
        Some(_) => "the truth",
        None => "the last frame",
    };
    let title = format!("{scene}: error from an empty cache");
    let axis = Axis::log(format!("block error against {against}, %"));
    let plot = plot_of(&title, axis, runs.iter().map(curve).collect());
    replace_file(&folder.join("error.svg"), plot.svg().as_bytes())?;
    Ok(())
}
