//! `gibs bench`: speed against error.
mod files;
mod truth;
mod work;

use super::CommandError;
use super::chosen::{self, Chosen, Opened};
use super::output::{prepare_folder, say, warning};
use super::run::warn_of_no_light;
use super::scene::{SceneArgs, SettingsArgs, element, size};
use crate::bench::{self, BenchReport, Configuration, Machine, Options, Truth, TruthCache};
use std::collections::BTreeSet;
use std::path::PathBuf;
use work::Work;

/// Measure speed against error: what each element of the technique gains and costs, beside path tracing
///
/// Path tracing has as many rays, as much time, and what it needs for the same error.
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
    /// Elements of the technique to switch, all or none [default: all]
    #[arg(long, value_name = "ELEMENT,..", value_delimiter = ',')]
    elements: Vec<String>,
    /// Backends to measure: auto, cpu, wgpu, vulkan, or all that this machine has
    #[arg(
        long,
        value_name = "NAME,..",
        value_delimiter = ',',
        default_value = "auto"
    )]
    backends: Vec<Chosen>,
    /// Frames from an empty cache after which errors are reported
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_values = ["16", "64"], value_parser = clap::value_parser!(u32).range(1..=65_536))]
    frames: Vec<u32>,
    /// Repetitions with other random numbers, for confidence intervals
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    seeds: u32,
    /// The truth of the scene, of which there can only be one then: of every pixel, or of those in the middle of squares
    /// of an odd number of them [default: path-traced, at every fifth pixel where the size is divisible]
    #[arg(long, value_name = "REF.exr")]
    truth: Option<PathBuf>,
    /// The two halves of that truth's samples (OpenEXR), which tell its noise
    #[arg(long, num_args = 2, value_names = ["HALFA", "HALFB"], requires = "truth")]
    halves: Option<Vec<PathBuf>>,
    /// Samples per pixel of a truth that is path-traced
    #[arg(long, value_name = "N", default_value_t = 8192, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    spp: u32,
    /// Keep truths that are path-traced in this folder [default: $XDG_CACHE_HOME/gibs/truths or ~/.cache/gibs/truths]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Path-trace truths anew and keep none
    #[arg(long, conflicts_with = "cache")]
    no_cache: bool,
    /// Seconds that one render may take in the search for how long path tracing needs for the same error; 0 for no search
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = seconds)]
    search: f64,
    /// Write bench.html, bench.csv, equal-error.csv, bench.json and plots into this folder
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Write the pictures of the report beside it as OpenEXR too
    #[arg(long, requires = "report")]
    pictures: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if (0.0..=86_400.0).contains(&value) => Ok(value),
        _ => Err("give seconds from 0 to 86400, such as 10".into()),
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    // What is named twice is measured once.
    let mut names = BTreeSet::new();
    let scenes = args.scenes.iter().filter(|name| names.insert(*name));
    let args = &Args {
        scenes: scenes.cloned().collect(),
        ..args.clone()
    };
    one_scene(args)?;
    let settings = args.settings.load()?;
    settings.check()?;
    warn_of_no_light(&settings);
    let all = args.elements.is_empty() || args.elements.iter().any(|name| name == "all");
    let none = args.elements.iter().any(|name| name == "none");
    if none && args.elements.iter().any(|name| name != "none") {
        return Err(CommandError::Value {
            option: "--elements",
            value: args.elements.join(","),
            want: "`none` stands alone".into(),
        });
    }
    let elements = match (all, none) {
        (true, _) => Configuration::elements(),
        (false, true) => Vec::new(),
        (false, false) => {
            let mut names = BTreeSet::new();
            let once = args.elements.iter().filter(|name| names.insert(*name));
            let named = once.map(|name| element("--elements", name));
            named.collect::<Result<_, _>>()?
        }
    };
    let options = Options {
        size: args.size,
        configurations: bench::configurations(&settings, &elements),
        frames: args.frames.clone(),
        seeds: args.seeds,
        search: args.search,
        pictures: args.report.is_some(),
    };
    if let Some(folder) = &args.report {
        prepare_folder(folder, files::PAGE)?;
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
    let scenes = args.scenes.iter().map(load);
    let scenes = scenes.collect::<Result<Vec<_>, _>>()?;
    let truth = args.truth.as_ref().map(|path| Truth::read(path, args.size));
    let given = truth.transpose()?;
    let Opened { backends, not_run } = chosen::open("--backends", &args.backends)?;
    let cache = match (&args.cache, args.no_cache) {
        (_, true) => None,
        (Some(folder), _) => Some(TruthCache::new(folder)),
        (None, _) => TruthCache::usual(),
    };
    if cache.is_none() && !args.no_cache && given.is_none() {
        warning!(
            "truths are not kept, as neither XDG_CACHE_HOME nor HOME is an absolute path; name a folder with --cache"
        );
    }
    let mut report = BenchReport {
        command: files::command_line(),
        machine: Machine::here(),
        not_run,
        failed: Vec::new(),
        measured: Vec::new(),
    };
    let all = Work {
        args,
        options: &options,
        scenes: &scenes,
        backends: &backends,
        truth: given.as_ref(),
        cache: cache.as_ref(),
    };
    let mut written = BTreeSet::new();
    let done = all.measure(&mut report, &mut written);
    if let Some(folder) = args.report.as_ref().filter(|_| !written.is_empty()) {
        match files::left_of_before(folder, &written) {
            0 => {}
            count => warning!(
                "{} has {} of an earlier run; delete what you do not want, or take another folder",
                folder.display(),
                match count {
                    1 => "a plot or picture".to_owned(),
                    _ => format!("{count} plots and pictures"),
                }
            ),
        }
    }
    // What was measured is not lost when another scene fails.
    if args.json && (done.is_ok() || !report.measured.is_empty()) {
        say!("{}", json(&report));
    }
    done
}

fn json(report: &BenchReport) -> String {
    serde_json::to_string_pretty(report).unwrap_or_default()
}

/// Refuses options that are of one scene where there are several.
fn one_scene(args: &Args) -> Result<(), CommandError> {
    let given = [("--view", &args.view), ("--truth", &args.truth)];
    for (option, path) in given {
        if let Some(path) = path
            && args.scenes.len() > 1
        {
            return Err(CommandError::Value {
                option,
                value: path.display().to_string(),
                want: format!("it is of one scene, and there are {}", args.scenes.len()),
            });
        }
    }
    Ok(())
}
