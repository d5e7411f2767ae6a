//! `gibs check`: every stage on every backend, from equal inputs.
use super::CommandError;
use super::output::{prepare_folder, progress, say, warning};
use super::scene::{Loaded, SceneArgs};
use crate::backends::{self, Choice};
use crate::builtin;
use crate::check::{
    Capture, Case, CheckOptions, Expectation, Expectations, Gap, Participant, Plan, Report,
    Verdict, cases, check, html,
};
use crate::view::View;
use gibs_graph::{Backend, BackendError};
use gibs_passes::scene::Scene;
use gibs_passes::stages;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

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
    #[arg(long, value_name = "NAME")]
    stage: Option<String>,
    /// Compare the first N frames, instead of some early and some later ones up to the 77th
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
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
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A way to run a backend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// The processor's scalar kernels, one by one the oracle.
    Scalar,
    /// The processor's kernels as they are used.
    Cpu,
    /// The same, with workgroups in another order and a map of who writes what.
    Checked,
    /// Vulkan through ash.
    Vulkan,
    /// wgpu.
    Wgpu,
}

const WAYS: [(&str, Way); 5] = [
    ("cpu-scalar", Way::Scalar),
    ("cpu", Way::Cpu),
    ("cpu-checked", Way::Checked),
    ("vulkan", Way::Vulkan),
    ("wgpu", Way::Wgpu),
];

impl std::str::FromStr for Way {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = WAYS.iter().find(|(known, _)| *known == name);
        found.map(|(_, way)| *way).ok_or_else(|| {
            let names: Vec<_> = WAYS.iter().map(|(name, _)| *name).collect();
            format!("choose of {}", names.join(", "))
        })
    }
}

impl Way {
    pub fn name(self) -> &'static str {
        let found = WAYS.iter().find(|(_, way)| *way == self);
        found.map_or("", |(name, _)| name)
    }

    /// Opens it; wgpu with the SPIR-V that Vulkan gets, where that is asked for.
    pub fn open(self, same_spirv: bool) -> Result<Box<dyn Backend>, BackendError> {
        match self {
            #[cfg(feature = "cpu")]
            Way::Scalar | Way::Checked => {
                let options = gibs_backend_cpu::Options {
                    threads: None,
                    scalar: self == Way::Scalar,
                    checked: self == Way::Checked,
                };
                Ok(Box::new(gibs_backend_cpu::CpuBackend::new(options)?))
            }
            #[cfg(not(feature = "cpu"))]
            Way::Scalar | Way::Checked => backends::open(Choice::Cpu),
            Way::Cpu => backends::open(Choice::Cpu),
            Way::Vulkan => backends::open(Choice::Vulkan),
            #[cfg(feature = "wgpu")]
            Way::Wgpu if same_spirv => {
                let options = gibs_backend_wgpu::Options {
                    same_spirv,
                    ..Default::default()
                };
                Ok(Box::new(gibs_backend_wgpu::WgpuBackend::new(options)?))
            }
            Way::Wgpu => {
                // Without the backend, what it would be given does not matter.
                let _ = same_spirv;
                backends::open(Choice::Wgpu)
            }
        }
    }
}

/// What the command prints as JSON and writes to `report.json`.
#[derive(Serialize)]
struct Summary<'a> {
    verdict: Verdict,
    /// Participants that were meant to be there, and why they are not.
    not_run: &'a [NotRun],
    /// Stages of this program that no case runs.
    stages_not_run: &'a [&'static str],
    gaps: &'a [Gap],
    /// Differences that are expected and did not come.
    unmet: &'a [&'a Expectation],
    report: &'a Report,
    captures: &'a [PathBuf],
}

/// A participant that is missing.
#[derive(Debug, Serialize)]
struct NotRun {
    name: String,
    reason: String,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let expectations = match &args.expectations {
        Some(file) => load_expectations(file)?,
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
        captures: 16,
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
    // Asked for a part, it is a part; asked for everything, it has to be that.
    let gaps = match args.stage {
        Some(_) => Vec::new(),
        None => checked.report.gaps(&cases),
    };
    let unrun = stages_not_run(&cases);
    let captures = match &args.report {
        Some(folder) => write_captures(folder, &checked.captures)?,
        None => Vec::new(),
    };
    let summary = Summary {
        verdict: checked.report.verdict(),
        not_run: &not_run,
        stages_not_run: &unrun,
        gaps: &gaps,
        unmet: &unmet,
        report: &checked.report,
        captures: &captures,
    };
    let json = serde_json::to_string_pretty(&summary).unwrap_or_default();
    if let Some(folder) = &args.report {
        let compact = serde_json::to_string(&summary).unwrap_or_default();
        super::output::write_text(&folder.join("report.json"), &compact)?;
        super::output::write_text(
            &folder.join("report.html"),
            &html(&checked.report, &checked.captures, &unmet, args.size),
        )?;
    }
    match args.json {
        true => say!("{json}"),
        false => tell(&summary)?,
    }
    for missing in &not_run {
        warning!("not run: {}: {}", missing.name, missing.reason);
    }
    for expectation in &unmet {
        warning!(
            "`{}` on `{}` is expected to differ and did not: {}; take it off the list",
            expectation.stage,
            expectation.device,
            expectation.reason
        );
    }
    let differences = checked
        .report
        .pairs()
        .filter(|(.., p)| p.verdict == Verdict::Differs)
        .count();
    match differences + gaps.len() + unmet.len() {
        0 => Ok(()),
        _ => Err(CommandError::Check {
            differences,
            gaps: gaps.len(),
            unmet: unmet.len(),
        }),
    }
}

/// The participants, and what could not be had.
struct Opened {
    backends: Vec<(&'static str, Box<dyn Backend>)>,
    not_run: Vec<NotRun>,
    /// wgpu runs the SPIR-V that Vulkan gets.
    same_spirv: bool,
}

/// Opens the participants. One that was named has to be there; of those that nobody named, the others are left out.
fn open(args: &Args) -> Result<Opened, CommandError> {
    let usual = [Way::Scalar, Way::Cpu, Way::Vulkan, Way::Wgpu];
    let asked = match args.backends.is_empty() {
        true => &usual[..],
        false => &args.backends,
    };
    let mut opened = Opened {
        backends: Vec::new(),
        not_run: Vec::new(),
        same_spirv: args.same_spirv,
    };
    let missing = |name: &str, error: BackendError| NotRun {
        name: name.into(),
        reason: error.to_string(),
    };
    for &way in asked {
        let mut found = way.open(args.same_spirv);
        if let (Way::Wgpu, true, Err(_)) = (way, args.same_spirv, &found) {
            // Without that, it can still be compared as it usually runs.
            let plain = way.open(false);
            if let (Ok(_), Err(error)) = (&plain, found) {
                let name = "wgpu with the SPIR-V of vulkan";
                opened.not_run.push(missing(name, error));
                opened.same_spirv = false;
            }
            found = plain;
        }
        match found {
            Ok(backend) => opened.backends.push((way.name(), backend)),
            Err(error) if !args.backends.is_empty() => return Err(error.into()),
            Err(error) => opened.not_run.push(missing(way.name(), error)),
        }
    }
    let has = |name| opened.backends.iter().any(|(known, _)| *known == name);
    if opened.same_spirv && !(has("vulkan") && has("wgpu")) {
        opened.same_spirv = false;
        opened.not_run.push(NotRun {
            name: "wgpu with the SPIR-V of vulkan".into(),
            reason: "it takes both of them".into(),
        });
    }
    Ok(opened)
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
    for scene in &args.scenes {
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

fn load_expectations(file: &Path) -> Result<Expectations, CommandError> {
    let wrong = |problem: String| {
        CommandError::CheckKit(crate::check::CheckError::Expectations {
            file: file.into(),
            problem,
        })
    };
    let text = std::fs::read_to_string(file).map_err(|e| wrong(e.to_string()))?;
    let expectations: Expectations = toml::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    for expectation in &expectations.expected {
        if let Some(problem) = problem_with(expectation) {
            return Err(wrong(problem));
        }
    }
    Ok(expectations)
}

/// What could never come, or would excuse everything.
fn problem_with(expectation: &Expectation) -> Option<String> {
    let said = [
        ("device", &expectation.device),
        ("reason", &expectation.reason),
    ];
    if let Some((name, _)) = said.iter().find(|(_, text)| text.trim().is_empty()) {
        return Some(format!("`{name}` is empty"));
    }
    if let Some(backend) = &expectation.backend
        && !WAYS.iter().any(|(name, _)| name.starts_with(backend))
    {
        let names = WAYS.map(|(name, _)| name).join(", ");
        return Some(format!("no backend is called `{backend}`: {names}"));
    }
    let stages = stages::all();
    let Some(stage) = stages.iter().find(|stage| stage.name == expectation.stage) else {
        return Some(format!(
            "no stage has the type name `{}`; reports show it beside each step",
            expectation.stage
        ));
    };
    let written = stage.ports.iter().filter(|port| port.access.writes());
    let written: Vec<_> = written.map(|port| port.name).collect();
    match &expectation.port {
        Some(port) if !written.contains(&port.as_str()) => Some(format!(
            "`{}` writes no port `{port}`, but {}",
            stage.name,
            written.join(", ")
        )),
        _ => None,
    }
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

/// Writes captures under names of their steps.
fn write_captures(folder: &Path, captures: &[Capture]) -> Result<Vec<PathBuf>, CommandError> {
    let mut files = Vec::new();
    for capture in captures {
        let plain: String = format!("{}-{}", capture.case, capture.label)
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
            .collect();
        let file = folder.join(format!("{plain}-{}.npz", capture.frame));
        capture.write(&file)?;
        files.push(file);
    }
    Ok(files)
}

/// The table: a line for every pair at every port that is not equal everywhere, and what is equal in one.
fn tell(summary: &Summary<'_>) -> Result<(), CommandError> {
    let report = summary.report;
    for lane in &report.lanes {
        say!(
            "{}: {} ({})",
            lane.name,
            lane.device.name,
            lane.device.driver
        );
    }
    let mut equal = 0;
    for (case, step, port, pair) in report.pairs() {
        if pair.verdict == Verdict::Equal {
            equal += 1;
            continue;
        }
        let verdict = format!("{:?}", pair.verdict).to_lowercase();
        say!(
            "{verdict:<9} {}: {} {} ({} and {}): {} of {} elements unequal, {} undecided, {} refused",
            case.name,
            step.label,
            port.port,
            pair.a,
            pair.b,
            pair.unequal,
            pair.elements,
            pair.undecided,
            pair.refused
        );
        if let Some((frame, worst)) = &pair.worst {
            say!(
                "          worst in frame {frame}, element {}{}: {} and {} ({:.1} ULP, relative {:.2e}); {}",
                worst.element,
                worst.field,
                worst.a,
                worst.b,
                worst.ulps,
                worst.relative,
                comparator(&port.comparator)
            );
        }
    }
    for gap in summary.gaps {
        say!("not looked at: {gap}");
    }
    for capture in summary.captures {
        say!("capture: {}", capture.display());
    }
    if !summary.stages_not_run.is_empty() {
        say!("no case runs {}", summary.stages_not_run.join(", "));
    }
    let ports = report.pairs().count();
    say!(
        "{equal} of {ports} comparisons of a port on a pair equal to the bit, {} elements in {} cases: {:?}",
        report.elements(),
        report.cases.len(),
        summary.verdict
    );
    Ok(())
}

fn comparator(comparator: &gibs_graph::Comparator) -> String {
    format!("{:?}: {}", comparator.floats, comparator.reason)
}
