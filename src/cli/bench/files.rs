//! The files of a report.
use crate::bench::{self, BenchReport, Measured};
use crate::cli::CommandError;
use crate::picture::replace_file;
use crate::words::scene_name;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The page with all of it.
pub const PAGE: &str = "bench.html";

/// Writes the page, the tables and the JSON.
pub fn write(folder: &Path, report: &BenchReport, json: &str) -> Result<(), CommandError> {
    let csv = bench::csv(&report.measured);
    let equal = bench::equal_error_csv(&report.measured);
    let page = bench::html(report);
    for (name, text) in [
        ("bench.csv", csv.as_str()),
        ("equal-error.csv", &equal),
        ("bench.json", json),
        (PAGE, &page),
    ] {
        replace_file(&folder.join(name), text.as_bytes())?;
    }
    Ok(())
}

/// Writes the plots of one scene on one backend, and says where.
pub fn write_plots(
    folder: &Path,
    stem: &str,
    measured: &Measured,
) -> Result<Vec<PathBuf>, CommandError> {
    let mut written = Vec::new();
    for (name, svg) in bench::plots(measured) {
        let path = folder.join(format!("{stem}-{name}.svg"));
        replace_file(&path, svg.as_bytes())?;
        written.push(path);
    }
    Ok(written)
}

/// Plots and pictures in a folder that have the names of a report's, `SCENE-BACKEND-...`, and are not among those written: an earlier run's,
/// of other scenes or backends say, which this one's page does not show.
pub fn left_of_before(folder: &Path, written: &BTreeSet<PathBuf>) -> usize {
    let is_reports = |path: &PathBuf| {
        let kind = path.extension().is_some_and(|e| e == "svg" || e == "exr");
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        kind && ["cpu", "wgpu", "vulkan"]
            .iter()
            .any(|backend| name.contains(&format!("-{backend}-")))
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    paths
        .filter(|path| is_reports(path) && !written.contains(path))
        .count()
}

/// How names of files begin: the scene's name, with a number where an earlier scene has the same, and the backend.
pub fn stem(scenes: &[String], index: usize, backend: &str) -> String {
    // Each takes the first name that none before has.
    let mut names: Vec<String> = Vec::new();
    for scene in &scenes[..=index] {
        let own = scene_name(scene);
        let numbered = (2..).map(|n| format!("{own}-{n}"));
        let mut free = std::iter::once(own.clone()).chain(numbered);
        names.extend(free.find(|name| !names.contains(name)));
    }
    format!("{}-{backend}", names.last().map_or("", String::as_str))
}

/// The command line, with quotes where a shell needs them; the program by its name alone.
pub fn command_line() -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_=.,:/+@%".contains(c);
    let quoted = |word: String| match !word.is_empty() && word.chars().all(plain) {
        true => word,
        false => format!("'{}'", word.replace('\'', "'\\''")),
    };
    let words = std::env::args_os().skip(1);
    let words = words.map(|word| quoted(word.to_string_lossy().into_owned()));
    let all: Vec<String> = std::iter::once("gibs".to_owned()).chain(words).collect();
    all.join(" ")
}
