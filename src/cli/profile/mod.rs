//! `gibs profile`: time, work and memory of every stage.
mod live;

use super::CommandError;
use super::chosen::{self, Chosen, Opened};
use super::error::Failures;
use super::output::{say, warning};
use super::run::warn_of_no_light;
use super::scene::{Loaded, SceneArgs, SettingsArgs};
use crate::backends::NotRun;
use crate::gi::Gi;
use crate::picture::{ensure_writable, replace_file};
use crate::profile::{
    Comparison, FORMAT, Options, Profile, ProfileError, Saving, TimedFrame, beside, chrome_trace,
    compare, comparison_table, measure, saving_table, savings, signed_bytes, table,
};
use gibs_graph::{Backend, Schedule};
use gibs_passes::frame::{Screen, Settings};
use live::Live;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Measure time, work and memory of every stage
///
/// Every run starts from an empty cache with an executable of its own; what runs differ by is the noise. Every other measured frame
/// runs without timing its steps, which tells what timing costs.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// auto, cpu, wgpu, vulkan, or all that this machine has; several are measured one after the other, and compared
    #[arg(
        long,
        value_name = "BACKEND,..",
        value_delimiter = ',',
        default_value = "auto"
    )]
    backend: Vec<Chosen>,
    /// Frames of a run to measure
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    frames: u32,
    /// Frames of a run before that
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(0..=65_536))]
    warm_up: u32,
    /// Runs
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
    /// Seed of the first run's random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// Print every step of the frame, not stages
    #[arg(long)]
    steps: bool,
    /// Say what the scene and the settings need; of what is left out, also measure what that saves
    #[arg(long)]
    why: bool,
    /// Compare with a profile that `--json` printed earlier
    #[arg(long, value_name = "OLD.json")]
    against: Option<PathBuf>,
    /// Write the frames of the first run as a trace that Perfetto and Chrome open
    #[arg(long, value_name = "F.json")]
    trace: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// What `--json` prints, and [`Profile::read`] reads.
#[derive(Debug, Serialize)]
struct Printed<'a> {
    gibs_profile: u32,
    profiles: Vec<PrintedProfile<'a>>,
    /// Backends that were to be measured and are not there.
    not_run: &'a [NotRun],
    /// Backends that could not be measured.
    failed: &'a [NotRun],
}

/// A profile, with what is left out and what an older one says.
#[derive(Debug, Serialize)]
struct PrintedProfile<'a> {
    #[serde(flatten)]
    profile: &'a Profile,
    needs: &'a [Saving],
    /// What `--against` says.
    #[serde(skip_serializing_if = "Option::is_none")]
    against: Option<&'a Comparison>,
}

/// What was measured on one backend.
struct Measured {
    profile: Profile,
    needs: Vec<Saving>,
    frames: Vec<TimedFrame>,
    against: Option<Comparison>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let settings = args.settings.load()?;
    let old = args.against.as_deref().map(Profile::read).transpose()?;
    if let Some(path) = &args.trace {
        ensure_writable(path)?;
    }
    let Opened { backends, not_run } = chosen::open("--backend", &args.backend)?;
    let old = args.against.as_deref().zip(old.as_deref());
    if let Some((path, old)) = old {
        for backend in &backends {
            before(path, old, backend.name())?;
        }
    }
    let loaded = args.scene.load()?;
    let gi = Gi::new(
        &loaded.scene,
        &loaded.view,
        loaded.size,
        &settings,
        Screen::Traced,
    )?;
    for warning in &gi.scene().warnings {
        warning!("{warning}");
    }
    warn_of_no_light(&settings);
    let (mut all, mut failed) = (Vec::new(), Vec::new());
    let mut failures = Failures::default();
    for backend in &backends {
        match measured(backend.as_ref(), args, (&loaded, &settings), &gi, old) {
            Ok(measured) => all.push(measured),
            // What was measured is not lost when another backend fails.
            Err(error) => {
                failed.push(NotRun {
                    backend: backend.name().into(),
                    reason: error.to_string(),
                });
                failures.add(error);
            }
        }
    }
    if all.is_empty() {
        return failures.first();
    }
    if args.json {
        let profiles = all.iter().map(|measured| PrintedProfile {
            profile: &measured.profile,
            needs: &measured.needs,
            against: measured.against.as_ref(),
        });
        let printed = Printed {
            gibs_profile: FORMAT,
            profiles: profiles.collect(),
            not_run: &not_run,
            failed: &failed,
        };
        say!(
            "{}",
            serde_json::to_string_pretty(&printed).unwrap_or_default()
        );
    } else if all.len() > 1 {
        let profiles: Vec<&Profile> = all.iter().map(|measured| &measured.profile).collect();
        say!("{}", beside(&profiles));
    }
    if let Some(path) = &args.trace
        && let Err(error) = write_trace(path, gi.schedule(), &all)
    {
        failures.add(error);
    }
    failures.first()
}

/// Measures one backend, and prints it as text where that is wanted.
fn measured(
    backend: &dyn Backend,
    args: &Args,
    (loaded, settings): (&Loaded, &Settings),
    gi: &Gi,
    old: Option<(&Path, &[Profile])>,
) -> Result<Measured, CommandError> {
    let (profile, frames) = profile(backend, args, loaded, settings)?;
    if !args.json {
        say!("{}", table(&profile, args.steps));
    }
    let needs = savings_of(backend, gi, args, loaded)?;
    let compared = match old {
        Some((path, old)) => Some((path, before(path, old, &profile.backend)?)),
        None => None,
    };
    let against = compared.map(|(_, before)| compare(&profile, before));
    if !args.json {
        say!("{}", told(&needs, args.why));
        if let Some(((path, before), comparison)) = compared.zip(against.as_ref()) {
            say!(
                "against {}\n{}",
                path.display(),
                comparison_table(comparison, [profile.runs, before.runs])
            );
        }
    }
    Ok(Measured {
        profile,
        needs,
        frames,
        against,
    })
}

/// Measures one backend, with a live table of groups on a terminal.
fn profile(
    backend: &dyn Backend,
    args: &Args,
    loaded: &Loaded,
    settings: &Settings,
) -> Result<(Profile, Vec<TimedFrame>), CommandError> {
    let options = Options {
        size: loaded.size,
        runs: args.runs,
        frames: args.frames,
        warm_up: args.warm_up,
        seed: args.seed,
    };
    let mut live = Live::new(backend.name());
    let measured = measure(
        backend,
        (&args.scene.scene, &loaded.scene),
        &loaded.view,
        settings,
        &options,
        |progress| live.show(progress),
    );
    live.clear();
    Ok(measured?)
}

/// What the needs cost; in time only where that was asked for.
fn savings_of(
    backend: &dyn Backend,
    gi: &Gi,
    args: &Args,
    loaded: &Loaded,
) -> Result<Vec<Saving>, CommandError> {
    let on = args.why.then_some((backend, args.frames));
    let bar = super::output::progress(0, "measuring what is left out");
    let found = savings(gi, &loaded.view, on, |done, of| {
        bar.set_length(of.into());
        bar.set_position(done.into());
    });
    bar.finish_and_clear();
    Ok(found?)
}

/// What is left out: a line, or all that is known of it.
fn told(needs: &[Saving], why: bool) -> String {
    if why {
        return saving_table(needs, false);
    }
    let left_out = needs
        .iter()
        .map(|saving| &saving.need)
        .filter(|need| !need.present);
    let told: Vec<String> = left_out
        .map(|need| format!("{} ({})", need.name, signed_bytes(need.bytes)))
        .collect();
    match told.is_empty() {
        true => "nothing is left out\n".into(),
        false => format!("left out: {}; --why measures the time\n", told.join(", ")),
    }
}

/// The older profile of the same backend; where the file has only one, that one.
fn before<'a>(path: &Path, old: &'a [Profile], backend: &str) -> Result<&'a Profile, ProfileError> {
    let same = old.iter().find(|old| old.backend == backend);
    match (same, old) {
        (Some(same), _) => Ok(same),
        (None, [only]) => Ok(only),
        _ => Err(ProfileError::Backend {
            path: path.to_owned(),
            backend: backend.into(),
            found: old.iter().map(|old| old.backend.clone()).collect(),
        }),
    }
}

fn write_trace(
    path: &Path,
    schedule: &Arc<Schedule>,
    all: &[Measured],
) -> Result<(), CommandError> {
    let backends = all.iter().map(|measured| {
        let name = measured.profile.backend.as_str();
        (name, schedule.as_ref(), measured.frames.as_slice())
    });
    let backends: Vec<_> = backends.collect();
    replace_file(path, chrome_trace(&backends).as_bytes())?;
    Ok(())
}
