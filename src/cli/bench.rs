//! `gibs bench`: what each element of the technique gains and costs.
use super::CommandError;
use super::output::{prepare_folder, progress, say};
use super::scene::{Loaded, SceneArgs, SettingsArgs, element, size};
use crate::backends::{self, Choice};
use crate::bench::{self, Configuration, Options, Row, Truth};
use crate::picture::replace_file;
use gibs_graph::Backend;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Measure what each element of the technique gains: error, rays and time with it and without, beside path tracing
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// .gltf or .glb files, or built-in scenes
    #[arg(value_name = "SCENE", default_values = ["cornell", "atrium"])]
    scenes: Vec<String>,
    /// Camera, sun, sky and animation of the scene, of which there can only be one then [default: the scene's own]
    #[arg(long, value_name = "V.json")]
    view: Option<PathBuf>,
    /// Size of the picture
    #[arg(long, value_name = "WxH", default_value = "480x270", value_parser = size)]
    size: [u32; 2],
    #[command(flatten)]
    settings: SettingsArgs,
    /// Elements to switch [default: all]
    #[arg(long, value_name = "ELEMENT,..", value_delimiter = ',')]
    elements: Vec<String>,
    /// auto, cpu, wgpu or vulkan
    #[arg(long, default_value = "auto")]
    backend: Choice,
    /// Frames from an empty cache after which errors are reported
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_values = ["16", "64"], value_parser = clap::value_parser!(u32).range(1..=65_536))]
    frames: Vec<u32>,
    /// Repetitions with other random numbers, for standard errors
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    seeds: u32,
    /// The truth of the scene, of which there can only be one then: of every pixel, or of those in the middle of squares
    /// of an odd number of them [default: path-traced, at every fifth pixel where the size is divisible]
    #[arg(long, value_name = "REF.exr")]
    truth: Option<PathBuf>,
    /// Samples per pixel of a truth that is path-traced
    #[arg(long, value_name = "N", default_value_t = 8192, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    spp: u32,
    /// Write bench.csv, bench.json and a plot of error over frames for each scene into this folder
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// What was measured in one scene.
#[derive(Debug, Serialize)]
struct Measured {
    scene: String,
    backend: String,
    device: String,
    size: [u32; 2],
    rays: u32,
    seeds: u32,
    truth: AboutTruth,
    rows: Vec<Row>,
}

#[derive(Debug, Serialize)]
struct AboutTruth {
    /// Of every how many pixels of a row and column there is a truth.
    step: u32,
    /// Samples per pixel, where known.
    samples: Option<u32>,
    /// Standard error per pixel over the mean, where known.
    standard_error: Option<f64>,
}

const CSV: &str = "bench.csv";
const JSON: &str = "bench.json";

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    if args.scenes.len() > 1 {
        let given = [("--view", &args.view), ("--truth", &args.truth)];
        for (option, path) in given {
            if let Some(path) = path {
                return Err(CommandError::Value {
                    option,
                    value: path.display().to_string(),
                    want: format!("it is of one scene, and there are {}", args.scenes.len()),
                });
            }
        }
    }
    let settings = args.settings.load()?;
    settings.check()?;
    let elements = match args.elements.is_empty() {
        true => Configuration::elements(),
        false => {
            let named = args.elements.iter().map(|name| element("--elements", name));
            named.collect::<Result<_, _>>()?
        }
    };
    let options = Options {
        size: args.size,
        configurations: bench::configurations(&settings, &elements),
        frames: args.frames.clone(),
        seeds: args.seeds,
    };
    if let Some(folder) = &args.report {
        prepare_folder(folder, CSV)?;
    }
    // All of them first, so that a wrong name does not show after minutes.
    let load = |scene: &String| {
        let scene = SceneArgs {
            scene: scene.clone(),
            view: args.view.clone(),
            size: Some(args.size),
        };
        scene.load()
    };
    let scenes = args
        .scenes
        .iter()
        .map(load)
        .collect::<Result<Vec<_>, _>>()?;
    let truth = args.truth.as_ref().map(|path| Truth::read(path, args.size));
    let given = truth.transpose()?;
    let backend = backends::open(args.backend)?;
    let mut all: Vec<Measured> = Vec::new();
    for (index, (name, loaded)) in args.scenes.iter().zip(&scenes).enumerate() {
        let truth = match &given {
            Some(truth) => truth.clone(),
            None => path_trace(backend.as_ref(), loaded, args)?,
        };
        let bar = progress(bench::work(&options), "measuring");
        let rows = bench::measure(
            backend.as_ref(),
            &loaded.scene,
            &loaded.view,
            &truth,
            &options,
            || bar.inc(1),
        );
        bar.finish_and_clear();
        let measured = Measured {
            scene: name.clone(),
            backend: backend.name().into(),
            device: backend.device().name.clone(),
            size: args.size,
            rays: settings.rays,
            seeds: args.seeds,
            truth: AboutTruth {
                step: truth.step(),
                samples: truth.samples,
                standard_error: truth.standard_error,
            },
            rows: rows?,
        };
        if !args.json {
            say!("{}\n\n{}", heading(&measured), bench::table(&measured.rows));
        }
        if let Some(folder) = &args.report {
            let svg = bench::plot(
                &format!("{}: error over frames", stem(name)),
                &measured.rows,
            );
            replace_file(&folder.join(file_name(&args.scenes, index)), svg.as_bytes())?;
        }
        all.push(measured);
    }
    let json = serde_json::to_string_pretty(&all).unwrap_or_default();
    if let Some(folder) = &args.report {
        let scenes = all.iter().map(|m| (m.scene.as_str(), m.rows.as_slice()));
        replace_file(&folder.join(CSV), bench::csv(scenes).as_bytes())?;
        replace_file(&folder.join(JSON), json.as_bytes())?;
    }
    if args.json {
        say!("{json}");
    }
    Ok(())
}

fn path_trace(backend: &dyn Backend, loaded: &Loaded, args: &Args) -> Result<Truth, CommandError> {
    // How many segments paths have is not known before; three per sample is usual.
    let bar = progress(u64::from(args.spp) * 3, "path tracing the truth");
    let truth = Truth::render(
        backend,
        &loaded.scene,
        &loaded.view,
        args.size,
        args.spp,
        |frames, _| {
            bar.set_length(bar.length().unwrap_or(0).max(u64::from(frames)));
            bar.set_position(u64::from(frames));
        },
    );
    bar.finish_and_clear();
    Ok(truth?)
}

/// A line about the measurement.
fn heading(measured: &Measured) -> String {
    let [width, height] = measured.size;
    let truth = &measured.truth;
    let pixels = match truth.step {
        1 => "every pixel".to_string(),
        step => format!("one of {} pixels", step * step),
    };
    let samples = truth.samples.map(|n| format!(", {n} samples"));
    let error = truth
        .standard_error
        .map(|e| format!(", standard error {:.1} % per pixel", e * 100.0));
    format!(
        "{} on {} ({}): {width}x{height}, {} rays a frame, {} seed{}; truth of {pixels}{}{}",
        measured.scene,
        measured.backend,
        measured.device,
        measured.rays,
        measured.seeds,
        if measured.seeds == 1 { "" } else { "s" },
        samples.unwrap_or_default(),
        error.unwrap_or_default(),
    )
}

fn stem(scene: &str) -> String {
    let stem = Path::new(scene).file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

/// The plot's file: the scene's name, with a number where an earlier scene has the same.
fn file_name(scenes: &[String], index: usize) -> String {
    let own = stem(&scenes[index]);
    match scenes[..index].iter().filter(|s| stem(s) == own).count() {
        0 => format!("{own}.svg"),
        earlier => format!("{own}-{}.svg", earlier + 1),
    }
}
