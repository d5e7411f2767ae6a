//! `gibs replay`: one captured stage alone.
use super::CommandError;
use super::check::Way;
use super::output::{progress, say, warning};
use crate::check::{
    Capture, CaptureError, Comparison, Participant, Reduced, reduce, replay, verify,
};
use gibs_graph::{Backend, StageInfo};
use gibs_passes::stages;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Run a captured stage alone, compare with what was captured, and time it; exit 1 where it differs from what the first
/// participant of the capture made
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// File that `gibs check --report` or `gibs bisect` has written
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

#[derive(Serialize)]
struct Summary {
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

#[derive(Serialize)]
struct Shrunk {
    file: PathBuf,
    nonzero_bytes_before: u64,
    nonzero_bytes_after: u64,
    tried: u32,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let capture = Capture::read(&args.capture)?;
    let stages = stages::all();
    let backend = args.backend.open(false)?;
    let replayed = replay(&capture, &stages, backend.as_ref(), args.runs)?;
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
    let summary = Summary {
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
        against,
        reduced,
    };
    match args.json {
        true => say!(
            "{}",
            serde_json::to_string_pretty(&summary).unwrap_or_default()
        ),
        false => tell(&summary)?,
    }
    // What the first participant made is the oracle's.
    let Some(oracle) = capture.results.first() else {
        warning!(
            "{} holds no results to compare with",
            args.capture.display()
        );
        return Ok(());
    };
    let mut ports = summary.against.iter();
    match ports.any(|port| port.lane == oracle.lane && port.refused > 0) {
        false => Ok(()),
        true => Err(CommandError::Replay {
            stage: summary.stage,
            backend: summary.backend,
            oracle: oracle.lane.clone(),
        }),
    }
}

/// Shrinks the capture as long as the backend differs from the other one.
fn shrink(
    args: &Args,
    file: &Path,
    capture: &Capture,
    stages: &[StageInfo],
    backend: &dyn Backend,
) -> Result<Shrunk, CommandError> {
    let other = args.against.open(false)?;
    let differ = |candidate: &Capture| -> Result<bool, CaptureError> {
        let expected = replay(candidate, stages, other.as_ref(), 1)?;
        let found = replay(candidate, stages, backend, 1)?;
        let ports = verify(
            candidate,
            &expected.schedule,
            &expected.outputs,
            &found.outputs,
        );
        Ok(ports
            .iter()
            .any(|(_, found): &(String, Comparison)| !found.refused.is_empty()))
    };
    if !differ(capture)? {
        return Err(CommandError::NothingToReduce {
            capture: args.capture.clone(),
            a: args.against.name(),
            b: args.backend.name(),
        });
    }
    let bar = progress(u64::from(args.tries), "candidates");
    let Reduced {
        mut capture,
        nonzero,
        tried,
    } = reduce(capture, args.tries, |candidate| {
        bar.inc(1);
        // A stage may be unable to run on zeros in place of, say, a tree; that is no smaller case of the difference.
        Ok::<_, CaptureError>(differ(candidate).unwrap_or(false))
    })?;
    bar.finish_and_clear();
    for (name, backend) in [
        (args.against.name(), other.as_ref()),
        (args.backend.name(), backend),
    ] {
        let outputs = replay(&capture, stages, backend, 1)?.outputs;
        capture.add_results(Participant::named(name, backend), outputs);
    }
    capture.write(file)?;
    Ok(Shrunk {
        file: file.into(),
        nonzero_bytes_before: nonzero[0],
        nonzero_bytes_after: nonzero[1],
        tried,
    })
}

fn tell(summary: &Summary) -> Result<(), CommandError> {
    say!(
        "{} ({}) of frame {} of {} on {} ({})",
        summary.step,
        summary.stage,
        summary.frame,
        summary.case,
        summary.backend,
        summary.device
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
            port.lane,
            port.device,
            port.port,
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
            reduced.file.display(),
            reduced.nonzero_bytes_after,
            reduced.nonzero_bytes_before,
            reduced.tried
        );
    }
    Ok(())
}
