//! How many rays a second the CPU's tracing stages trace, beside Embree on the same rays and threads.
//!
//! ```sh
//! EMBREE_LIBRARY=/path/to/libembree4.so.4 cargo run --release --example trace_speed -- SCENE --view V.json
//! ```
//!
//! Everything is opaque: no traversal runs an alpha test. Contestants trace the same chunk of rays in turn, in an
//! order that rotates, so that whatever else the machine does falls on all of them; rates and ratios are medians over
//! chunks. Nothing is asserted. `docs/performance.md` has figures and says where to get Embree.
#[path = "trace_speed/contestant.rs"]
mod contestant;
#[path = "trace_speed/embree.rs"]
mod embree;
#[path = "trace_speed/rays.rs"]
mod rays;
#[path = "shared/scene.rs"]
mod scene;

use clap::Parser;
use contestant::{Contestant, GROUP};
use embree::{Embree, Quality};
use gibs::passes::accel::wide::{Simd, Tracer};
use gibs::passes::accel::{Hit, Ray};
use rayon::prelude::*;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Rays that a contestant traces before it is the next one's turn: some milliseconds.
const CHUNK: usize = 32_768;

/// Relative difference of distances up to which two contestants found the same hit. Far above rounding, far below
/// the distance of surfaces.
const SAME: f32 = 1e-4;

/// Rates of the CPU's traversals, and of Embree if EMBREE_LIBRARY names it
#[derive(Parser)]
struct Args {
    /// A .gltf or .glb file, or a built-in scene
    scene: String,
    /// Camera and size [default: the scene's own]
    #[arg(long, value_name = "V.json")]
    view: Option<PathBuf>,
    /// Rays
    #[arg(long, default_value_t = 1 << 20, value_parser = clap::value_parser!(u32).range(64..=1 << 27))]
    rays: u32,
    /// Times that every ray is traced, after one to warm up
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    repeats: u32,
    /// Threads [default: all]
    #[arg(long)]
    threads: Option<usize>,
    /// Effort of Embree's tree builder
    #[arg(long, value_enum, default_value = "medium")]
    embree_build: Quality,
}

/// What one contestant did.
struct Outcome {
    name: String,
    /// Rays a second, for each chunk of each repeat.
    rates: Vec<f64>,
    hits: Vec<Hit>,
}

/// Lets every contestant trace all rays, chunk by chunk in turn.
fn race<'a>(
    contestants: &[Contestant<'a>],
    rays: &[Ray],
    repeats: u32,
    trace: impl Fn(&Contestant<'a>, &[Ray], &mut [Hit]) + Sync,
) -> Vec<Outcome> {
    let outcome = |c: &Contestant| Outcome {
        name: c.name(),
        rates: Vec::new(),
        hits: vec![Hit::default(); rays.len()],
    };
    let mut outcomes: Vec<Outcome> = contestants.iter().map(outcome).collect();
    // As the backend cuts dispatches into pieces for threads.
    let least = (CHUNK / GROUP / (rayon::current_num_threads() * 16)).max(1);
    for repeat in 0..=repeats {
        for (turn, chunk) in rays.chunks(CHUNK).enumerate() {
            for i in 0..contestants.len() {
                let i = (i + turn + repeat as usize) % contestants.len();
                let hits = &mut outcomes[i].hits[turn * CHUNK..][..chunk.len()];
                let start = Instant::now();
                let groups = chunk
                    .par_chunks(GROUP)
                    .zip(hits.par_chunks_mut(GROUP))
                    .with_min_len(least);
                groups.for_each(|(rays, hits)| trace(&contestants[i], rays, hits));
                let rate = chunk.len() as f64 / start.elapsed().as_secs_f64();
                // The first time around warms caches and clocks.
                if repeat > 0 {
                    outcomes[i].rates.push(rate);
                }
            }
        }
    }
    outcomes
}

/// The value below which a share of all lies.
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    values
        .get((last as f64 * share).round() as usize)
        .copied()
        .unwrap_or(f64::NAN)
}

/// Mean distance of the hits among `(distance, whether it is one)`, and their share.
fn mean_hit(outcome: &Outcome) -> (f64, f64) {
    let found = outcome.hits.iter().filter(|hit| !hit.is_miss());
    let (count, sum) = found.fold((0u32, 0.0), |(count, sum), hit| {
        (count + 1, sum + f64::from(hit.t))
    });
    (
        sum / f64::from(count),
        f64::from(count) / outcome.hits.len() as f64,
    )
}

/// The share of rays for which two contestants found the same.
fn agreement(a: &Outcome, b: &Outcome) -> f64 {
    let same = |(a, b): &(&Hit, &Hit)| a.t == b.t || (a.t - b.t).abs() <= SAME * a.t.min(b.t);
    a.hits.iter().zip(&b.hits).filter(same).count() as f64 / a.hits.len() as f64
}

fn print(title: &str, outcomes: &[Outcome], last_columns: &str, last: impl Fn(&Outcome) -> String) {
    println!(
        "\n{title:<20} {:>8} {:>9} {:>15} {:>9} {last_columns}",
        "Mrays/s", "x Embree", "10 %..90 %", "agrees"
    );
    let embree = outcomes.iter().find(|o| o.name.starts_with("Embree"));
    for outcome in outcomes {
        let ratios = embree.map(|e| {
            outcome
                .rates
                .iter()
                .zip(&e.rates)
                .map(|(own, other)| own / other)
                .collect()
        });
        let ratios: Vec<f64> = ratios.unwrap_or_default();
        let at = |share| quantile(ratios.clone(), share);
        let (ratio, spread) = match embree {
            Some(_) => (
                format!("{:.2}", at(0.5)),
                format!("{:.2}..{:.2}", at(0.1), at(0.9)),
            ),
            None => ("-".into(), "-".into()),
        };
        println!(
            "{:<20} {:>8.2} {ratio:>9} {spread:>15} {:>7.3} % {}",
            outcome.name,
            quantile(outcome.rates.clone(), 0.5) / 1e6,
            100.0 * agreement(outcome, &outcomes[0]),
            last(outcome)
        );
    }
}

fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    let (scene, view) = scene::load(&args.scene, args.view.as_deref())?;
    let scene = gibs::renderer::device_scene(&scene, &view, view.camera.position)?;
    let threads = rayon::current_num_threads();
    let embree = std::env::var_os("EMBREE_LIBRARY");
    let embree = embree
        .map(|path| Embree::new(&path, &scene.tree, threads, args.embree_build))
        .transpose()?;

    let mut rays = rays::diffuse(&scene, &view, args.rays);
    if rays.is_empty() {
        return Err("the camera sees nothing of the scene; give another --view".into());
    }
    println!(
        "{}: {} triangles, {} instances; {} diffuse rays from what the camera sees; {threads} threads, {} repeats",
        args.scene,
        scene.tree.triangles.len(),
        scene.tree.instances.len(),
        rays.len(),
        args.repeats
    );

    let wide = scene.wide.view(&scene.tree);
    let mut contestants = vec![Contestant::Wide(wide, Tracer::new)];
    contestants.extend(embree.as_ref().map(Contestant::Embree));
    if Tracer::new().simd() != Simd::Portable {
        contestants.push(Contestant::Wide(wide, Tracer::portable));
    }
    contestants.push(Contestant::Scalar(scene.tree.view()));

    let closest = race(&contestants, &rays, args.repeats, Contestant::closest);
    print(
        "closest hit",
        &closest,
        "     hits  mean distance",
        |outcome| {
            let (distance, share) = mean_hit(outcome);
            format!("{:>7.3} % {distance:>12.5} m", 100.0 * share)
        },
    );

    // Up to the mean distance, so that both answers are common.
    let reach = mean_hit(&closest[0]).0 as f32;
    rays.iter_mut().for_each(|ray| ray.t_max = reach);
    let any = race(&contestants, &rays, args.repeats, Contestant::any);
    print(
        &format!("any hit in {reach:.2} m"),
        &any,
        " occluded",
        |outcome| {
            let occluded = outcome.hits.iter().filter(|hit| hit.t == 0.0).count();
            format!(
                "{:>7.3} %",
                100.0 * occluded as f64 / outcome.hits.len() as f64
            )
        },
    );
    Ok(())
}

fn main() -> ExitCode {
    let args = Args::parse();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.unwrap_or(0))
        .build();
    let done = pool.map_err(Into::into).and_then(|pool| {
        // Errors cross threads as text.
        pool.install(|| run(&args).map_err(|error| error.to_string()))
            .map_err(Box::<dyn Error>::from)
    });
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}
