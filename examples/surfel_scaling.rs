//! How the stages of surfels scale with the number of surfels, from about a thousand to a quarter of a million.
//!
//! ```sh
//! cargo run --release --example surfel_scaling -- atrium --out surfel-scaling.svg
//! ```
//!
//! What varies is the size of the picture: surfels have a radius of four pixels, so that a picture of twice the area has twice the
//! surfels, each half as large in the scene, and as many pixels for each of them. Each pixel and each hit should find as many
//! surfels as before, and the time of *apply* is told per pixel: edges and corners take more surfels in a small picture, so that a
//! large one has more pixels for each. Scene, camera, budget of rays, capacity and all other settings stay as they are. Frames run until hardly any
//! surfels are born, then the median time of each stage over some more frames counts. Where a curve of time per surfel is level,
//! the time is proportional to the surfels; where it falls, a part of it does not depend on them; where it rises, the stage does
//! not scale. Nothing is asserted. `docs/performance.md` has figures.
#[path = "shared/scene.rs"]
mod scene;

use clap::Parser;
use gibs::Renderer;
use gibs::backends::{self, Choice};
use gibs::passes::frame::Settings;
use gibs::plot::{Axis, Plot, Series};
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// Times of stages per surfel over the number of surfels
#[derive(Parser)]
struct Args {
    /// A .gltf or .glb file, or a built-in scene
    #[arg(default_value = "atrium")]
    scene: String,
    /// Camera, sun, sky and animation [default: the scene's own]
    #[arg(long, value_name = "V.json")]
    view: Option<PathBuf>,
    /// auto, cpu, wgpu or vulkan
    #[arg(long, default_value = "cpu")]
    backend: Choice,
    /// Least number of surfels, about
    #[arg(long, default_value_t = 1024, value_parser = clap::value_parser!(u32).range(64..))]
    least: u32,
    /// Largest number of surfels, about
    #[arg(long, default_value_t = 262_144, value_parser = clap::value_parser!(u32).range(64..=CAPACITY.into()))]
    most: u32,
    /// Frames to time
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Where to write the plot
    #[arg(long, value_name = "F.svg")]
    out: Option<PathBuf>,
}

/// Radius of surfels, pixels.
const RADIUS: f32 = 4.0;

/// Pixels for each surfel of that radius when no more are born: 8.5 times as many surfels as discs fit the picture, as
/// `Settings::radius_in` has it.
const PIXELS_PER_SURFEL: f64 = std::f64::consts::PI * 16.0 / 8.5;

/// Twice the largest number: coverage decides how many there are in the end.
const CAPACITY: u32 = 524_288;

/// Frames after which surfels are counted, whether or not more are born.
const MOST_FRAMES: u32 = 96;

/// What is timed: a name, which steps of the frame belong to it, and of what there is one per surfel or pixel.
type Group = (&'static str, fn(&str) -> bool, Per);

/// What the time of a group is divided by.
#[derive(Clone, Copy)]
enum Per {
    Surfel,
    /// A gather is for a pixel, and a large picture has more of those per surfel.
    Pixel,
}

const GROUPS: [Group; 4] = [
    (
        "grid",
        |step| step.contains("persistent/grid") || step.contains("apply/inject"),
        Per::Surfel,
    ),
    (
        "apply, per pixel",
        |step| step.contains("apply/lighting_apply"),
        Per::Pixel,
    ),
    (
        "integration",
        |step| step.starts_with("filtering/"),
        Per::Surfel,
    ),
    (
        "ray set-up",
        |step| {
            ["request_rays", "ray_scan", "allocate_rays", "generate_rays"]
                .iter()
                .any(|part| step.contains(&format!("persistent/{part}")))
        },
        Per::Surfel,
    ),
];

/// One number of surfels.
struct Measured {
    size: [u32; 2],
    surfels: u32,
    /// Milliseconds of each group.
    groups: [f64; 4],
    /// Milliseconds of all steps.
    frame: f64,
}

fn measure(args: &Args, about: u32) -> Result<Measured, Box<dyn Error>> {
    let height = (f64::from(about) * PIXELS_PER_SURFEL * 9.0 / 16.0).sqrt();
    let size = [height * 16.0 / 9.0, height].map(|side| side.round() as u32);
    let mut settings = Settings::default();
    settings.set("radius", &RADIUS.to_string())?;
    settings.set("surfels", &CAPACITY.to_string())?;
    let backend = backends::open(args.backend)?;
    let (scene, view) = scene::load(&args.scene, args.view.as_deref())?;
    let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, size, &settings, 0)?;
    let mut surfels = 0;
    for frame in 1..=MOST_FRAMES {
        renderer.frame()?;
        if frame % 8 == 0 {
            let live = renderer.counters()?.live;
            if f64::from(live) < 1.01 * f64::from(surfels) {
                break;
            }
            surfels = live;
        }
    }
    renderer.executable().measure(true);
    let labels: Vec<String> = {
        let schedule = renderer.executable().schedule();
        schedule.steps.iter().map(|s| s.label.clone()).collect()
    };
    let mut times = vec![Vec::new(); labels.len()];
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
    let sum = |belongs: fn(&str) -> bool| {
        let steps = labels.iter().zip(&medians);
        steps
            .filter(|(label, _)| belongs(label))
            .map(|(_, t)| t)
            .sum()
    };
    Ok(Measured {
        size,
        surfels: renderer.counters()?.live,
        groups: GROUPS.map(|(_, belongs, _)| sum(belongs)),
        frame: medians.iter().sum(),
    })
}

impl Measured {
    fn pixels(&self) -> f64 {
        f64::from(self.size[0]) * f64::from(self.size[1])
    }

    /// Nanoseconds of a group for each of what it is divided by.
    fn each(&self, group: usize) -> f64 {
        let count = match GROUPS[group].2 {
            Per::Surfel => f64::from(self.surfels.max(1)),
            Per::Pixel => self.pixels(),
        };
        self.groups[group] * 1e6 / count
    }
}

fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    println!(
        "| surfels | picture | pixels per surfel | grid | apply, per pixel | integration | ray set-up | frame |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let mut all = Vec::new();
    let counts = std::iter::successors(Some(args.least), |n| n.checked_mul(2));
    for about in counts.take_while(|n| *n <= args.most) {
        let m = measure(args, about)?;
        let groups: [String; GROUPS.len()] =
            std::array::from_fn(|i| format!("{:.2} ms, {:.0} ns", m.groups[i], m.each(i)));
        println!(
            "| {} | {}x{} | {:.1} | {} | {:.0} ms |",
            m.surfels,
            m.size[0],
            m.size[1],
            m.pixels() / f64::from(m.surfels.max(1)),
            groups.join(" | "),
            m.frame
        );
        all.push(m);
    }
    let series = GROUPS.iter().enumerate().map(|(i, (name, ..))| Series {
        name: (*name).into(),
        points: all
            .iter()
            .map(|m| [f64::from(m.surfels), m.each(i)])
            .collect(),
        band: Vec::new(),
        ..Series::default()
    });
    let plot = Plot {
        title: "Time of stages per surfel; of apply, per pixel".into(),
        x: Axis::log("live surfels"),
        y: Axis::log("nanoseconds"),
        series: series.collect(),
    };
    if let Some(out) = &args.out {
        std::fs::write(out, plot.svg())?;
    }
    Ok(())
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
