//! `gibs reference`: path-traced ground truth.
use super::CommandError;
use super::output::{check_finite, default_out, progress, say, warning, write};
use super::scene::SceneArgs;
use crate::backends::{self, Choice};
use crate::picture::{Format, ensure_writable};
use crate::reference::{ReferenceOptions, reference};
use std::path::PathBuf;
use std::time::Instant;

/// Path-trace ground truth, with its standard error
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// auto, cpu, wgpu or vulkan
    #[arg(long, default_value = "auto")]
    backend: Choice,
    /// Samples per pixel
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    spp: u32,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// Find emitters and the sky by chance alone, without samples of their own
    #[arg(long)]
    brute_force: bool,
    /// Where to write [default: the scene's name, .exr]
    #[arg(long, value_name = "F.exr")]
    out: Option<PathBuf>,
    /// Print the certainty as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let start = Instant::now();
    let out = args
        .out
        .clone()
        .unwrap_or_else(|| default_out(&args.scene.scene));
    if Format::of(&out)? != Format::Exr {
        let want =
            "ground truth needs all its channels; name a .exr file, a .png comes beside it".into();
        return Err(CommandError::Value {
            option: "--out",
            value: out.display().to_string(),
            want,
        });
    }
    ensure_writable(&out)?;
    let backend = backends::open(args.backend)?;
    let loaded = args.scene.load()?;
    let options = ReferenceOptions {
        size: loaded.size,
        samples: args.spp,
        seed: args.seed,
        emitters: !args.brute_force,
    };
    // How many segments paths have is not known before; three per sample is usual.
    let bar = progress(u64::from(args.spp) * 3, "path tracing");
    let rendered = reference(
        backend.as_ref(),
        &loaded.scene,
        &loaded.view,
        &options,
        |frames, _| {
            bar.set_length(bar.length().unwrap_or(0).max(u64::from(frames)));
            bar.set_position(u64::from(frames));
        },
    );
    bar.finish_and_clear();
    let (picture, certainty) = rendered?;
    for warning in &certainty.warnings {
        warning!("{warning}");
    }
    write(&picture, &out, loaded.view.exposure)?;
    check_finite(&picture)?;
    if args.json {
        say!(
            "{}",
            serde_json::to_string_pretty(&certainty).unwrap_or_default()
        );
    } else {
        say!(
            "{} on {} ({}): {} samples per pixel of {}x{} in {:.1} s; standard error {:.2} % per pixel, {:.2} % per \
             8x8 block; {} fireflies; wrote {}",
            args.scene.scene,
            backend.name(),
            backend.device().name,
            certainty.samples,
            loaded.size[0],
            loaded.size[1],
            start.elapsed().as_secs_f64(),
            certainty.standard_error * 100.0,
            certainty.standard_error * 100.0 / 8.0,
            certainty.fireflies,
            out.display()
        );
    }
    Ok(())
}
