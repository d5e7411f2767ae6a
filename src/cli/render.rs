//! `gibs render`: direct light and surfel indirect light.
use super::CommandError;
use super::output::{check_finite, default_out, progress, say, write};
use super::run::{warn_at_start, warn_of, warn_of_few_rays};
use super::scene::{SceneArgs, SettingsArgs};
use crate::backends::{self, Choice};
use crate::picture::{Format, ensure_writable};
use crate::words::counted;
use crate::{Clamped, DebugPicture, Renderer};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use gibs_passes::frame::{DebugScale, DebugView};
use serde::Serialize;
use std::fmt;
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
    /// Draw what the technique does instead of the picture; .exr also gets the values, as channel debug.NAME
    #[arg(long, value_name = "NAME", value_parser = debug_views())]
    debug: Option<DebugView>,
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
    /// Rays of the last frame: from surfels, and on top of those beyond hits.
    rays: u32,
    continued_rays: u32,
    /// Holes in crowded cells, in which no surfel was born in the last frame.
    crowded: u32,
    grid_overflow: u32,
    /// Slots lost or given twice after the last frame; none without `check_slots`.
    slot_errors: Option<u32>,
    /// What the firefly clamp took; none without it.
    clamped: Option<Clamped>,
    bytes: u64,
    seconds_to_first_frame: f64,
    /// Mean over the frames after the first; none where there is only one.
    seconds_per_frame: Option<f64>,
    debug: Option<Debug>,
    out: PathBuf,
}

/// What a debug view shows.
#[derive(Debug, Serialize)]
struct Debug {
    view: DebugView,
    unit: &'static str,
    scale: DebugScale,
    /// Least and largest value; none where there is nothing to show.
    values: Option<[f32; 2]>,
}

impl Debug {
    fn of(picture: &DebugPicture) -> Self {
        Self {
            view: picture.view(),
            unit: picture.view().unit(),
            scale: picture.view().scale(),
            values: picture.range(),
        }
    }
}

impl fmt::Display for Debug {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { view, unit, .. } = self;
        write!(f, "debug view {view}, {unit}: ")?;
        match self.scale {
            DebugScale::Names => write!(f, "a colour for each")?,
            DebugScale::Parts => write!(
                f,
                "0 is the cube in grey, 1 to 6 are +x, -x, +y, -y, +z, -z"
            )?,
            DebugScale::Heat(most) => write!(f, "0 (black) to {most} (pale yellow)")?,
            DebugScale::BlueToRed(most) => {
                write!(f, "{} (blue) over 1 (grey) to {most} (red)", 1.0 / most)?;
            }
        }
        match self.values {
            Some([least, most]) => write!(f, "; here {} to {}", rounded(least), rounded(most)),
            None => write!(f, "; nothing to show here"),
        }
    }
}

/// A number with at most three decimals.
fn rounded(x: f32) -> f64 {
    (f64::from(x) * 1e3).round() / 1e3
}

/// The debug views, with what each shows, for the help.
fn debug_views() -> impl TypedValueParser<Value = DebugView> {
    let values = DebugView::ALL
        .iter()
        .map(|v| PossibleValue::new(v.name()).help(v.about()));
    PossibleValuesParser::new(values).try_map(|name| name.parse::<DebugView>())
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let start = Instant::now();
    let mut settings = args.settings.load()?;
    if args.debug.is_some() && args.settings.others.sets("debug") {
        return Err(CommandError::SetTwice {
            key: "debug".into(),
            option: "--debug".into(),
        });
    }
    settings.debug = args.debug.or(settings.debug);
    settings.check()?;
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
    warn_at_start(&renderer, &settings);
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
    let debug = settings
        .debug
        .map(|_| renderer.debug_picture())
        .transpose()?;
    match &debug {
        None => write(&picture, &out, loaded.view.exposure)?,
        Some(debug) if Format::of(&out)? == Format::Exr => {
            picture.write(&out, loaded.view.exposure)?;
            debug.write_png(&out.with_extension("png"))?;
        }
        Some(debug) => debug.write_png(&out)?,
    }
    check_finite(&picture)?;
    let counters = renderer.counters()?;
    let summary = Summary {
        backend: backend.name().into(),
        device: backend.device().name.clone(),
        size: loaded.size,
        frames: args.frames,
        surfels: counters.live,
        surfels_without_slot: counters.starved,
        rays: counters.rays,
        continued_rays: counters.continued,
        crowded: counters.crowded,
        grid_overflow: counters.overflow,
        slot_errors: counters.slot_errors,
        clamped: counters.clamped,
        bytes: renderer
            .executable()
            .schedule()
            .bytes(backend.name() == "cpu"),
        seconds_to_first_frame,
        seconds_per_frame: (args.frames > 1).then_some(seconds_per_frame),
        debug: debug.as_ref().map(Debug::of),
        out,
    };
    if args.json {
        say!(
            "{}",
            serde_json::to_string_pretty(&summary).unwrap_or_default()
        );
    } else {
        let then = match summary.seconds_per_frame {
            Some(seconds) => format!(", then {:.1} ms each", seconds * 1e3),
            None => String::new(),
        };
        say!(
            "{} on {} ({}): {} of {}x{}, first after {:.2} s{then}; {}, {:.0} MB; wrote {}",
            args.scene.scene,
            summary.backend,
            summary.device,
            counted(summary.frames, "frame"),
            summary.size[0],
            summary.size[1],
            summary.seconds_to_first_frame,
            counted(summary.surfels, "surfel"),
            summary.bytes as f64 / 1e6,
            summary.out.display()
        );
        if let Some(Clamped { share, times }) = summary.clamped {
            let percent = 100.0 * share;
            say!(
                "the firefly clamp took {percent:.3} % of the light of surfel rays, in {times} samples"
            );
        }
        if let Some(errors) = summary.slot_errors {
            say!("slots lost or given twice: {errors}");
        }
        if let Some(debug) = &summary.debug {
            say!("{debug}");
        }
    }
    warn_of(settings.surfels, &counters);
    let rays = u64::from(settings.rays) * u64::from(args.frames);
    warn_of_few_rays(counters.live.into(), rays);
    Ok(())
}
