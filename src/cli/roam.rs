//! `gibs roam`: a camera on its way through a scene.
use super::CommandError;
use super::output::{prepare_folder, progress, say, write};
use super::run::{Totals, checked, median, prepare};
use super::scene::{SceneArgs, SettingsArgs};
use crate::backends::{self, Choice};
use crate::conditions::{Renders, Subject};
use crate::measure::{CameraPath, HoleRow, RoamRow, csv, group_plot, or_empty, plot_of, roam};
use crate::picture::replace_file;
use crate::plot::Axis;
use crate::words::{counted, scene_name};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Send the camera along a path and report cost, surfels and holes of every frame
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// auto, cpu, wgpu or vulkan
    #[arg(long, default_value = "auto")]
    backend: Choice,
    /// Frames of the flight
    #[arg(long, value_name = "N", default_value_t = 600, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
    /// Key poses of the camera [default: forward, around and back]
    #[arg(long, value_name = "P.json")]
    path: Option<PathBuf>,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// Write plots, and every frame as roam.csv, into this folder
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Write every N-th picture into the folder of the report as well
    #[arg(long, value_name = "N", requires = "report", value_parser = clap::value_parser!(u32).range(1..))]
    pictures: Option<u32>,
    /// Print JSON, with every frame
    #[arg(long)]
    json: bool,
}

/// What a flight did.
#[derive(Debug, Serialize)]
struct Flight {
    #[serde(flatten)]
    subject: Subject,
    #[serde(flatten)]
    renders: Renders,
    seed: u32,
    /// Key poses of the camera; `None` where it went forward, around and back.
    path: Option<String>,
    totals: Totals,
    /// `None` where no frame after the first shows a surface.
    holes: Option<Holes>,
    groups: Vec<String>,
    rows: Vec<RoamRow>,
}

/// Shares of pixels with a surface that surfels cover by less than a half.
#[derive(Debug, Serialize)]
struct Holes {
    /// Of all pixels, over all frames.
    mean: f64,
    /// The most of any frame, and that frame; the first has no surfel to begin with and does not count.
    worst: f64,
    worst_frame: u32,
    /// The same of pixels whose surface has been in view for eight frames; none where there are no such pixels.
    settled: Option<Settled>,
}

/// Shares of pixels whose surface has been in view for eight frames.
#[derive(Debug, Serialize)]
struct Settled {
    mean: f64,
    worst: f64,
    worst_frame: u32,
}

impl Holes {
    fn of(rows: &[RoamRow]) -> Option<Self> {
        let later = rows.get(1..).unwrap_or_default();
        if later.iter().all(|row| row.holes.surfaces == 0) {
            return None;
        }
        let mean = |over: fn(&HoleRow) -> u32, of: fn(&HoleRow) -> u32| {
            let sum = |count: fn(&HoleRow) -> u32| -> u64 {
                later.iter().map(|row| u64::from(count(&row.holes))).sum()
            };
            sum(over) as f64 / sum(of).max(1) as f64
        };
        let worst = |share: fn(&HoleRow) -> f64| {
            let shares = later.iter().map(|row| (share(&row.holes), row.frame.frame));
            shares
                .max_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap_or_default()
        };
        let (all, settled) = (worst(HoleRow::share), worst(HoleRow::settled_share));
        Some(Self {
            mean: mean(|h| h.holes, |h| h.surfaces),
            worst: all.0,
            worst_frame: all.1,
            settled: later
                .iter()
                .any(|row| row.holes.settled > 0)
                .then(|| Settled {
                    mean: mean(|h| h.settled_holes, |h| h.settled),
                    worst: settled.0,
                    worst_frame: settled.1,
                }),
        })
    }
}

/// The file in the folder of a report that has all figures.
const TABLE: &str = "roam.csv";

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let settings = checked(&args.settings.load()?);
    if let Some(folder) = &args.report {
        prepare_folder(folder, TABLE)?;
    }
    let backend = backends::open(args.backend)?;
    let loaded = args.scene.load()?;
    let camera = &loaded.view.camera;
    let path = match &args.path {
        Some(path) => CameraPath::load(path, camera)?,
        None => CameraPath::around(camera, args.frames),
    };
    let mut renderer = prepare(backend.as_ref(), &loaded, &settings, args.seed)?;
    let pictures = args.pictures.zip(args.report.as_ref());
    let bar = progress(u64::from(args.frames), "rendering");
    let flown = roam(&mut renderer, &path, args.frames, |renderer, row| {
        bar.inc(1);
        match pictures {
            Some((every, folder)) if row.frame.frame % every == 0 => {
                let name = format!("frame-{:05}.png", row.frame.frame);
                write(
                    &renderer.picture()?,
                    &folder.join(name),
                    loaded.view.exposure,
                )
            }
            _ => Ok(()),
        }
    });
    bar.finish_and_clear();
    let (groups, rows) = flown?;
    let flight = Flight {
        subject: Subject::new(&args.scene.scene, &loaded.view, loaded.size, &settings),
        renders: Renders::with(backend.as_ref()),
        seed: args.seed,
        path: args.path.as_ref().map(|path| path.display().to_string()),
        totals: Totals::of(settings.surfels, rows.iter().map(|row| &row.frame)),
        holes: Holes::of(&rows),
        groups,
        rows,
    };
    match args.json {
        true => say!(
            "{}",
            serde_json::to_string_pretty(&flight).unwrap_or_default()
        ),
        false => say!("{}", table(&flight, args)),
    }
    if let Some(folder) = &args.report {
        report(folder, &scene_name(&args.scene.scene), &flight)?;
    }
    flight.totals.judge()
}

fn table(flight: &Flight, args: &Args) -> String {
    let Flight { totals, holes, .. } = flight;
    let [width, height] = flight.subject.size;
    let median_of = |of: &dyn Fn(&RoamRow) -> Option<f64>, decimals| {
        median(flight.rows.iter().filter_map(of), decimals)
    };
    let mut text = format!(
        "{} on {} ({}): {} of {width}x{height}, {} ms each\n",
        args.scene.scene,
        flight.renders.backend,
        flight.renders.device,
        counted(flight.rows.len() as u64, "frame"),
        median_of(&|row| Some(row.frame.ms), 1),
    );
    text += &format!(
        "surfels: most live {} of {}; {} births, {} recycled, {} starved, at most {} holes in crowded cells; {} entries beyond the grid; {} slot errors\n",
        totals.most_live,
        totals.surfels,
        totals.births,
        totals.recycled,
        totals.starved,
        totals.crowded,
        totals.grid_overflow,
        totals.slot_errors,
    );
    let percent = |share: f64| share * 100.0;
    text += &match holes {
        Some(holes) => format!(
            "holes after frame 0, of all surfaces: {:.3} %, at most {:.2} % (frame {})\n",
            percent(holes.mean),
            percent(holes.worst),
            holes.worst_frame
        ),
        None => "no surface was seen after frame 0\n".to_owned(),
    };
    text += &match holes.as_ref().and_then(|holes| holes.settled.as_ref()) {
        Some(settled) => format!(
            "holes, of surfaces in view for 8 frames: {:.4} %, at most {:.3} % (frame {})\n",
            percent(settled.mean),
            percent(settled.worst),
            settled.worst_frame
        ),
        None => "no surface was in view for 8 frames\n".to_owned(),
    };
    for (i, group) in flight.groups.iter().enumerate() {
        let ms = median_of(&|row| row.frame.groups_ms.get(i).copied(), 2);
        text += &format!("{ms:>10} ms  {group}\n");
    }
    text.truncate(text.trim_end().len());
    text
}

fn report(folder: &Path, scene: &str, flight: &Flight) -> Result<(), CommandError> {
    let rows = flight.rows.iter().map(|row| {
        let HoleRow {
            surfaces,
            holes,
            settled,
            settled_holes,
        } = row.holes;
        let after = [surfaces, holes, settled, settled_holes].map(|n| or_empty(Some(n)));
        (Vec::new(), &row.frame, after.to_vec())
    });
    let columns = ["surfaces", "holes", "settled", "settled_holes"];
    let text = csv(&flight.groups, &[], &columns, rows);
    replace_file(&folder.join(TABLE), text.as_bytes())?;
    let frames = flight.rows.iter().map(|row| &row.frame);
    let cost = group_plot(&format!("{scene}: cost on the way"), &flight.groups, frames);
    let curve = |name: &str, of: &dyn Fn(&RoamRow) -> f64| {
        let point = |row: &RoamRow| [f64::from(row.frame.frame), of(row)];
        (name.to_owned(), flight.rows.iter().map(point).collect())
    };
    let surfels = plot_of(
        &format!("{scene}: surfels on the way"),
        Axis::linear("surfels"),
        vec![
            curve("live", &|row| row.frame.live.into()),
            curve("births of a frame", &|row| row.frame.births.into()),
            curve("recycled in a frame", &|row| row.frame.recycled.into()),
        ],
    );
    let holes = plot_of(
        &format!("{scene}: holes on the way"),
        Axis::linear("pixels that surfels cover by less than a half, %"),
        vec![
            curve("all surfaces", &|row| row.holes.share() * 100.0),
            curve("in view for 8 frames", &|row| {
                row.holes.settled_share() * 100.0
            }),
        ],
    );
    for (name, plot) in [("cost", cost), ("surfels", surfels), ("holes", holes)] {
        replace_file(&folder.join(format!("{name}.svg")), plot.svg().as_bytes())?;
    }
    Ok(())
}
