//! Mutants of every WGSL kernel, against the oracle's results: how many do the comparators refuse?
//!
//! ```sh
//! cargo run --release --example mutation -- 400
//! ```
//!
//! takes the number of mutants; without one, it runs all of them, some thousands. Each mutant has one operator, sign,
//! constant, index, branch, store or barrier changed. It runs on the Vulkan backend from captures of the stage in several
//! scenes and frames, and is caught where the port's comparator refuses any element of an output against the CPU's, or else
//! where a twin test of the changed function fails. That is not quite what `gibs check` would say: it lets elements pass
//! that a rounding decides about, and runs the optional frames of one scene alone, at another size; here are those of every
//! scene, at a size of which no last workgroup is full. Prints
//! the survivors and, kernel by kernel, how many were caught; exits with 1 below 95 %. Mutants that do
//! what the kernel does are listed with their reasons in `tests/mutation/equivalent.rs`, and count on neither side.
#[path = "../tests/mutation/equivalent.rs"]
mod equivalent;
#[path = "../tests/mutation/generate/mod.rs"]
mod generate;
#[path = "../tests/mutation/run.rs"]
mod run;
#[allow(dead_code, reason = "the twin tests use the rest")]
#[path = "../tests/twins/suite/mod.rs"]
mod suite;
#[path = "../tests/mutation/twins.rs"]
mod twins;

use gibs::backends::{Choice, open};
use run::{Fate, sample, targets};
use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

/// Scenes that have everything between them.
const SCENES: [&str; 5] = ["atrium", "cornell", "glass", "moving", "many-lights"];

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let most = match std::env::args().nth(1) {
        Some(text) => text
            .parse()
            .map_err(|e| format!("`{text}` is no number of mutants: {e}"))?,
        None => usize::MAX,
    };
    let (oracle, device) = (open(Choice::Cpu)?, open(Choice::Vulkan)?);
    let start = Instant::now();
    let targets = targets(oracle.as_ref(), &SCENES)?;
    let twins = twins::Twins::new(oracle.as_ref())?;
    let all: usize = targets.iter().map(|target| target.kernel.len()).sum();
    eprintln!(
        "{} kernels, {all} changes, {} captures, after {:.0} s",
        targets.len(),
        targets
            .iter()
            .map(|target| target.captures.len())
            .sum::<usize>(),
        start.elapsed().as_secs_f64()
    );
    for target in &targets {
        let original = target.kernel.original()?;
        target
            .differs(&original, device.as_ref())
            .map_err(|what| format!("{target}, unchanged, differs: {what}"))?;
    }
    eprintln!(
        "unchanged, every kernel agrees, after {:.0} s",
        start.elapsed().as_secs_f64()
    );
    let chosen = sample(&targets, most.min(all));
    let mut counts = vec![[0_usize; 6]; targets.len()];
    let mut wrong = 0;
    for &(i, index) in &chosen {
        let (what, fate) = targets[i].run(index, &twins, device.as_ref());
        match fate {
            Fate::Survived => println!("survived: {}: #{index}: {what}", targets[i]),
            Fate::WronglyListed => {
                println!(
                    "caught, and listed as equivalent: {}: #{index}: {what}",
                    targets[i]
                );
                wrong += 1;
            }
            _ => {}
        }
        counts[i][fate as usize] += 1;
    }
    println!(
        "\n| kernel | mutants | caught | by twin tests alone | survived |\n|---|---|---|---|---|"
    );
    let mut sums = [0; 6];
    for (target, count) in targets.iter().zip(&counts) {
        let [_, caught, by_twins, survived, ..] = count;
        let all = caught + by_twins + survived;
        println!("| {target} | {all} | {caught} | {by_twins} | {survived} |");
        for (sum, n) in sums.iter_mut().zip(count) {
            *sum += n;
        }
    }
    let [stillborn, by_check, by_twins, survived, equivalent, _] = sums;
    let caught = by_check + by_twins;
    let run = caught + survived;
    println!(
        "\n{caught} of {run} mutants caught, {:.1} %, {by_twins} of them by twin tests alone; {equivalent} more are equivalent to the kernel (tests/mutation/equivalent.rs); {stillborn} changes gave no valid kernel; {:.0} s on {}",
        100.0 * caught as f64 / run.max(1) as f64,
        start.elapsed().as_secs_f64(),
        device.device().name
    );
    Ok(ExitCode::from(u8::from(
        caught * 20 < run * 19 || wrong > 0,
    )))
}
