//! `gibs check`: every stage on every backend, from equal inputs.
mod expectations;
mod participants;
mod tell;

use super::CommandError;
use super::output::{prepare_folder, progress, say, warning};
use super::scene::{Loaded, SceneArgs};
use crate::builtin;
use crate::check::{
    Capture, Case, CheckOptions, Checked, Expectations, Participant, Plan, Summary, cases, check,
    html,
};
use crate::picture::replace_file;
use crate::view::View;
use clap::builder::NonEmptyStringValueParser;
use gibs_passes::scene::Scene;
use gibs_passes::stages;
use participants::{Opened, open};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use tell::tell;

pub use participants::Way;

/// Run every stage on every backend from equal inputs and report what differs; exit 1 on a difference
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// .gltf or .glb files, or built-in scenes [default: all built-in scenes]
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Participants, the first of which the others go on from: cpu-scalar, cpu, cpu-checked, vulkan, wgpu
    /// [default: all that this machine has but cpu-checked]
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    backends: Vec<Way>,
    /// Give wgpu and Vulkan the same SPIR-V words, and ask for equal bits of them
    #[arg(long)]
    same_spirv: bool,
    /// Only steps and stages of which the name contains this
    #[arg(long, value_name = "NAME", value_parser = NonEmptyStringValueParser::new())]
    stage: Option<String>,
    /// Compare the first N frames, instead of some early and some later ones up to the 77th
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_FRAMES))]
    frames: Option<u32>,
    /// Width and height of the pictures
    #[arg(long, value_name = "WxH", default_value = "48x27", value_parser = super::scene::size)]
    size: [u32; 2],
    /// Also the optional frames of every scene, not of the first alone
    #[arg(long)]
    all: bool,
    /// Camera, sun, sky and animation of the scenes that are files
    #[arg(long, value_name = "V.json")]
    view: Option<PathBuf>,
    /// Known differences (TOML); one that does not come is an error too
    #[arg(long, value_name = "FILE")]
    expectations: Option<PathBuf>,
    /// Write report.html, report.json and captures of differences here
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Also capture steps and stages of which the name contains this, in every frame that is compared, where all agree too
    #[arg(long, value_name = "NAME", requires = "report", value_parser = NonEmptyStringValueParser::new())]
    capture: Option<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Frames that are compared at most: each is kept in memory with what the host feeds it.
pub(super) const MOST_FRAMES: i64 = 65_536;

/// Captures that a report holds at most, of the first steps that differ.
const MOST_CAPTURES: usize = 16;

/// Captures that a report holds at most of steps that were asked for.
const MOST_ASKED: usize = 64;

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let expectations = match &args.expectations {
        Some(file) => expectations::load(file)?,
        None => Expectations::default(),
    };
    if let Some(folder) = &args.report {
        prepare_folder(folder, "report.html")?;
    }
    let Opened {
        backends,
        not_run,
        same_spirv,
    } = open(args)?;
    let participants: Vec<Participant<'_>> = backends
        .iter()
        .map(|(name, backend)| Participant::named(name, backend.as_ref()))
        .collect();
    let mut options = CheckOptions {
        stage: args.stage.clone(),
        captures: MOST_CAPTURES,
        capture: args.capture.clone(),
        captured: MOST_ASKED,
        ..CheckOptions::default()
    };
    if same_spirv {
        options.exact.push(("vulkan".into(), "wgpu".into()));
    }
    let scenes = load(args)?;
    let named: Vec<(&str, &(Scene, View))> = scenes
        .iter()
        .map(|(name, scene)| (name.as_str(), scene))
        .collect();
    let usual = Plan::default();
    let plan = Plan {
        size: args.size,
        frames: args.frames.map_or(usual.frames, |n| (0..n).collect()),
        all: args.all,
        ..usual
    };
    let oracle = participants.first().map(|p| p.backend);
    let mut cases = match oracle {
        Some(oracle) => cases(&named, &plan, oracle)?,
        None => Vec::new(),
    };
    let bar = progress((cases.len() * plan.frames.len()) as u64, "frames");
    let mut checked = check(&mut cases, &participants, &options, |_, _, _| bar.inc(1))?;
    bar.finish_and_clear();
    let unmet = expectations.apply(&mut checked.report);
    if args.view.is_some()
        && scenes
            .iter()
            .all(|(name, _)| builtin::by_name(name).is_some())
    {
        warning!("--view is for scenes that are files; built-in ones have views of their own");
    }
    let mut gaps = checked.report.gaps(&cases, &participants);
    if args.stage.is_some() {
        // Asked for a part of the steps, it leaves the others out.
        gaps.retain(|gap| gap.step.is_empty() || !gap.port.is_empty());
    }
    let unrun = stages_not_run(&cases);
    let captures = match &args.report {
        Some(folder) => write_captures(folder, checked.captures.iter().chain(&checked.asked))?,
        None => Vec::new(),
    };
    let summary = Summary {
        stage: args.stage.as_deref(),
        not_run: &not_run,
        stages_not_run: &unrun,
        captures: &captures,
        ..Summary::new(&checked.report, &gaps, &unmet)
    };
    if let Some(folder) = &args.report {
        let compact = serde_json::to_string(&summary).unwrap_or_default();
        replace_file(&folder.join("report.json"), compact.as_bytes())?;
        let page = html(&summary, &checked.captures, args.size);
        replace_file(&folder.join("report.html"), page.as_bytes())?;
    }
    match args.json {
        true => say!(
            "{}",
            serde_json::to_string_pretty(&summary).unwrap_or_default()
        ),
        false => tell(&summary)?,
    }
    warn(args, &checked, &summary);
    if let Some(folder) = &args.report {
        warn_of_others(folder, &captures);
    }
    match summary.passed {
        true => Ok(()),
        false => Err(CommandError::Check {
            differences: summary.differences(),
            gaps: gaps.len(),
            unmet: unmet.len(),
        }),
    }
}

/// What is not in the answer as it could have been.
fn warn(args: &Args, checked: &Checked, summary: &Summary<'_>) {
    if args.report.is_some() && checked.captures.len() == MOST_CAPTURES {
        warning!(
            "there are captures of the first {MOST_CAPTURES} steps that differ; name another with --stage for its own"
        );
    }
    if checked.asked_more {
        warning!(
            "--capture stops at {MOST_ASKED} captures; name a single step, one scene or fewer --frames for others"
        );
    }
    for missing in summary.not_run {
        warning!("not run: {}: {}", missing.name, missing.reason);
    }
    for expectation in summary.unmet {
        warning!(
            "`{}` on `{}` is expected to differ and did not: {}; take it off the list",
            expectation.stage,
            expectation.device,
            expectation.reason
        );
    }
}

/// Captures in the folder that are of an earlier report: they are not removed, since somebody may want them.
fn warn_of_others(folder: &Path, captures: &[PathBuf]) {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_other = |file: &PathBuf| {
        file.extension().is_some_and(|extension| extension == "npz") && !captures.contains(file)
    };
    let others = files.map(|file| file.path()).filter(is_other).count();
    if others > 0 {
        warning!(
            "{}: {others} captures there are not of this report, which lists its own",
            folder.display()
        );
    }
}

/// A scene by the name that it was asked for.
type Named = (String, (Scene, View));

fn load(args: &Args) -> Result<Vec<Named>, CommandError> {
    let mut scenes = Vec::new();
    if args.scenes.is_empty() {
        for (name, _) in builtin::names() {
            if let Some(scene) = builtin::by_name(name) {
                scenes.push(((*name).to_owned(), scene));
            }
        }
    }
    for (index, scene) in args.scenes.iter().enumerate() {
        if args.scenes[..index].contains(scene) {
            warning!("{scene} is named twice and checked once");
            continue;
        }
        let is_file = builtin::by_name(scene).is_none();
        let Loaded {
            scene: loaded,
            view,
            ..
        } = SceneArgs {
            scene: scene.clone(),
            view: args.view.clone().filter(|_| is_file),
            size: None,
        }
        .load()?;
        scenes.push((scene.clone(), (loaded, view)));
    }
    Ok(scenes)
}

fn stages_not_run(cases: &[Case<'_>]) -> Vec<&'static str> {
    let run: BTreeSet<&str> = cases
        .iter()
        .flat_map(|case| {
            case.schedule
                .dispatches()
                .map(|(.., dispatch)| dispatch.stage)
        })
        .collect();
    let all = stages::all().into_iter().map(|stage| stage.name);
    all.filter(|name| !run.contains(name)).collect()
}

/// Writes captures under names of their steps, with a number in front where two would have the same.
fn write_captures<'a>(
    folder: &Path,
    captures: impl Iterator<Item = &'a Capture>,
) -> Result<Vec<PathBuf>, CommandError> {
    let mut files = Vec::new();
    for (number, capture) in captures.enumerate() {
        let plain: String = format!("{}-{}", capture.case, capture.label)
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
            .collect();
        let mut file = folder.join(format!("{plain}-{}.npz", capture.frame));
        if files.contains(&file) {
            file = folder.join(format!("{number}-{plain}-{}.npz", capture.frame));
        }
        capture.write(&file)?;
        files.push(file);
    }
    Ok(files)
}
