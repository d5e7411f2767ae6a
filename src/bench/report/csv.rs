//! Figures as CSV.
use super::Measured;
use crate::bench::{After, Errors, Mean};

type Column = (&'static str, fn(&Errors) -> Mean);

const COLUMNS: [Column; 5] = [
    ("rel_mse", |e| e.rel_mse),
    ("mape", |e| e.mape),
    ("bias", |e| e.bias),
    ("p99", |e| e.p99),
    ("flip", |e| e.flip),
];

/// All figures, a line for each scene, backend, configuration and number of frames; errors are relative, not percentages. Standard
/// errors and halves of 95 % confidence intervals are empty where there is one seed.
pub fn csv(all: &[Measured]) -> String {
    let mut text = String::from(
        "scene,backend,device,width,height,ray_budget,seeds,truth_samples,configuration,kind,frames,asked",
    );
    for (name, _) in COLUMNS {
        text += &format!(",{name},{name}_standard_error,{name}_interval");
    }
    text += ",mape_ratio,mape_ratio_standard_error,mape_ratio_interval,rays_per_frame,rays,milliseconds_per_frame,\
         seconds,seconds_standard_error,seconds_interval,ratio_low,ratio,ratio_high,taken,pareto\n";
    for measured in all {
        for row in &measured.rows {
            let kind = serde_json::to_value(row.kind).unwrap_or_default();
            for after in &row.after {
                text += &format!(
                    "{},{},{},{},{},{},{},{},{},{},{},{}",
                    quoted(&measured.scene),
                    measured.backend,
                    quoted(&measured.device),
                    measured.size[0],
                    measured.size[1],
                    measured.rays,
                    measured.seeds,
                    or_empty(measured.truth.samples),
                    quoted(&row.name),
                    kind.as_str().unwrap_or_default(),
                    after.frames,
                    after.asked
                );
                text += &figures(after);
                text.push('\n');
            }
        }
    }
    text
}

fn figures(after: &After) -> String {
    let mut text: String = COLUMNS
        .iter()
        .map(|(_, of)| mean(of(&after.errors)))
        .collect();
    text += &mean(after.mape_ratio);
    let figures = |all: &[f64]| -> String { all.iter().map(|value| format!(",{value}")).collect() };
    text += &figures(&[after.rays, after.total_rays, after.milliseconds]);
    text += &mean(after.seconds);
    let ratio = after.ratio;
    text += &figures(&[ratio.low, ratio.median, ratio.high]);
    text + &format!(",{},{}", or_empty(after.taken), after.pareto)
}

/// Text of a value, or none.
fn or_empty(value: Option<impl ToString>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}

/// What path tracing needs for equal error, a line for each scene, backend, baseline, number of frames and metric.
pub fn equal_error_csv(all: &[Measured]) -> String {
    let mut text = String::from("scene,backend,baseline,frames,metric,seeds_unreached,seeds_fewer");
    for name in ["error", "samples", "rays", "seconds", "times"] {
        text += &format!(",{name},{name}_standard_error,{name}_interval");
    }
    text.push('\n');
    for measured in all {
        for equal in &measured.equal_error {
            text += &format!(
                "{},{},{},{},{},{},{}",
                quoted(&measured.scene),
                measured.backend,
                quoted(&equal.baseline),
                equal.frames,
                equal.metric,
                equal.unreached,
                equal.fewer
            );
            let figures = [
                equal.error,
                equal.samples,
                equal.rays,
                equal.seconds,
                equal.times,
            ];
            text.extend(figures.map(mean));
            text.push('\n');
        }
    }
    text
}

fn mean(value: Mean) -> String {
    format!(
        ",{},{},{}",
        value.mean,
        or_empty(value.standard_error),
        or_empty(value.interval)
    )
}

/// A field of text, as RFC 4180 says.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}
