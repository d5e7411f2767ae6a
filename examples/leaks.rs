//! How much light leaks through walls, partitions, edges and boxes into what is sealed and dark.
//!
//! ```sh
//! cargo run --release --example leaks -- --out DIR
//! cargo run --release --example leaks -- --without-depth
//! ```
//!
//! For each sealed scene that is built in, surfels fill the lit part, then the camera moves to the dark one. The table has
//! irradiance there over the mean of the lit part: mean, 99th percentile and the brightest pixel. Pictures are of E over that
//! mean, as sRGB: 1 % is a dark grey that can just be seen. Nothing is asserted; `tests/leaks.rs` does that.
#[path = "shared/leak.rs"]
mod leak;

use clap::Parser;
use gibs::backends::{self, Choice};
use gibs::builtin::SEALED;
use gibs::passes::frame::Settings;
use leak::{Work, measure};
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// Light that leaks into the dark parts of sealed scenes
#[derive(Parser)]
struct Args {
    /// Scenes [default: all]
    names: Vec<String>,
    /// Size of the pictures
    #[arg(long, value_name = "WxH", default_value = "480x270", value_parser = size)]
    size: [u32; 2],
    /// Frames on each side
    #[arg(long, default_value_t = 64)]
    frames: u32,
    /// Seed
    #[arg(long, default_value_t = 0)]
    seed: u32,
    /// Without depth functions
    #[arg(long)]
    without_depth: bool,
    /// Change a setting; `gibs settings` lists them
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Backend
    #[arg(long, default_value = "cpu")]
    backend: Choice,
    /// Folder for pictures: NAME-bright.png and NAME-dark.png
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text
        .split_once('x')
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    parsed.ok_or_else(|| "give width and height in pixels, such as 480x270".into())
}

fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    let known = || SEALED.map(|case| case.name).join(", ");
    for name in &args.names {
        if !SEALED.iter().any(|case| case.name == name) {
            return Err(format!("there is no sealed scene `{name}`: there are {}", known()).into());
        }
    }
    let mut settings = Settings {
        depth: !args.without_depth,
        ..Settings::default()
    };
    for pair in &args.set {
        let (name, value) = pair
            .split_once('=')
            .ok_or_else(|| format!("`{pair}` is no KEY=VALUE"))?;
        settings.set(name, value)?;
    }
    settings.check()?;
    let backend = backends::open(args.backend)?;
    if let Some(folder) = &args.out {
        std::fs::create_dir_all(folder)
            .map_err(|error| format!("cannot make the folder {}: {error}", folder.display()))?;
    }
    let work = Work {
        settings: &settings,
        size: args.size,
        frames: args.frames,
        seed: args.seed,
    };
    println!("| scene | bright, W/m^2 | dark mean | dark p99 | brightest pixel |");
    println!("|---|---|---|---|---|");
    let wanted = |name: &str| args.names.is_empty() || args.names.iter().any(|n| n == name);
    for case in SEALED.iter().filter(|case| wanted(case.name)) {
        let leak = measure(backend.as_ref(), case, &work)?;
        println!(
            "| {} | {:.3} | {:.4} % | {:.4} % | {:.2} % |",
            case.name,
            leak.bright_mean,
            leak.mean * 100.0,
            leak.p99 * 100.0,
            leak.most * 100.0
        );
        if let Some(folder) = &args.out {
            let exposure = 1.0 / leak.bright_mean.max(f64::MIN_POSITIVE);
            for (side, picture) in [("bright", &leak.bright), ("dark", &leak.dark)] {
                let path = folder.join(format!("{}-{side}.png", case.name));
                picture.write_preview(&path, "E", exposure as f32)?;
            }
        }
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
