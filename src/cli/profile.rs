//! `gibs profile`: time per stage.
use super::CommandError;
use super::output::{say, warning};
use super::scene::{SceneArgs, SettingsArgs};
use crate::Renderer;
use crate::backends::{self, Choice};
use serde::Serialize;

/// Measure the time of every stage
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// auto, cpu, wgpu or vulkan
    #[arg(long, default_value = "auto")]
    backend: Choice,
    /// Frames to measure, after as many to warm up
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// One step of the frame.
#[derive(Debug, Serialize)]
struct Row {
    step: String,
    median_ms: f64,
    share: f64,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let settings = args.settings.load()?;
    let backend = backends::open(args.backend)?;
    let loaded = args.scene.load()?;
    let mut renderer = Renderer::new(
        backend.as_ref(),
        &loaded.scene,
        &loaded.view,
        loaded.size,
        &settings,
        0,
    )?;
    for warning in renderer.warnings() {
        warning!("{warning}");
    }
    for _ in 0..args.frames {
        renderer.frame()?;
    }
    renderer.executable().measure(true);
    let steps = renderer.executable().schedule().steps.len();
    let mut times = vec![Vec::new(); steps];
    for _ in 0..args.frames {
        renderer.frame()?;
        for time in renderer.executable().timings()?.unwrap_or_default() {
            times[time.step].push(time.time.as_secs_f64() * 1e3);
        }
    }
    let median = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 2).copied().unwrap_or(0.0)
    };
    let medians: Vec<f64> = times.iter_mut().map(median).collect();
    let total: f64 = medians.iter().sum();
    let schedule = renderer.executable().schedule().clone();
    let rows: Vec<Row> = schedule
        .steps
        .iter()
        .zip(&medians)
        .map(|(step, &median_ms)| Row {
            step: step.label.clone(),
            median_ms,
            share: median_ms / total.max(1e-9),
        })
        .collect();
    if args.json {
        say!(
            "{}",
            serde_json::to_string_pretty(&rows).unwrap_or_default()
        );
        return Ok(());
    }
    say!(
        "{} on {}: {total:.2} ms a frame in {steps} steps",
        backend.name(),
        backend.device().name
    );
    for row in rows {
        say!(
            "{:>9.3} ms {:>5.1} %  {}",
            row.median_ms,
            row.share * 100.0,
            row.step
        );
    }
    Ok(())
}
