//! `gibs render`: direct light and surfel indirect light.
use super::CommandError;
use super::output::{check_finite, default_out, progress, say, warning, write};
use super::scene::{SceneArgs, SettingsArgs};
use crate::Renderer;
use crate::backends::{self, Choice};
use crate::picture::{Format, ensure_writable};
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Render a scene: direct light, and indirect light from surfels
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// auto, cpu, wgpu or vulkan
    #[arg(long, default_value = "auto")]
    backend: Choice,
    /// Frames to render
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// Technique
    #[arg(long, default_value = "gibs", value_parser = ["gibs"])]
    technique: String,
    /// Where to write: .exr with all channels and a .png beside it, or .png alone [default: the scene's name]
    #[arg(long, value_name = "F.exr|F.png")]
    out: Option<PathBuf>,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
}

/// What a render did.
#[derive(Debug, Serialize)]
struct Summary {
    backend: String,
    device: String,
    size: [u32; 2],
    frames: u32,
    surfels: u32,
    surfels_without_slot: u32,
    grid_overflow: u32,
    bytes: u64,
    seconds_to_first_frame: f64,
    /// Mean over the frames after the first; none where there is only one.
    seconds_per_frame: Option<f64>,
    out: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let start = Instant::now();
    let settings = args.settings.load()?;
    let out = args
        .out
        .clone()
        .unwrap_or_else(|| default_out(&args.scene.scene));
    Format::of(&out)?;
    ensure_writable(&out)?;
    let backend = backends::open(args.backend)?;
    let loaded = args.scene.load()?;
    let mut renderer = Renderer::new(
        backend.as_ref(),
        &loaded.scene,
        &loaded.view,
        loaded.size,
        &settings,
        args.seed,
    )?;
    for warning in renderer.warnings() {
        warning!("{warning}");
    }
    let bar = progress(u64::from(args.frames), "rendering");
    renderer.frame()?;
    renderer.wait()?;
    let seconds_to_first_frame = start.elapsed().as_secs_f64();
    bar.inc(1);
    let steady = Instant::now();
    for _ in 1..args.frames {
        renderer.frame()?;
        bar.inc(1);
    }
    renderer.wait()?;
    bar.finish_and_clear();
    let seconds_per_frame = steady.elapsed().as_secs_f64() / f64::from(args.frames - 1).max(1.0);
    let picture = renderer.picture()?;
    write(&picture, &out, loaded.view.exposure)?;
    check_finite(&picture)?;
    let counters = renderer.counters()?;
    let summary = Summary {
        backend: backend.name().into(),
        device: backend.device().name.clone(),
        size: loaded.size,
        frames: args.frames,
        surfels: counters.live,
        surfels_without_slot: counters.starved,
        grid_overflow: counters.overflow,
        bytes: renderer
            .executable()
            .schedule()
            .bytes(backend.name() == "cpu"),
        seconds_to_first_frame,
        seconds_per_frame: (args.frames > 1).then_some(seconds_per_frame),
        out,
    };
    if args.json {
        say!(
            "{}",
            serde_json::to_string_pretty(&summary).unwrap_or_default()
        );
    } else {
        say!(
            "{} on {} ({}): {} frames of {}x{}, first after {:.2} s, then {:.1} ms each; {} surfels, {:.0} MB; wrote {}",
            args.scene.scene,
            summary.backend,
            summary.device,
            summary.frames,
            summary.size[0],
            summary.size[1],
            summary.seconds_to_first_frame,
            seconds_per_frame * 1e3,
            summary.surfels,
            summary.bytes as f64 / 1e6,
            summary.out.display()
        );
        if counters.starved > 0 {
            warning!(
                "{} births found no free surfel; raise `surfels`",
                counters.starved
            );
        }
        if counters.overflow > 0 {
            warning!(
                "{} entries did not fit the grid; raise `grid_lists`",
                counters.overflow
            );
        }
    }
    Ok(())
}
