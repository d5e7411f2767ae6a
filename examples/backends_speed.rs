//! How soon each backend shows a first frame, and how long a frame takes after that.
//!
//! ```sh
//! cargo build --release && cargo run --release --example backends_speed -- SCENE --view V.json
//! ```
//!
//! First frames are those of processes of their own, `gibs render --json`, with empty caches of compiled shaders and
//! with filled ones. Frames after the first are those of one process in which backends take turns, frame by frame:
//! whatever else the machine does then falls on all of them. Times are medians, ratios medians of the ratios between
//! neighbours in time. Nothing is asserted. `docs/performance.md` has figures.
#[path = "backends_speed/frames.rs"]
mod frames;
#[path = "shared/scene.rs"]
mod scene;
#[path = "backends_speed/starts.rs"]
mod starts;

use clap::Parser;
use frames::{Runner, Work};
use gibs::backends::Choice;
use gibs::passes::frame::Settings;
use starts::Starts;
use std::error::Error;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

/// Times to first frame and per frame of each backend
#[derive(Parser)]
struct Args {
    /// A .gltf or .glb file, or a built-in scene
    scene: String,
    /// Camera, sun, sky and animation [default: the scene's own]
    #[arg(long, value_name = "V.json")]
    view: Option<PathBuf>,
    /// Size of the picture
    #[arg(long, value_name = "WxH", default_value = "480x270", value_parser = size)]
    size: [u32; 2],
    /// Ray budget of a frame
    #[arg(long, default_value_t = 100_000)]
    rays: u32,
    /// Frames to time after the first
    #[arg(long, default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Processes with empty caches, and with filled ones, for each backend
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    repeats: u32,
    /// Backends; ratios are to the first that works
    #[arg(long, value_delimiter = ',', default_value = "cpu,wgpu,vulkan")]
    backends: Vec<Choice>,
    /// The program [default: where `cargo build --release` puts it]
    #[arg(long)]
    program: Option<PathBuf>,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text
        .split_once('x')
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    parsed.ok_or_else(|| "give width and height in pixels, such as 480x270".into())
}

fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// The value below which a share of all lies.
fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    sorted
        .get((last as f64 * share).round() as usize)
        .copied()
        .unwrap_or(f64::NAN)
}

fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    let program = args.program.clone().map_or_else(starts::program, Ok)?;
    let process = starts::process(&program)?;
    let (scene, view) = scene::load(&args.scene, args.view.as_deref())?;
    let mut settings = Settings::default();
    settings.set("rays", &args.rays.to_string())?;
    let [width, height] = args.size;
    println!(
        "{}: {width}x{height}, {} rays; {} starts, of which the process is {:.1} ms; {} frames",
        args.scene,
        args.rays,
        args.repeats,
        process * 1e3,
        args.frames
    );

    let work = Work {
        scene: &scene,
        view: &view,
        size: args.size,
        settings: &settings,
        frames: args.frames,
    };
    let mut found: Vec<(Choice, Runner)> = Vec::new();
    for &choice in &args.backends {
        match Runner::new(choice, &work) {
            Ok(runner) => found.push((choice, runner)),
            Err(error) => println!("{choice} is left out: {error}"),
        }
    }
    let mut runners: Vec<&mut Runner> = found.iter_mut().map(|(_, runner)| runner).collect();
    frames::take_turns(&mut runners, &work)?;

    let mut arguments: Vec<OsString> = [
        "--size",
        &format!("{width}x{height}"),
        "--rays",
        &args.rays.to_string(),
        &args.scene,
    ]
    .map(Into::into)
    .into();
    if let Some(view) = &args.view {
        arguments.extend(["--view".into(), view.into()]);
    }
    let choices: Vec<Choice> = found.iter().map(|(choice, _)| *choice).collect();
    let starts = starts::measure(&program, &arguments, &choices, args.repeats, process)?;
    print(&found, &starts);
    Ok(())
}

fn print(found: &[(Choice, Runner)], starts: &[Starts]) {
    println!("\nbackend   first frame, s     per frame");
    println!("            cold    warm         ms   x first   10 %..90 %  device");
    let Some((_, first)) = found.first() else {
        return;
    };
    for ((choice, runner), starts) in found.iter().zip(starts) {
        let ratios = runner
            .seconds
            .iter()
            .zip(&first.seconds)
            .map(|(own, other)| own / other);
        let ratios: Vec<f64> = ratios.collect();
        let spread = format!(
            "{:.2}..{:.2}",
            quantile(&ratios, 0.1),
            quantile(&ratios, 0.9)
        );
        println!(
            "{:<8} {:>7.2} {:>7.2} {:>10.1} {:>9.2} {spread:>12}  {}",
            choice.to_string(),
            median(&starts.cold),
            median(&starts.warm),
            median(&runner.seconds) * 1e3,
            median(&ratios),
            runner.device
        );
    }
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
