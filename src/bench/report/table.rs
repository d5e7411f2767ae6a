//! Tables in Markdown.
use crate::bench::{After, EqualError, Mean, OFF, Row};
use crate::words::counted;

/// A table in Markdown for each number of frames that was asked for. What stands behind ± is half of the 95 % confidence interval.
pub fn table(rows: &[Row]) -> String {
    let asked = asked(rows);
    let tables: Vec<String> = asked
        .iter()
        .map(|frames| table_after(rows, *frames))
        .collect();
    tables.join("\n")
}

/// The numbers of frames that were asked for, rising.
pub(super) fn asked(rows: &[Row]) -> Vec<u32> {
    let after = rows.iter().flat_map(|row| &row.after);
    let mut asked: Vec<u32> = after.filter(|a| a.asked).map(|a| a.frames).collect();
    asked.sort_unstable();
    asked.dedup();
    asked
}

/// The name of a row, with what it took of time or rays that it was to equal and did not.
pub(super) fn name(row: &Row, after: &After) -> String {
    row.name.clone() + &missed(after)
}

/// What was taken of what was to be equalled, in brackets, where that was missed; else nothing.
pub(super) fn missed(after: &After) -> String {
    match after.taken {
        Some(taken) if (taken - 1.0).abs() > OFF => format!(" (took {taken:.2} of it)"),
        _ => String::new(),
    }
}

/// The heads of the columns.
pub(super) const HEADS: [&str; 10] = [
    "relMSE",
    "MAPE",
    "bias",
    "p99",
    "FLIP",
    "rays a frame",
    "ms a frame",
    "time over the first row's",
    "seconds so far",
    "on the front",
];

/// What stands in them.
pub(super) fn cells(after: &After) -> [String; 10] {
    let e = &after.errors;
    let ratio = after.ratio;
    [
        with_interval(e.rel_mse, 1.0, false),
        with_interval(e.mape, 100.0, false) + " %",
        with_interval(e.bias, 100.0, true) + " %",
        with_interval(e.p99, 1.0, false),
        with_interval(e.flip, 1.0, false),
        format!("{:.0}", after.rays),
        rounded(after.milliseconds, 3, false),
        format!(
            "{:.2} ({:.2} .. {:.2})",
            ratio.median, ratio.low, ratio.high
        ),
        rounded(after.seconds.mean, 3, false),
        if after.pareto { "yes" } else { "" }.to_owned(),
    ]
}

fn table_after(rows: &[Row], frames: u32) -> String {
    let mut text = format!(
        "| after {} | {} |\n",
        counted(frames, "frame"),
        HEADS.join(" | ")
    );
    text += &("|---".repeat(HEADS.len() + 1) + "|\n");
    for row in rows {
        for after in row.after.iter().filter(|after| after.frames == frames) {
            text += &format!("| {} | {} |\n", name(row, after), cells(after).join(" | "));
        }
    }
    text
}

/// What stands before figures of which more is needed, or less; `None` where both are so, and the figures tell nothing.
fn bound(equal: &EqualError) -> Option<&'static str> {
    match (equal.unreached, equal.fewer) {
        (0, 0) => Some(""),
        (0, _) => Some("< "),
        (_, 0) => Some("> "),
        _ => None,
    }
}

/// The heads of the columns of [`equal_error_table`].
pub(super) const EQUAL_HEADS: [&str; 7] = [
    "baseline",
    "frames",
    "same",
    "samples a pixel",
    "rays",
    "seconds",
    "times the time",
];

/// How many times the time: with its interval, where the error was reached.
pub(super) fn times(equal: &EqualError) -> String {
    let seeds = |count: u32| counted(count, "seed");
    match bound(equal) {
        Some("") => with_interval(equal.times, 1.0, false),
        Some(bound) => format!("{bound}{}", rounded(equal.times.mean, 2, false)),
        None => format!(
            "more than was tried with {}, less than a sample with {}",
            seeds(equal.unreached),
            seeds(equal.fewer)
        ),
    }
}

/// What stands in them; with `>` where more is needed than was tried, and `<` where less is than can be.
pub(super) fn equal_cells(equal: &EqualError) -> [String; 7] {
    let figure = |text: String| bound(equal).map_or("-".into(), |bound| format!("{bound}{text}"));
    let same = match equal.metric {
        "rel_mse" => format!("relMSE of {}", rounded(equal.error.mean, 3, false)),
        _ => format!("MAPE of {} %", rounded(equal.error.mean * 100.0, 3, false)),
    };
    [
        equal.baseline.clone(),
        equal.frames.to_string(),
        same,
        figure(format!("{:.0}", equal.samples.mean)),
        figure(format!("{:.2e}", equal.rays.mean)),
        figure(rounded(equal.seconds.mean, 3, false)),
        times(equal),
    ]
}

/// A table in Markdown of what path tracing needs for the first row's error; empty where nobody looked.
pub fn equal_error_table(all: &[EqualError]) -> String {
    if all.is_empty() {
        return String::new();
    }
    let mut text = format!("| {} |\n", EQUAL_HEADS.join(" | "));
    text += &("|---".repeat(EQUAL_HEADS.len()) + "|\n");
    for equal in all {
        text += &format!("| {} |\n", equal_cells(equal).join(" | "));
    }
    text
}

/// A mean with half of its confidence interval: three digits of the mean, but no more decimals than two digits of the other have.
pub(super) fn with_interval(value: Mean, scale: f64, signed: bool) -> String {
    let mean = value.mean * scale;
    match value.interval.map(|e| e * scale) {
        Some(error) if error > 0.0 && error.is_finite() => {
            let decimals = decimals(mean, 3).min(decimals(error, 2));
            match signed {
                true => format!("{mean:+.decimals$} ± {error:.decimals$}"),
                false => format!("{mean:.decimals$} ± {error:.decimals$}"),
            }
        }
        _ => rounded(mean, 3, signed),
    }
}

pub(super) fn rounded(value: f64, digits: i32, signed: bool) -> String {
    let decimals = decimals(value, digits);
    match signed {
        true => format!("{value:+.decimals$}"),
        false => format!("{value:.decimals$}"),
    }
}

/// Decimals that show so many significant digits.
fn decimals(value: f64, digits: i32) -> usize {
    let magnitude = value.abs();
    if magnitude < 1e-9 || !magnitude.is_finite() {
        return digits.max(1) as usize - 1;
    }
    (digits - 1 - magnitude.log10().floor() as i32).max(0) as usize
}
