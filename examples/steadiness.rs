//! Flicker of converged light, and how soon it is gone when its source goes out, in one run with one set of settings.
//!
//! ```sh
//! cargo run --release --example steadiness -- SCENE --view V.json
//! ```
//!
//! `docs/accuracy.md` has figures.
#[path = "steadiness/measure.rs"]
mod measure;
#[path = "shared/scene.rs"]
mod scene;

use clap::Parser;
use gibs::Renderer;
use gibs::backends::{self, Choice};
use gibs::passes::frame::Settings;
use measure::Frames;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// Flicker of converged light, and how soon it is gone when its source goes out
#[derive(Parser)]
struct Args {
    /// A .gltf or .glb file, or a built-in scene
    scene: String,
    /// Camera, sun, sky and animation [default: the scene's own]
    #[arg(long, value_name = "V.json")]
    view: Option<PathBuf>,
    /// Width of the picture
    #[arg(long, default_value_t = 480)]
    width: u32,
    /// Height of the picture
    #[arg(long, default_value_t = 270)]
    height: u32,
    /// Frames until the light counts as converged
    #[arg(long, default_value_t = 256)]
    settle: u32,
    /// auto, cpu, wgpu or vulkan
    #[arg(long, default_value = "cpu")]
    backend: Choice,
    /// A setting, as KEY=VALUE
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    let (scene, view) = scene::load(&args.scene, args.view.as_deref())?;
    let backend = backends::open(args.backend)?;
    let mut settings = Settings::default();
    for pair in &args.set {
        let (key, value) = pair.split_once('=').ok_or("give settings as KEY=VALUE")?;
        settings.set(key, value)?;
    }
    let size = [args.width, args.height];
    let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, size, &settings, 0)?;
    let frames = Frames {
        settle: args.settle,
        watch: 16,
        dark: 60,
        end: 200,
    };
    let found = measure::measure(&mut renderer, &scene, &view, frames)?;
    let [mean, p99] = found.flicker.map(|share| 100.0 * share);
    println!(
        "flicker after {} frames: mean {mean:.3} %, 99th percentile {p99:.2} %",
        args.settle
    );
    let [lit, dark] = found.means;
    println!("mean E {lit:.4} W/m^2, without the light {dark:.4}");
    for frame in [5, 10, 15, 20, 30, 45, 60] {
        let left = found
            .left
            .get(frame - 1)
            .map_or(f64::NAN, |left| 100.0 * left);
        println!("{frame:>3} frames after the light went out: {left:.2} % left");
    }
    match found.gone(0.05) {
        Some(frames) => println!("95 % gone after {frames} frames"),
        None => println!("more than 5 % left after {} frames", found.left.len()),
    }
    Ok(())
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}
