//! The tables of `docs/twins.md`.
use super::declare::{BOUNDS, Truth, Twin};
use super::run::{self, Difference};
use super::{families, listing};
use gibs_graph::Backend;
use std::fmt::Write as _;

/// A backend by its name, where the machine has it.
pub type Found = (String, Option<Box<dyn Backend>>);

/// The whole report.
pub fn report(oracle: &dyn Backend, backends: &[Found]) -> String {
    let mut text = String::new();
    devices(oracle, backends, &mut text);
    text.push_str("\n## Functions\n");
    let mut truths = String::new();
    let names: Vec<_> = backends.iter().map(|(name, _)| name.as_str()).collect();
    let header = |text: &mut String, first: &str, last: &str| {
        let _ = writeln!(text, "| {first} | {} | {last} |", names.join(" | "));
        let columns = first.split('|').count() + names.len() + last.split('|').count();
        let _ = writeln!(text, "|{}", "---|".repeat(columns));
    };
    header(
        &mut truths,
        "function | what, and where | Rust",
        "bound | why",
    );
    for (family, twins) in families() {
        let _ = writeln!(text, "\n### {family}\n");
        header(&mut text, "function | inputs", "bound");
        for twin in &twins {
            let cases = run::cases(twin);
            let expected = run::run(twin, oracle, &cases);
            let got: Vec<_> = backends
                .iter()
                .map(|(_, b)| b.as_ref().map(|b| run::run(twin, b.as_ref(), &cases)))
                .collect();
            row(twin, &cases, &expected, &got, &mut text);
            if let Some(truth) = &twin.truth {
                truth_rows(twin, truth, &cases, &expected, &got, &mut truths);
            }
        }
    }
    let _ = writeln!(text, "\n## Bounds\n");
    for bound in BOUNDS {
        let _ = writeln!(text, "- **{}**: {}.", bound.name, bound.reason);
    }
    let _ = writeln!(
        text,
        "\n## Elementary functions against the truth\n\n{truths}"
    );
    let _ = writeln!(text, "## Parts\n\n| function | tested through |\n|---|---|");
    for (part, through) in listing::PARTS {
        let _ = writeln!(text, "| `{part}` | `{through}` |");
    }
    text
}

fn devices(oracle: &dyn Backend, backends: &[Found], text: &mut String) {
    for (name, backend) in backends {
        let _ = match backend {
            None => writeln!(text, "- `{name}`: not run, the machine has none"),
            Some(backend) => {
                let device = backend.device();
                let rounds = match run::rounds(backend.as_ref(), oracle) {
                    true => "rounds every operation correctly and fuses none",
                    false => "does not round every operation correctly, or fuses some",
                };
                writeln!(
                    text,
                    "- `{name}`: {} ({}), {rounds}",
                    device.name, device.driver
                )
            }
        };
    }
}

/// What a function is called in the tables.
fn name(twin: &Twin) -> String {
    if twin.of.is_empty() {
        return twin.name.replace('_', " ");
    }
    let of: Vec<_> = twin.of.iter().map(|of| format!("`{of}`")).collect();
    of.join(", ")
}

fn row(twin: &Twin, cases: &[u32], expected: &[u32], got: &[Option<Vec<u32>>], text: &mut String) {
    let cell = |got: &Option<Vec<u32>>| match got {
        None => "not run".into(),
        Some(got) => difference(&run::compare(twin, cases, expected, got)),
    };
    let cells: Vec<_> = got.iter().map(cell).collect();
    let (name, bound) = (name(twin), twin.bound.name);
    let _ = writeln!(
        text,
        "| {name} | {} | {} | {bound} |",
        twin.cases,
        cells.join(" | ")
    );
}

fn difference(d: &Difference) -> String {
    let mut text = d.steps.to_string();
    if d.words > 0 {
        let _ = write!(text, ", {} words differ", d.words);
    }
    if d.zeros > 0 {
        text.push_str(", signs of zeros");
    }
    text
}

fn truth_rows(
    twin: &Twin,
    truth: &Truth,
    cases: &[u32],
    expected: &[u32],
    got: &[Option<Vec<u32>>],
    text: &mut String,
) {
    let ours = run::errors(truth, twin, cases, expected);
    let got: Vec<_> = got
        .iter()
        .map(|got| got.as_ref().map(|got| run::errors(truth, twin, cases, got)))
        .collect();
    for (i, what) in truth.what.iter().enumerate() {
        let cell = |errors: &Option<Vec<f64>>| match errors {
            None => "not run".into(),
            Some(errors) => format!("{:.2}", errors[i]),
        };
        let cells: Vec<_> = got.iter().map(cell).collect();
        let _ = writeln!(
            text,
            "| {} | {what} | {:.2} | {} | {} | {} |",
            name(twin),
            ours[i],
            cells.join(" | "),
            truth.most,
            truth.reason
        );
    }
}
