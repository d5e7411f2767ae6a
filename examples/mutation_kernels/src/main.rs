//! Mutants of the Rust kernels, against the WGSL kernels: how many would `gibs check` catch?
//!
//! ```sh
//! cargo run --release --manifest-path examples/mutation_kernels/Cargo.toml -- 200
//! ```
//!
//! takes the number of mutants. It copies the repository to `target/mutation/tree`, and writes all mutants into the stages and
//! shared modules of that copy at once, each behind a condition that the environment variable `GIBS_MUTANT` decides (a
//! mutant schema: Untch, Offutt and Harrold, 1993), so that one build holds all of them. Then it runs `gibs check` with each.
//! A mutant is caught where the check fails, where the program fails or where it does not end. Prints the survivors, and exits with
//! 1 below 95 %.
mod rewrite;

use rewrite::{Chosen, Found, candidates, rewrite};
use std::collections::BTreeSet;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

/// Where kernels are; the folders of tests within them are left out.
const FOLDERS: [&str; 2] = ["gibs-passes/src/stages", "gibs-passes/src/shared"];

/// What the check runs on: everything on, all kinds of light, two frames.
const CHECK: [&str; 8] = [
    "check", "many-lights", "cornell", "--backends", "vulkan,cpu-scalar", "--frames", "3", "--json",
];

/// A check takes a few seconds; a mutant that takes this long does not end.
const LONGEST: Duration = Duration::from_secs(90);

/// The condition, in the copy.
const CONDITION: &str = "
/// Whether a mutant runs.
pub fn mutant(n: u32) -> bool {
    static RUNS: std::sync::LazyLock<Option<u32>> =
        std::sync::LazyLock::new(|| std::env::var(\"GIBS_MUTANT\").ok()?.parse().ok());
    *RUNS == Some(n)
}
";

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let asked = std::env::args().nth(1).unwrap_or_else(|| "200".into());
    let most: usize = asked.parse().map_err(|e| format!("`{asked}` is no number: {e}"))?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize()?;
    let tree = root.join("target/mutation/tree");
    let files = copy(&root, &tree)?;
    let sources = files
        .into_iter()
        .filter(|file| FOLDERS.iter().any(|folder| file.starts_with(folder)))
        .map(|file| Ok((std::fs::read_to_string(root.join(&file))?, file)))
        .collect::<Result<Vec<(String, PathBuf)>, std::io::Error>>()?;
    let library = tree.join("gibs-passes/src/lib.rs");
    let text = std::fs::read_to_string(&library)?;
    std::fs::write(&library, text + CONDITION)?;
    let mut all = Vec::new();
    for (text, file) in &sources {
        all.extend(candidates(text).map_err(|e| format!("{}: {e}", file.display()))?.into_iter().map(|found| (file, found)));
    }
    // Spread over all of them, some more than asked for, since not all compile.
    let count = (most + most / 4).min(all.len());
    let mut chosen: BTreeSet<usize> = (0..count).map(|n| n * all.len() / count.max(1)).collect();
    println!("{} candidates, {} chosen", all.len(), chosen.len());
    loop {
        write(&tree, &sources, &chosen)?;
        let broken = broken(&tree)?;
        if broken.is_empty() {
            break;
        }
        println!("{} do not compile", broken.len());
        chosen.retain(|n| !broken.contains(n));
    }
    let program = build(&root, &tree)?;
    if run(&program, usize::MAX)? != Outcome::Passed {
        return Err("the check fails without a mutant".into());
    }
    // What lies within a chosen expression is not written, so ask the files.
    let written = written(&tree, &sources)?;
    let (mut caught, mut survived) = (0, 0);
    for &n in written.iter().take(most) {
        let (file, Found { what, line }) = &all[n];
        match run(&program, n)? {
            Outcome::Passed => {
                survived += 1;
                println!("survived: #{n}: {}:{line}: {what}", file.display());
            }
            Outcome::Failed | Outcome::Hung => caught += 1,
        }
    }
    let run = caught + survived;
    println!("{caught} of {run} mutants caught, {:.1} %", 100.0 * f64::from(caught) / f64::from(run.max(1)));
    Ok(ExitCode::from(u8::from(caught * 20 < run * 19)))
}

/// Copies what git tracks, and what is new and not ignored; gives the files.
fn copy(root: &Path, tree: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let list = ["ls-files", "--cached", "--others", "--exclude-standard"];
    let listed = Command::new("git").args(list).current_dir(root).output()?;
    let files: Vec<PathBuf> = String::from_utf8(listed.stdout)?.lines().map(PathBuf::from).collect();
    for file in &files {
        let to = tree.join(file);
        if let Some(folder) = to.parent() {
            std::fs::create_dir_all(folder)?;
        }
        std::fs::copy(root.join(file), to)?;
    }
    Ok(files)
}

/// Writes the chosen mutants into the copy.
fn write(tree: &Path, sources: &[(String, PathBuf)], chosen: &BTreeSet<usize>) -> Result<(), Box<dyn Error>> {
    let mut first = 0;
    for (text, file) in sources {
        let (rewritten, count) = rewrite(text, Chosen { first, chosen })?;
        std::fs::write(tree.join(file), rewritten)?;
        first += count;
    }
    Ok(())
}

/// The mutants that are in the copy.
fn written(tree: &Path, sources: &[(String, PathBuf)]) -> Result<BTreeSet<usize>, Box<dyn Error>> {
    let mut found = BTreeSet::new();
    for (_, file) in sources {
        let text = std::fs::read_to_string(tree.join(file))?;
        found.extend(text.lines().filter_map(number));
    }
    Ok(found)
}

/// The mutant that a line of the copy is of.
fn number(line: &str) -> Option<usize> {
    let (_, rest) = line.split_once("crate::mutant(")?;
    rest.split_once("u32)")?.0.parse().ok()
}

/// The mutants that the compiler refuses: those on or before the lines of its errors.
fn broken(tree: &Path) -> Result<BTreeSet<usize>, Box<dyn Error>> {
    let arguments = ["check", "--release", "--package", "gibs-passes", "--lib", "--message-format", "short"];
    let checked = cargo(tree).args(arguments).output()?;
    if checked.status.success() {
        return Ok(BTreeSet::new());
    }
    let mut found = BTreeSet::new();
    let said = String::from_utf8_lossy(&checked.stderr).into_owned();
    for message in said.lines().filter(|line| line.contains(": error")) {
        let mut parts = message.split(':');
        let (Some(file), Some(Ok(line))) = (parts.next(), parts.next().map(str::parse::<usize>)) else {
            continue;
        };
        let text = std::fs::read_to_string(tree.join(file))?;
        let before: Vec<&str> = text.lines().take(line).collect();
        found.extend(before.iter().rev().find_map(|line| number(line)));
    }
    match found.is_empty() {
        true => Err(format!("the copy does not compile, and not for a mutant:\n{said}").into()),
        false => Ok(found),
    }
}

fn cargo(tree: &Path) -> Command {
    let mut command = Command::new("cargo");
    command.current_dir(tree).env("CARGO_TARGET_DIR", tree.join("../target"));
    command
}

/// The program with all mutants.
fn build(root: &Path, tree: &Path) -> Result<PathBuf, Box<dyn Error>> {
    println!("building");
    let status = cargo(tree).args(["build", "--release", "--locked", "--bin", "gibs"]).status()?;
    match status.success() {
        true => Ok(root.join("target/mutation/target/release/gibs")),
        false => Err("the copy does not build".into()),
    }
}

#[derive(Debug, PartialEq, Eq)]
enum Outcome {
    Passed,
    Failed,
    Hung,
}

/// Runs the check with a mutant.
fn run(program: &Path, mutant: usize) -> Result<Outcome, Box<dyn Error>> {
    let mut child = Command::new(program)
        .args(CHECK)
        .env("GIBS_MUTANT", mutant.to_string())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()?;
    let start = Instant::now();
    loop {
        match child.try_wait()? {
            Some(status) if status.success() => return Ok(Outcome::Passed),
            Some(_) => return Ok(Outcome::Failed),
            None if start.elapsed() > LONGEST => {
                child.kill()?;
                child.wait()?;
                return Ok(Outcome::Hung);
            }
            None => std::thread::sleep(Duration::from_millis(20)),
        }
    }
}
