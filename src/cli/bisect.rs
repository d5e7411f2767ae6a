//! `gibs bisect`: where two backends part.
use super::CommandError;
use super::check::{MOST_FRAMES, Way};
use super::output::{progress, say};
use super::scene::{SceneArgs, SettingsArgs};
use crate::check::{Difference, Participant, Way as How, bisect, surfels};
use crate::picture::ensure_writable;
use crate::words::counted;
use serde::Serialize;
use std::path::PathBuf;

/// Find the first frame, stage, port and element where two backends part; exit 1 where they do
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// cpu-scalar, cpu, cpu-checked, vulkan or wgpu: its values count
    #[arg(long, value_name = "BACKEND")]
    a: Way,
    /// The one that is held against it
    #[arg(long, value_name = "BACKEND")]
    b: Way,
    /// Frames to look at
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=MOST_FRAMES))]
    frames: u32,
    /// Take the first bit that differs, also where the comparators of the stages allow it
    #[arg(long)]
    exact: bool,
    /// Where the capture of the stage goes
    #[arg(long, value_name = "F.npz", default_value = "bisect.npz")]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Summary<'a> {
    frames: u32,
    parted: Option<Parted<'a>>,
}

#[derive(Serialize)]
struct Parted<'a> {
    frame: u32,
    step: &'a str,
    stage: &'a str,
    port: &'a str,
    resource: &'a str,
    /// From equal inputs; otherwise differences that are allowed have added up.
    from_equal_inputs: bool,
    refused: u64,
    elements: u64,
    difference: &'a Difference,
    capture: Option<&'a PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    ensure_writable(&args.out)?;
    let settings = args.settings.load()?;
    let loaded = args.scene.load()?;
    let backends = [args.a.open(false)?, args.b.open(false)?];
    let names = [args.a.name(), args.b.name()];
    let scene = (loaded.scene, loaded.view);
    let mut case = surfels(
        &args.scene.scene,
        &scene,
        loaded.size,
        0..args.frames,
        &settings,
    )?;
    let participants = [0, 1].map(|i| Participant::named(names[i], backends[i].as_ref()));
    let bar = progress(u64::from(args.frames), "frames");
    let parting = bisect(&mut case, participants, args.exact, |_, _| bar.inc(1))?;
    bar.finish_and_clear();
    let capture = parting
        .as_ref()
        .and_then(|parting| parting.capture.as_ref());
    let summary = Summary {
        frames: args.frames,
        parted: parting.as_ref().map(|parting| Parted {
            frame: parting.frame,
            step: &parting.label,
            stage: &parting.stage,
            port: &parting.port,
            resource: &parting.resource,
            from_equal_inputs: parting.way == How::Stage,
            refused: parting.refused,
            elements: parting.elements,
            difference: &parting.difference,
            capture: capture.map(|_| &args.out),
        }),
    };
    if args.json {
        say!(
            "{}",
            serde_json::to_string_pretty(&summary).unwrap_or_default()
        );
    } else {
        tell(&summary, names)?;
    }
    // After the answer, which is not lost where the file cannot be written.
    if let Some(capture) = capture {
        capture.write(&args.out)?;
    }
    match summary.parted {
        None => Ok(()),
        Some(_) => Err(CommandError::Parted {
            a: names[0],
            b: names[1],
        }),
    }
}

fn tell(summary: &Summary<'_>, [a, b]: [&str; 2]) -> Result<(), CommandError> {
    let Some(parted) = &summary.parted else {
        say!(
            "{a} and {b} agree over {}",
            counted(summary.frames, "frame")
        );
        return Ok(());
    };
    say!(
        "frame {}, {} ({}), port {} (`{}`): {} of {} elements differ",
        parted.frame,
        parted.step,
        parted.stage,
        parted.port,
        parted.resource,
        parted.refused,
        parted.elements
    );
    let Difference {
        element,
        field,
        a: on_a,
        b: on_b,
        ulps,
        relative,
        ..
    } = parted.difference;
    say!(
        "element {element}{field}: {on_a} on {a}, {on_b} on {b} ({ulps:.1} ULP, relative {relative:.2e})"
    );
    match parted.from_equal_inputs {
        true => say!("from equal inputs: the stage itself differs"),
        false => say!(
            "from equal inputs every stage of the frame agrees: allowed differences have added up"
        ),
    }
    if let Some(capture) = parted.capture {
        say!(
            "capture: {}; run it alone with `gibs replay`",
            capture.display()
        );
    }
    Ok(())
}
