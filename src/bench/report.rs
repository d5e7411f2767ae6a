//! What was measured, as tables, as CSV and as a plot.
use super::{After, Errors, Mean, Row};
use crate::compare::Metrics;
use crate::plot::{Axis, Plot, Series};

type Column = (&'static str, fn(&Errors) -> Mean);

const COLUMNS: [Column; 5] = [
    ("rel_mse", |e| e.rel_mse),
    ("mape", |e| e.mape),
    ("bias", |e| e.bias),
    ("p99", |e| e.p99),
    ("flip", |e| e.flip),
];

impl Errors {
    /// Over seeds.
    pub(super) fn of(metrics: impl Iterator<Item = Metrics>) -> Self {
        let all: Vec<Metrics> = metrics.collect();
        let mean = |of: fn(&Metrics) -> f64| Mean::of(all.iter().map(of));
        Self {
            rel_mse: mean(|m| m.rel_mse),
            mape: mean(|m| m.mape),
            bias: mean(|m| m.bias),
            p99: mean(|m| m.p99),
            flip: mean(|m| m.flip),
        }
    }
}

/// A table in Markdown for each number of frames that was asked for.
pub fn table(rows: &[Row]) -> String {
    let mut asked: Vec<u32> = Vec::new();
    for after in rows.iter().flat_map(|row| &row.after) {
        if after.asked && !asked.contains(&after.frames) {
            asked.push(after.frames);
        }
    }
    let tables: Vec<String> = asked
        .iter()
        .map(|frames| table_after(rows, *frames))
        .collect();
    tables.join("\n")
}

fn table_after(rows: &[Row], frames: u32) -> String {
    let mut text = format!(
        "| after {frames} frames | relMSE | MAPE | bias | p99 | FLIP | rays a frame | ms a frame | time over the first row's |\n\
         |---|---|---|---|---|---|---|---|---|\n"
    );
    for row in rows {
        for after in row.after.iter().filter(|after| after.frames == frames) {
            let e = &after.errors;
            text += &format!(
                "| {} | {} | {} % | {} % | {} | {} | {:.0} | {} | {:.2} ({:.2} .. {:.2}) |\n",
                row.name,
                with_error(e.rel_mse, 1.0, false),
                with_error(e.mape, 100.0, false),
                with_error(e.bias, 100.0, true),
                with_error(e.p99, 1.0, false),
                with_error(e.flip, 1.0, false),
                after.rays,
                rounded(after.milliseconds, 3, false),
                after.ratio.median,
                after.ratio.low,
                after.ratio.high,
            );
        }
    }
    text
}

/// A mean with its standard error: three digits of the mean, but no more decimals than two digits of the error have.
fn with_error(value: Mean, scale: f64, signed: bool) -> String {
    let mean = value.mean * scale;
    match value.standard_error.map(|e| e * scale) {
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

fn rounded(value: f64, digits: i32, signed: bool) -> String {
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

/// All figures, a line for each scene, configuration and number of frames; errors are relative, not percentages. Standard errors
/// are empty where there is one seed.
pub fn csv<'a>(scenes: impl Iterator<Item = (&'a str, &'a [Row])>) -> String {
    let mut text = String::from("scene,configuration,frames");
    for (name, _) in COLUMNS {
        text += &format!(",{name},{name}_standard_error");
    }
    text += ",rays_per_frame,milliseconds,ratio_low,ratio,ratio_high\n";
    for (scene, rows) in scenes {
        for row in rows {
            for after in &row.after {
                let frames = after.frames;
                text += &format!("{},{},{frames}", quoted(scene), quoted(&row.name));
                text += &figures(after);
                text.push('\n');
            }
        }
    }
    text
}

fn figures(after: &After) -> String {
    let mut text = String::new();
    for (_, of) in COLUMNS {
        let value = of(&after.errors);
        let error = value.standard_error.map(|e| e.to_string());
        text += &format!(",{},{}", value.mean, error.unwrap_or_default());
    }
    let ratio = after.ratio;
    let rest = [
        after.rays,
        after.milliseconds,
        ratio.low,
        ratio.median,
        ratio.high,
    ];
    text.extend(rest.map(|value| format!(",{value}")));
    text
}

/// A field of text, as RFC 4180 says.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// MAPE over frames of every configuration, as SVG; the legend goes from the largest last error to the smallest.
pub fn plot(title: &str, rows: &[Row]) -> String {
    let last = |row: &Row| row.after.last().map_or(0.0, |a| a.errors.mape.mean);
    let mut ordered: Vec<&Row> = rows.iter().collect();
    ordered.sort_by(|a, b| last(b).total_cmp(&last(a)));
    let series = ordered.iter().map(|row| Series {
        name: row.name.clone(),
        points: row
            .after
            .iter()
            .map(|a| [f64::from(a.frames), a.errors.mape.mean * 100.0])
            .collect(),
        band: Vec::new(),
    });
    Plot {
        title: title.into(),
        x: Axis::log("frames from an empty cache"),
        y: Axis::log("MAPE of indirect irradiance, %"),
        series: series.collect(),
    }
    .svg()
}
