//! Mutants of the Rust kernels, against the WGSL kernels: how many would `gibs check` catch?
//!
//! ```sh
//! cargo run --release --manifest-path examples/mutation_kernels/Cargo.toml -- 200
//! ```
//!
//! takes the number of mutants. It copies the repository to `target/mutation/tree`, and writes all mutants into the stages,
//! shared functions and wide kernels of that copy at once, each behind a condition that the environment variable
//! `GIBS_MUTANT` decides (a mutant schema: Untch, Offutt and Harrold, 1993), so that one build holds all of them. Then it runs
//! `gibs check` with each, in which the WGSL kernels are unchanged; first a short one, then, of those that survive it, all built-in
//! scenes, and last the twin tests. A mutant is caught where one of them fails, or where the program fails or does not end. Prints
//! the survivors, and exits with 1 below 95 %.
mod rewrite;

use rewrite::{Chosen, Found, candidates, rewrite};
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

/// Where kernels are; files of tests within them are left out.
const FOLDERS: [&str; 3] = [
    "gibs-passes/src/stages",
    "gibs-passes/src/shared",
    "gibs-passes/src/simd",
];

/// The short check: the first scene runs all programs.
const SHORT: [&str; 7] = [
    "check",
    "many-lights",
    "cornell",
    "--backends",
    "vulkan,cpu-scalar,cpu",
    "--frames",
    "3",
];

/// The long check: all scenes, early and late frames.
const LONG: [&str; 3] = ["check", "--backends", "vulkan,cpu-scalar,cpu"];

/// What is run takes less than a minute; a mutant that takes this long does not end.
const LONGEST: Duration = Duration::from_secs(300);

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
    let most: usize = asked
        .parse()
        .map_err(|e| format!("`{asked}` is no number: {e}"))?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()?;
    let tree = root.join("target/mutation/tree");
    let files = copy(&root, &tree)?;
    let sources = files
        .into_iter()
        .filter(|file| {
            FOLDERS.iter().any(|folder| file.starts_with(folder)) && !file.ends_with("tests.rs")
        })
        .filter(|file| file.extension().is_some_and(|extension| extension == "rs"))
        .map(|file| Ok((std::fs::read_to_string(root.join(&file))?, file)))
        .collect::<Result<Vec<(String, PathBuf)>, std::io::Error>>()?;
    let library = tree.join("gibs-passes/src/lib.rs");
    let text = std::fs::read_to_string(&library)?;
    std::fs::write(&library, text + CONDITION)?;
    let mut all = Vec::new();
    for (text, file) in &sources {
        all.extend(
            candidates(text)
                .map_err(|e| format!("{}: {e}", file.display()))?
                .into_iter()
                .map(|found| (file, found)),
        );
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
    let programs = Programs::build(&root, &tree)?;
    if let Some(how) = programs.catches(usize::MAX)? {
        return Err(format!("without a mutant, {how} fails").into());
    }
    // What lies within a chosen expression is not written, so ask the files.
    let written: Vec<usize> = written(&tree, &sources)?.into_iter().collect();
    let count = most.min(written.len());
    let spread = (0..count).map(|n| written[n * written.len() / count]);
    let mut caught: BTreeMap<&str, u32> = BTreeMap::new();
    let mut survived = 0;
    for n in spread {
        let (file, Found { what, line }) = &all[n];
        match programs.catches(n)? {
            Some(how) => *caught.entry(how).or_default() += 1,
            None => {
                survived += 1;
                println!("survived: #{n}: {}:{line}: {what}", file.display());
            }
        }
    }
    let found: u32 = caught.values().sum();
    let run = found + survived;
    for (how, count) in caught {
        println!("{count} caught by {how}");
    }
    println!(
        "{found} of {run} mutants caught, {:.1} %",
        100.0 * f64::from(found) / f64::from(run.max(1))
    );
    Ok(ExitCode::from(u8::from(found * 20 < run * 19)))
}

/// Copies what git tracks, and what is new and not ignored; gives the files. What is there already keeps its time, so that
/// cargo need not build it anew.
fn copy(root: &Path, tree: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let list = ["ls-files", "--cached", "--others", "--exclude-standard"];
    let listed = Command::new("git").args(list).current_dir(root).output()?;
    if !listed.status.success() {
        return Err(String::from_utf8_lossy(&listed.stderr).into());
    }
    let files = String::from_utf8(listed.stdout)?;
    // A file that git tracks may be gone.
    let files: Vec<PathBuf> = files
        .lines()
        .map(PathBuf::from)
        .filter(|file| root.join(file).is_file())
        .collect();
    for file in &files {
        replace(&tree.join(file), &std::fs::read(root.join(file))?)?;
    }
    Ok(files)
}

/// Writes a file unless it says that already.
fn replace(file: &Path, bytes: &[u8]) -> Result<(), Box<dyn Error>> {
    if std::fs::read(file).is_ok_and(|old| old == bytes) {
        return Ok(());
    }
    let write = || {
        file.parent().map_or(Ok(()), std::fs::create_dir_all)?;
        std::fs::write(file, bytes)
    };
    write().map_err(|e| format!("{}: {e}", file.display()).into())
}

/// Writes the chosen mutants into the copy.
fn write(
    tree: &Path,
    sources: &[(String, PathBuf)],
    chosen: &BTreeSet<usize>,
) -> Result<(), Box<dyn Error>> {
    let mut first = 0;
    for (text, file) in sources {
        let (rewritten, count) = rewrite(text, Chosen { first, chosen })?;
        replace(&tree.join(file), rewritten.as_bytes())?;
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
    let arguments = [
        "check",
        "--release",
        "--package",
        "gibs-passes",
        "--lib",
        "--message-format",
        "short",
    ];
    let checked = cargo(tree).args(arguments).output()?;
    if checked.status.success() {
        return Ok(BTreeSet::new());
    }
    let mut found = BTreeSet::new();
    let said = String::from_utf8_lossy(&checked.stderr).into_owned();
    for message in said.lines().filter(|line| line.contains(": error")) {
        let mut parts = message.split(':');
        let (Some(file), Some(Ok(line))) = (parts.next(), parts.next().map(str::parse::<usize>))
        else {
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
    command
        .current_dir(tree)
        .env("CARGO_TARGET_DIR", tree.join("../target"));
    command
}

/// What holds all mutants.
struct Programs {
    gibs: PathBuf,
    twins: PathBuf,
}

impl Programs {
    fn build(root: &Path, tree: &Path) -> Result<Self, Box<dyn Error>> {
        println!("building");
        let status = cargo(tree)
            .args(["build", "--release", "--locked", "--bin", "gibs"])
            .status()?;
        let arguments = [
            "test",
            "--release",
            "--locked",
            "--test",
            "twins",
            "--no-run",
            "--message-format",
            "json",
        ];
        let tests = cargo(tree)
            .args(arguments)
            .stderr(Stdio::inherit())
            .output()?;
        if !status.success() || !tests.status.success() {
            return Err("the copy does not build".into());
        }
        let said = String::from_utf8(tests.stdout)?;
        let twins = said
            .lines()
            .filter_map(|line| line.split_once("\"executable\":\"")?.1.split('"').next())
            .next_back();
        Ok(Self {
            gibs: root.join("target/mutation/target/release/gibs"),
            twins: twins.ok_or("cargo names no test program")?.into(),
        })
    }

    /// What fails with a mutant.
    fn catches(&self, mutant: usize) -> Result<Option<&'static str>, Box<dyn Error>> {
        let runs: [(&str, &Path, &[&str]); 3] = [
            ("the short check", &self.gibs, &SHORT),
            ("the long check", &self.gibs, &LONG),
            ("the twin tests", &self.twins, &[]),
        ];
        for (how, program, arguments) in runs {
            if !passes(program, arguments, mutant)? {
                return Ok(Some(how));
            }
        }
        Ok(None)
    }
}

/// Whether a program with a mutant ends well.
fn passes(program: &Path, arguments: &[&str], mutant: usize) -> Result<bool, Box<dyn Error>> {
    let mut child = Command::new(program)
        .args(arguments)
        .env("GIBS_MUTANT", mutant.to_string())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()?;
    let start = Instant::now();
    loop {
        match child.try_wait()? {
            Some(status) => return Ok(status.success()),
            None if start.elapsed() > LONGEST => {
                child.kill()?;
                child.wait()?;
                return Ok(false);
            }
            None => std::thread::sleep(Duration::from_millis(20)),
        }
    }
}
