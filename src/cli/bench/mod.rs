//! `gibs bench`: speed against error.
mod files;
mod truth;

use super::CommandError;
use super::chosen::{self, Chosen, Opened};
use super::compare::noise_of;
use super::output::{prepare_folder, progress, say, warning};
use super::run::{warn_of_no_light, warn_of_truth};
use super::scene::{Loaded, SceneArgs, SettingsArgs, element, size};
use crate::bench::{
    self, AboutTruth, BenchReport, Configuration, Failed, Look, Machine, Measured, Options,
    Pictures, Target, Truth, TruthCache,
};
use crate::compare::CompareOptions;
use crate::conditions::{settings_map, view_value};
use gibs_graph::Backend;
use std::collections::BTreeSet;
use std::path::PathBuf;

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
            // What is named twice is measured once.
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

/// What is to be measured.
struct Work<'a> {
    args: &'a Args,
    options: &'a Options,
    scenes: &'a [Loaded],
    backends: &'a [Box<dyn Backend>],
    /// The truth that was given.
    truth: Option<&'a Truth>,
    cache: Option<&'a TruthCache>,
}

impl Work<'_> {
    /// Measures every scene on every backend, those after one that cannot be measured too. The files are written anew after
    /// each, with all that is there by then; `written` hears of plots and pictures.
    ///
    /// # Errors
    /// That of the first scene that could not be measured.
    fn measure(
        &self,
        report: &mut BenchReport,
        written: &mut BTreeSet<PathBuf>,
    ) -> Result<(), CommandError> {
        let Some(first) = self.backends.first() else {
            return Ok(());
        };
        let mut done = Ok(());
        for (index, scene) in self.args.scenes.iter().enumerate() {
            let held = self.hold(index, first.as_ref());
            let mut fail =
                |backend: Option<&str>, error: CommandError, report: &mut BenchReport| {
                    report.failed.push(Failed {
                        scene: scene.clone(),
                        backend: backend.map(str::to_owned),
                        reason: error.to_string(),
                    });
                    if done.is_err() {
                        warning!("{error}");
                    }
                    done = std::mem::replace(&mut done, Ok(())).and(Err(error));
                    self.write(report)
                };
            let held = match held {
                Ok(held) => held,
                Err(error) => {
                    fail(None, error, report)?;
                    continue;
                }
            };
            for backend in self.backends {
                match self.on(index, backend.as_ref(), &held, written) {
                    Ok(measured) => {
                        report.measured.push(measured);
                        self.write(report)?;
                    }
                    Err(error) => fail(Some(backend.name()), error, report)?,
                }
            }
        }
        done
    }

    /// Writes the files of the report, with all that was measured so far.
    fn write(&self, report: &BenchReport) -> Result<(), CommandError> {
        match &self.args.report {
            Some(folder) if !report.measured.is_empty() => {
                files::write(folder, report, &json(report))
            }
            _ => Ok(()),
        }
    }

    fn target<'a>(&'a self, index: usize, backend: &'a dyn Backend) -> Target<'a> {
        let loaded = &self.scenes[index];
        Target {
            backend,
            scene: &loaded.scene,
            view: &loaded.view,
            size: self.args.size,
        }
    }

    /// What all backends are held against in a scene: one truth, so that its noise is the same for all.
    fn hold(&self, index: usize, first: &dyn Backend) -> Result<Held, CommandError> {
        let Self { args, cache, .. } = *self;
        let (name, loaded) = (&args.scenes[index], &self.scenes[index]);
        let of_first = self.target(index, first);
        let truth = match self.truth {
            Some(truth) => truth.clone(),
            None => truth::path_trace(&of_first, args.spp, cache)?,
        };
        let mask = truth.check(name)?;
        let mut about = AboutTruth {
            file: args.truth.as_ref().map(|path| path.display().to_string()),
            step: truth.step(),
            samples: truth.samples,
            standard_error: truth.standard_error,
            noise: None,
            mask,
            elsewhere: None,
        };
        if let Some(path) = &args.truth {
            about.elsewhere = warn_of_truth(first, loaded, truth.picture(), path);
            if let Some([half_a, half_b]) = args.halves.as_deref() {
                let options = CompareOptions::default();
                let noise = noise_of([half_a, half_b], truth.picture(), path, &options)?;
                // Of halves that are none it is nothing.
                about.noise = (!noise.doubted).then_some(noise.errors);
            }
        }
        let look = match args.report {
            Some(_) => Some(truth::look(&truth, &of_first, args.spp, cache)?),
            None => None,
        };
        Ok(Held { truth, about, look })
    }

    /// Measures a scene on one backend, and writes its plots and pictures.
    fn on(
        &self,
        index: usize,
        backend: &dyn Backend,
        held: &Held,
        written: &mut BTreeSet<PathBuf>,
    ) -> Result<Measured, CommandError> {
        let args = self.args;
        let target = self.target(index, backend);
        let mut measured = measure(&target, held, self.options, &args.scenes[index])?;
        measured.exposure = target.view.exposure;
        measured.pictures.look = held.look.clone();
        if !args.json {
            let tables = bench::table(&measured.rows);
            let equal = bench::equal_error_table(&measured.equal_error);
            say!("{}\n\n{tables}\n{equal}", bench::heading(&measured));
        }
        if let Some(folder) = &args.report {
            let stem = files::stem(&args.scenes, index, backend.name());
            written.extend(files::write_plots(folder, &stem, &measured)?);
            if args.pictures {
                let written_now = measured.pictures.write(folder, &stem, &held.truth)?;
                written.extend(written_now);
            }
        }
        Ok(measured)
    }
}

/// What the pictures of a scene are held against.
struct Held {
    truth: Truth,
    about: AboutTruth,
    look: Option<Look>,
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

fn measure(
    target: &Target<'_>,
    held: &Held,
    options: &Options,
    scene: &str,
) -> Result<Measured, CommandError> {
    let bar = progress(bench::work(options), "measuring");
    let done = bench::measure(target, &held.truth, options, || bar.inc(1));
    bar.finish_and_clear();
    let done = done?;
    for warning in &done.warnings {
        warning!("{scene}: {warning}");
    }
    let backend: &dyn Backend = target.backend;
    let device = backend.device();
    let first = options.configurations.first().map(|first| &first.settings);
    Ok(Measured {
        scene: scene.into(),
        backend: backend.name().into(),
        device: device.name.clone(),
        driver: device.driver.clone(),
        size: options.size,
        view: view_value(target.view),
        settings: first.map(settings_map).unwrap_or_default(),
        rays: first.map_or(0, |settings| settings.rays),
        seeds: options.seeds,
        truth: held.about.clone(),
        rows: done.rows,
        equal_error: done.equal_error,
        same_as_path_tracing: done.same,
        exposure: 1.0,
        pictures: Pictures {
            look: None,
            shots: done.shots,
        },
    })
}
