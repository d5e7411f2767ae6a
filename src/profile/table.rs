//! Profiles as text.
use super::{Comparison, Cost, Figure, Interval, Profile, Saving, StageCost, Verdict};
use crate::words::{counted, printable};
use std::fmt::Write;

/// Share of the steps' time below which a stage has no line of its own.
const SMALL: f64 = 0.005;

/// A frame with timed steps over one without, from which on it is said that timing counts.
const MUCH: f64 = 1.02;

/// A profile as a table: groups and their stages, or every step where `steps` is set.
pub fn table(profile: &Profile, steps: bool) -> String {
    let mut text = heading(profile);
    let _ = writeln!(
        text,
        "\n{:<34} {:>9} {:>9} {:>7} {:>9} {:>9} {:>11} {:>9} {:>9} {:>9}",
        "", "ms", "p95", "share", "rays", "items", "invocations", "reads", "writes", "holds"
    );
    let rows = if steps {
        &profile.steps
    } else {
        &profile.stages
    };
    for group in &profile.groups {
        let of_group = || rows.iter().filter(|row| row.group == group.name);
        let _ = writeln!(text, "{}", line(&group.name, group, None));
        let shown = |row: &&StageCost| steps || row.cost.share >= SMALL;
        for row in of_group().filter(shown) {
            let name = match row.times {
                1 => format!("  {}", row.cost.name),
                times => format!("  {} x{times}", row.cost.name),
            };
            let _ = writeln!(text, "{}", line(&name, &row.cost, Some(row)));
        }
        let small: Vec<&StageCost> = of_group().filter(|row| !shown(row)).collect();
        if !small.is_empty() {
            let ms = small.iter().filter_map(|row| row.cost.ms.as_ref());
            let ms: f64 = ms.map(|ms| ms.median).sum();
            let share: f64 = small.iter().map(|row| row.cost.share).sum();
            let name = format!("  {} smaller", small.len());
            let _ = writeln!(
                text,
                "{name:<34} {ms:>9.3} {:>9} {:>5.1} %",
                "",
                share * 100.0
            );
        }
    }
    text
}

fn heading(profile: &Profile) -> String {
    let [width, height] = profile.size;
    let frame = &profile.frame;
    let mut text = format!(
        "{} on {} ({}): {width}x{height}, {} of {} after {}\n",
        printable(&profile.scene),
        profile.backend,
        printable(&profile.device),
        counted(profile.runs, "run"),
        counted(profile.frames, "frame"),
        profile.warm_up,
    );
    let wall = &frame.wall_ms;
    let _ = write!(text, "a frame {:.2} ms, p95 {:.2}", wall.median, wall.p95);
    let _ = match (&frame.steps_ms, frame.covered) {
        (Some(steps), Some(covered)) => writeln!(
            text,
            "; while its steps are timed {:.2} ms, and they {:.2} ms, {:.1} % of it; timing costs {}",
            frame.timed_ms.median,
            steps.median,
            covered * 100.0,
            percent(&frame.overhead)
        ),
        _ => writeln!(text, "; the device measures no time of steps"),
    };
    if frame.overhead.bounds.is_some_and(|[low, _]| low > MUCH) {
        text += "timing takes a part of these short steps that counts; larger pictures and more rays make it smaller\n";
    }
    if let (Some(tracing), Some(over)) = (&frame.tracing_ms, frame.over_tracing) {
        let _ = writeln!(
            text,
            "tracing rays takes {:.2} ms; a frame takes {over:.2} times what its own does",
            tracing.median,
        );
    }
    let memory = &profile.memory;
    let _ = writeln!(
        text,
        "memory {}: inputs {}, kept from frame to frame {}, within a frame {} ({} more if none was shared)",
        bytes(memory.total),
        bytes(memory.inputs),
        bytes(memory.kept),
        bytes(memory.transient),
        bytes(memory.saved_by_sharing),
    );
    let rays: u64 = profile.steps.iter().map(|step| step.work.rays).sum();
    let _ = writeln!(
        text,
        "{}; {} rays traced, {} of them from surfels",
        counted(profile.counters.live, "surfel"),
        count(rays),
        count(profile.counters.rays.into())
    );
    text
}

fn line(name: &str, cost: &Cost, row: Option<&StageCost>) -> String {
    let ms = |of: fn(&Figure) -> f64| match &cost.ms {
        Some(ms) => format!("{:.3}", of(ms)),
        None => "-".into(),
    };
    let mut text = format!(
        "{name:<34} {:>9} {:>9} {:>5.1} %",
        ms(|ms| ms.median),
        ms(|ms| ms.p95),
        cost.share * 100.0
    );
    if let Some(StageCost { work, .. }) = row {
        let or_blank = |n: u64, text: String| if n == 0 { String::new() } else { text };
        let items = work.items.unwrap_or_default();
        let _ = write!(
            text,
            " {:>9} {:>9} {:>11} {:>9} {:>9} {:>9}",
            or_blank(work.rays, count(work.rays)),
            or_blank(items, count(items)),
            or_blank(work.invocations, count(work.invocations)),
            or_blank(work.bytes_read, bytes(work.bytes_read)),
            or_blank(work.bytes_written, bytes(work.bytes_written)),
            or_blank(work.bytes_held, bytes(work.bytes_held)),
        );
    }
    text.truncate(text.trim_end().len());
    text
}

/// A profile against an older one, as a table.
pub fn comparison_table(comparison: &Comparison, runs: [u32; 2]) -> String {
    let mut text = String::new();
    for difference in &comparison.differences {
        let _ = writeln!(text, "not alike: {}", printable(difference));
    }
    let _ = writeln!(
        text,
        "{:<42} {:>10} {:>10} {:>7}  95 % interval",
        "", "before, ms", "now, ms", "ratio"
    );
    for change in std::iter::once(&comparison.frame).chain(&comparison.stages) {
        let ms = |ms: Option<f64>| ms.map_or("-".into(), |ms| format!("{ms:.3}"));
        let ratio = change.ratio.map(|ratio| format!("{:.3}", ratio.ratio));
        let bounds = change.ratio.and_then(|ratio| ratio.bounds);
        let bounds = bounds.map(|[low, high]| format!("{low:.3} .. {high:.3}"));
        let verdict = match change.verdict {
            Verdict::Faster => "faster",
            Verdict::Slower => "SLOWER",
            Verdict::Noise => "",
            Verdict::Unknown => "too few runs to tell",
            Verdict::TooShort => "too short to tell",
            Verdict::Nothing => "took nothing in a run",
            Verdict::NotTimed => "not timed",
            Verdict::New => "new",
            Verdict::Gone => "gone",
        };
        let line = format!(
            "{:<42} {:>10} {:>10} {:>7}  {:<16} {verdict}",
            printable(&change.name),
            ms(change.before_ms),
            ms(change.now_ms),
            ratio.unwrap_or_default(),
            bounds.unwrap_or_default(),
        );
        let _ = writeln!(text, "{}", line.trim_end());
    }
    let [now, before] = runs;
    if !comparison.differences.is_empty() {
        let _ = writeln!(
            text,
            "What is not alike, above, may be part of every ratio and verdict."
        );
    }
    if comparison
        .frame
        .ratio
        .is_some_and(|ratio| ratio.bounds.is_none())
    {
        text += "Of fewer than three runs before or now there are no intervals, and nothing is called faster or slower: raise --runs.\n";
        return text;
    }
    let _ = writeln!(
        text,
        "Intervals come from how the medians of {} before and {now} now differ; what changed on the machine between \
         the two is not in them. Of twenty rows in which nothing changed, one is called faster or slower by chance.",
        counted(before, "run")
    );
    text
}

/// What needs cost, those that are left out first.
pub fn saving_table(savings: &[Saving], stages: bool) -> String {
    let mut text = String::new();
    for (present, title) in [(false, "left out"), (true, "needed")] {
        for saving in savings
            .iter()
            .filter(|saving| saving.need.present == present)
        {
            let need = &saving.need;
            let verb = if present { "adds" } else { "saves" };
            let memory = signed_bytes(need.bytes);
            let time = saving.time.map(|time| {
                let (ms, ratio) = (time.ms, percent(&time.ratio));
                let told = format!("{ms:+.2} ms on a frame of {:.2} ({ratio})", time.without_ms);
                match time.ratio.bounds {
                    Some([low, high]) if low <= 1.0 && high >= 1.0 => {
                        format!(", no time that can be told from noise: {told}")
                    }
                    _ => format!(", {told}"),
                }
            });
            let _ = writeln!(
                text,
                "{title}: {}, because of {}\n  {verb} {}, {} of others, {memory}{}",
                need.name,
                need.reason,
                counted(need.stages.len() as u64, "stage"),
                counted(need.bindings.len() as u64, "binding"),
                time.or(saving
                    .not_measured
                    .map(|why| format!("; time not measured: {why}")))
                    .unwrap_or_default(),
            );
            if stages {
                for stage in &need.stages {
                    let _ = writeln!(text, "    {stage}");
                }
                for binding in &need.bindings {
                    let _ = writeln!(text, "    {binding} (binding)");
                }
            }
        }
    }
    text
}

/// A ratio as what it adds, with its interval.
fn percent(ratio: &Interval) -> String {
    let added = |ratio: f64| (ratio - 1.0) * 100.0;
    match ratio.bounds {
        Some([low, high]) => format!(
            "{:+.1} %, 95 % interval {:+.1} .. {:+.1}",
            added(ratio.ratio),
            added(low),
            added(high)
        ),
        None => format!("{:+.1} %, of one pair of frames", added(ratio.ratio)),
    }
}

/// A number with three digits and a unit of a thousand.
fn count(value: u64) -> String {
    scaled(value as f64, ["", "k", "M", "G"])
}

/// Bytes with three digits.
fn bytes(value: u64) -> String {
    scaled(value as f64, [" B", " kB", " MB", " GB"])
}

/// The same of what may be less than none.
pub(crate) fn signed_bytes(value: i64) -> String {
    let sign = if value < 0 { "-" } else { "" };
    format!("{sign}{}", bytes(value.unsigned_abs()))
}

fn scaled(mut value: f64, units: [&str; 4]) -> String {
    let mut unit = 0;
    while value >= 999.5 && unit < 3 {
        value /= 1e3;
        unit += 1;
    }
    let decimals = match value {
        _ if unit == 0 => 0,
        value if value < 9.995 => 2,
        value if value < 99.95 => 1,
        _ => 0,
    };
    format!("{value:.decimals$}{}", units[unit])
}
