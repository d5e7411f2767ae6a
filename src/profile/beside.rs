//! Backends side by side.
use super::{Cost, Profile};
use std::fmt::Write;

/// Share of every backend's steps below which a stage has no line.
const SMALL: f64 = 0.005;

/// Width of a column, characters.
const COLUMN: usize = 20;

/// Profiles of several backends as one table: milliseconds of each group and stage, and how many times what the first one needs.
/// Stages are those of the first, which all have: a frame is one schedule on any backend.
pub fn beside(profiles: &[&Profile]) -> String {
    let Some(first) = profiles.first() else {
        return String::new();
    };
    let mut text = format!("{:<34}", "median ms, and over the first");
    for profile in profiles {
        let _ = write!(text, " {:>COLUMN$}", profile.backend);
    }
    let all = |of: &dyn Fn(&Profile) -> Option<f64>| profiles.iter().map(|p| of(p)).collect();
    text += &line("a frame", all(&|p| Some(p.frame.wall_ms.median)));
    let steps = |p: &Profile| p.frame.steps_ms.as_ref().map(|ms| ms.median);
    text += &line("its steps", all(&steps));
    for group in &first.groups {
        let ms = |p: &Profile| median(p.groups.iter().find(|other| other.name == group.name));
        text += &line(&group.name, all(&ms));
        for row in first.stages.iter().filter(|row| row.group == group.name) {
            let same = |p: &Profile| {
                let mut rows = p.stages.iter();
                let same = |other: &&super::StageCost| {
                    other.group == row.group && other.cost.name == row.cost.name
                };
                rows.find(same).map(|other| other.cost.clone())
            };
            let shares = profiles.iter().filter_map(|p| same(p));
            if shares.map(|cost| cost.share).fold(0.0, f64::max) >= SMALL {
                let ms = |p: &Profile| median(same(p).as_ref());
                text += &line(&format!("  {}", row.cost.name), all(&ms));
            }
        }
    }
    text + "\n"
}

fn median(cost: Option<&Cost>) -> Option<f64> {
    cost?.ms.as_ref().map(|ms| ms.median)
}

fn line(name: &str, all: Vec<Option<f64>>) -> String {
    let first = all.first().copied().flatten().filter(|ms| *ms > 0.0);
    let mut text = format!("\n{name:<34}");
    for (i, ms) in all.iter().enumerate() {
        let shown = match (ms, first) {
            (None, _) => "-".into(),
            (Some(ms), Some(first)) if i > 0 => {
                format!("{ms:.3} {:>8}", format!("x{:.2}", ms / first))
            }
            (Some(ms), _) => format!("{ms:.3}"),
        };
        let _ = write!(text, " {shown:>COLUMN$}");
    }
    text
}
