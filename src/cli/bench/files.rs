//! The files of a report.
use crate::bench::{self, BenchReport, Measured};
use crate::cli::CommandError;
use crate::picture::replace_file;
use std::ffi::OsStr;
use std::fs::DirEntry;
use std::path::Path;
use std::time::SystemTime;

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

/// Writes the plots of one scene on one backend.
pub fn write_plots(folder: &Path, stem: &str, measured: &Measured) -> Result<(), CommandError> {
    for (name, svg) in bench::plots(measured) {
        replace_file(&folder.join(format!("{stem}-{name}.svg")), svg.as_bytes())?;
    }
    Ok(())
}

/// How many plots and pictures of a folder are older than this: an earlier run's of other scenes or backends, say, which nothing
/// of this run's page shows.
pub fn left_of_before(folder: &Path, start: SystemTime) -> usize {
    let is_older = |entry: &DirEntry| {
        let path = entry.path();
        let written = ["svg", "exr"].map(OsStr::new);
        let is_ours = path.extension().is_some_and(|e| written.contains(&e));
        let modified = entry.metadata().and_then(|data| data.modified());
        is_ours && modified.is_ok_and(|modified| modified < start)
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter(is_older).count()
}

/// How names of files begin: the scene's name, with a number where an earlier scene has the same, and the backend.
pub fn stem(scenes: &[String], index: usize, backend: &str) -> String {
    let name = |scene: &str| {
        let stem = Path::new(scene).file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    };
    let own = name(&scenes[index]);
    match scenes[..index].iter().filter(|s| name(s) == own).count() {
        0 => format!("{own}-{backend}"),
        earlier => format!("{own}-{}-{backend}", earlier + 1),
    }
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
