//! `gibs replay`: one captured stage alone.
mod shrink;

use super::CommandError;
use super::check::Way;
use super::output::say;
use crate::check::{Capture, CaptureError, replay, verify};
use crate::picture::ensure_writable;
use crate::words::printable;
use gibs_passes::stages;
use serde::Serialize;
use shrink::{Shrunk, shrink};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Run a captured stage alone, compare with what was captured, and time it; exit 1 where it differs from what the first
/// participant of the capture made
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// File that `gibs check --report`, with --capture where nothing differs, or `gibs bisect` has written
    #[arg(value_name = "CAPTURE.npz")]
    capture: PathBuf,
    /// cpu-scalar, cpu, cpu-checked, vulkan or wgpu
    #[arg(long, value_name = "BACKEND")]
    backend: Way,
    /// How often it runs
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
    /// Write a smaller capture on which the backend still differs from --against
    #[arg(long, value_name = "F.npz")]
    reduce: Option<PathBuf>,
    /// Backend whose values count while reducing
    #[arg(
        long,
        value_name = "BACKEND",
        default_value = "cpu-scalar",
        requires = "reduce"
    )]
    against: Way,
    /// Most candidates that are tried while reducing
    #[arg(long, value_name = "N", default_value_t = 4000)]
    tries: u32,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// What a replayed stage gives, against what the first participant of the capture made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Verdict {
    /// The same bits.
    Equal,
    /// What the ports' comparators allow.
    Within,
    /// Something else, or something else than the backend that it is reduced against.
    Differs,
    /// The capture holds no results.
    Unchecked,
}

#[derive(Serialize)]
struct Summary {
    verdict: Verdict,
    /// Nothing differs, something was compared, and what is only read was left as it was.
    passed: bool,
    case: String,
    frame: u32,
    step: String,
    stage: String,
    backend: &'static str,
    device: String,
    runs: u32,
    median_us: f64,
    fastest_us: f64,
    /// Every run gave the bits of the first.
    repeatable: bool,
    /// Buffers that it only reads and changed.
    scribbled: Vec<String>,
    /// Port by port against each result that the capture has.
    against: Vec<Against>,
    reduced: Option<Shrunk>,
}

#[derive(Serialize)]
struct Against {
    lane: String,
    device: String,
    port: String,
    elements: u64,
    unequal: u64,
    refused: u64,
    worst: Option<crate::check::Difference>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let capture = Capture::read(&args.capture)?;
    if let Some(file) = &args.reduce {
        ensure_writable(file)?;
        let resolved = |file: &Path| std::fs::canonicalize(file).ok();
        if resolved(file).is_some_and(|file| Some(file) == resolved(&args.capture)) {
            return Err(CommandError::ReducedOntoItself { file: file.clone() });
        }
    }
    let stages = stages::all();
    let backend = args.backend.open(false)?;
    let replayed = replay(&capture, &stages, backend.as_ref(), args.runs)
        .map_err(|error| of_file(&args.capture, error))?;
    let mut against = Vec::new();
    for origin in &capture.results {
        let found = verify(
            &capture,
            &replayed.schedule,
            &origin.outputs,
            &replayed.outputs,
        );
        against.extend(found.into_iter().map(|(port, found)| Against {
            lane: origin.lane.clone(),
            device: origin.device.clone(),
            port,
            elements: found.elements,
            unequal: found.unequal,
            refused: found.refused.len() as u64,
            worst: found.worst,
        }));
    }
    let reduced = match &args.reduce {
        Some(file) => Some(shrink(args, file, &capture, &stages, backend.as_ref())?),
        None => None,
    };
    let mut times = replayed.times.clone();
    times.sort_unstable();
    let micros = |time: Option<&Duration>| time.map_or(0.0, |t| t.as_secs_f64() * 1e6);
    let oracle = capture.results.first().map(|oracle| oracle.lane.as_str());
    let verdict = match reduced {
        Some(_) => Verdict::Differs,
        None => judged(oracle, &against),
    };
    let summary = Summary {
        verdict,
        passed: matches!(verdict, Verdict::Equal | Verdict::Within)
            && replayed.scribbled.is_empty(),
        case: capture.case.clone(),
        frame: capture.frame,
        step: capture.label.clone(),
        stage: capture.stage.clone(),
        backend: args.backend.name(),
        device: backend.device().name.clone(),
        runs: args.runs,
        median_us: micros(times.get(times.len() / 2)),
        fastest_us: micros(times.first()),
        repeatable: replayed.repeatable,
        scribbled: replayed.scribbled,
        against,
        reduced,
    };
    match args.json {
        true => say!(
            "{}",
            serde_json::to_string_pretty(&summary).unwrap_or_default()
        ),
        false => tell(&summary, oracle)?,
    }
    if !summary.scribbled.is_empty() {
        return Err(CommandError::Scribbled {
            stage: summary.stage,
            backend: summary.backend,
            buffers: summary.scribbled,
        });
    }
    if let Some(reduced) = summary.reduced {
        return Err(CommandError::Reduced {
            stage: summary.stage,
            backend: summary.backend,
            other: args.against.name(),
            file: reduced.file,
        });
    }
    match (verdict, oracle) {
        (Verdict::Equal | Verdict::Within, _) => Ok(()),
        (Verdict::Differs, Some(oracle)) => Err(CommandError::Replay {
            stage: summary.stage,
            backend: summary.backend,
            oracle: oracle.into(),
        }),
        _ => Err(CommandError::NoResults {
            capture: args.capture.clone(),
            stage: summary.stage,
        }),
    }
}

/// What the first participant made is the oracle's.
fn judged(oracle: Option<&str>, against: &[Against]) -> Verdict {
    let Some(oracle) = oracle else {
        return Verdict::Unchecked;
    };
    let ports = || against.iter().filter(|port| port.lane == oracle);
    match (
        ports().any(|port| port.refused > 0),
        ports().any(|port| port.unequal > 0),
    ) {
        (true, _) => Verdict::Differs,
        (_, true) => Verdict::Within,
        _ if ports().next().is_none() => Verdict::Unchecked,
        _ => Verdict::Equal,
    }
}

/// An error of a capture, with the file that it is of.
fn of_file(file: &Path, error: CaptureError) -> CommandError {
    let capture = file.to_owned();
    match error {
        CaptureError::UnknownStage { stage } => CommandError::NoSuchStage { capture, stage },
        CaptureError::Changed { stage, problem } => CommandError::StageChanged {
            capture,
            stage,
            problem,
        },
        error => error.into(),
    }
}

fn tell(summary: &Summary, oracle: Option<&str>) -> Result<(), CommandError> {
    say!(
        "{} ({}) of frame {} of {} on {} ({})",
        printable(&summary.step),
        printable(&summary.stage),
        summary.frame,
        printable(&summary.case),
        summary.backend,
        printable(&summary.device)
    );
    say!(
        "{} runs, median {:.1} us, fastest {:.1} us, {}",
        summary.runs,
        summary.median_us,
        summary.fastest_us,
        match summary.repeatable {
            true => "all with the same bits",
            false => "with bits that change from run to run",
        }
    );
    for port in &summary.against {
        say!(
            "against {} ({}), {}: {} of {} elements unequal, {} refused",
            printable(&port.lane),
            printable(&port.device),
            printable(&port.port),
            port.unequal,
            port.elements,
            port.refused
        );
        if let Some(worst) = port.worst.as_ref().filter(|_| port.unequal > 0) {
            say!(
                "  worst at element {}{}: {} there, {} here",
                worst.element,
                worst.field,
                worst.a,
                worst.b
            );
        }
    }
    if let Some(reduced) = &summary.reduced {
        say!(
            "{}: {} of {} bytes of input are not zero, after {} candidates",
            printable(&reduced.file.display().to_string()),
            reduced.nonzero_bytes_after,
            reduced.nonzero_bytes_before,
            reduced.tried
        );
    }
    if summary.reduced.is_some() {
        say!("failed: the two backends differ on it");
        return Ok(());
    }
    match (summary.verdict, oracle.map(printable)) {
        (Verdict::Equal, Some(oracle)) => say!("passed: the bits that {oracle} made of it"),
        (Verdict::Within, Some(oracle)) => {
            say!("passed: within what the comparators allow of what {oracle} made of it");
        }
        (Verdict::Differs, Some(oracle)) => say!("failed: not what {oracle} made of it"),
        _ => say!("nothing was checked: the capture holds no results"),
    }
    Ok(())
}
