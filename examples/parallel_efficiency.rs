//! How well the CPU backend uses its threads.
//!
//! ```sh
//! cargo run --release --example parallel_efficiency -- SCENE --view V.json
//! ```
//!
//! Two backends take turns, frame by frame, one with a single thread and one with `--threads`. What one thread takes over
//! what all take together is the efficiency: 1 where no thread ever waits. Threads share the memory and its
//! caches, so that a stage that waits for memory stays below 1 without the schedule's fault. How long a line of the cache takes
//! from one thread to another is told before and after, since a virtual machine's cores may share a cache at one time and
//! none at another. Nothing is asserted.
//! `docs/performance.md` has figures.
#[path = "shared/scene.rs"]
mod scene;

use clap::Parser;
use gibs::Renderer;
use gibs::passes::frame::Settings;
use gibs_backend_cpu::{CpuBackend, Options};
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

/// Time of the frame's groups with one thread and with several
#[derive(Parser)]
struct Args {
    /// A .gltf or .glb file, or a built-in scene
    scene: String,
    /// Camera, sun, sky and animation [default: the scene's own]
    #[arg(long, value_name = "V.json")]
    view: Option<PathBuf>,
    /// Frames to time, after as many to warm up
    #[arg(long, default_value_t = 24, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Threads [default: all]
    #[arg(long)]
    threads: Option<usize>,
}

/// Milliseconds of a frame's steps.
type Frame = Vec<f64>;

/// Nanoseconds that a line of the cache takes from one thread to another, mean of many ways there and back.
fn handover() -> f64 {
    const TURNS: u32 = 100_000;
    let turn = AtomicU32::new(0);
    let take_turns = |first: u32| {
        for mine in (first..2 * TURNS).step_by(2) {
            while turn.load(Ordering::Acquire) != mine {
                std::hint::spin_loop();
            }
            turn.store(mine + 1, Ordering::Release);
        }
    };
    let began = Instant::now();
    std::thread::scope(|scope| {
        scope.spawn(|| take_turns(1));
        take_turns(0);
    });
    began.elapsed().as_secs_f64() * 1e9 / f64::from(2 * TURNS)
}

fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    let (scene, view) = scene::load(&args.scene, args.view.as_deref())?;
    let all = args
        .threads
        .unwrap_or(std::thread::available_parallelism()?.get());
    let settings = Settings::default();
    let mut renderers = Vec::new();
    for threads in [1, all] {
        let backend = CpuBackend::new(Options {
            threads: Some(threads),
            ..Options::default()
        })?;
        renderers.push(Renderer::new(
            &backend,
            &scene,
            &view,
            [480, 270],
            &settings,
            0,
        )?);
    }
    let mut times: [Vec<Frame>; 2] = Default::default();
    let before = handover();
    for frame in 0..2 * args.frames {
        for (renderer, times) in renderers.iter_mut().zip(&mut times) {
            renderer.executable().measure(true);
            renderer.frame()?;
            let steps = renderer.executable().timings()?.unwrap_or_default();
            if frame >= args.frames {
                times.push(steps.iter().map(|s| s.time.as_secs_f64() * 1e3).collect());
            }
        }
    }
    let after = handover();
    println!(
        "A line of the cache goes from thread to thread in {before:.0} ns before and {after:.0} ns after.\n"
    );
    let schedule = renderers[0].executable().schedule().clone();
    let mut rows: Vec<(String, Vec<usize>)> =
        vec![("frame".into(), (0..schedule.steps.len()).collect())];
    for (index, step) in schedule.steps.iter().enumerate() {
        let name = match step.group() {
            "" => "clears",
            group => group,
        };
        match rows.iter_mut().find(|(known, _)| known == name) {
            Some((_, steps)) => steps.push(index),
            None => rows.push((name.into(), vec![index])),
        }
    }
    let median_of = |frames: &[Frame], steps: &[usize]| {
        let mut sums: Vec<f64> = frames
            .iter()
            .map(|frame| steps.iter().map(|&step| frame[step]).sum())
            .collect();
        sums.sort_by(f64::total_cmp);
        sums.get(sums.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let efficiency = |steps: &[usize]| {
        let [one, many] = [median_of(&times[0], steps), median_of(&times[1], steps)];
        (one, many, one / (many * all as f64))
    };
    println!("| | 1 thread | {all} threads | efficiency |\n|---|---|---|---|");
    for (name, steps) in &rows {
        let (one, many, share) = efficiency(steps);
        println!("| {name} | {one:.2} ms | {many:.2} ms | {share:.2} |");
    }
    // What the steps lose against an efficiency of 1, those first that lose the most.
    let mut lost: Vec<(f64, usize)> = (0..schedule.steps.len())
        .map(|step| {
            let (one, many, _) = efficiency(&[step]);
            (many - one / all as f64, step)
        })
        .collect();
    lost.sort_by(|a, b| b.0.total_cmp(&a.0));
    println!("\n| step | lost | efficiency |\n|---|---|---|");
    for &(ms, step) in lost.iter().take(12) {
        let label = &schedule.steps[step].label;
        println!("| {label} | {ms:.2} ms | {:.2} |", efficiency(&[step]).2);
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
