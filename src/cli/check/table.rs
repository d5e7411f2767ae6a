//! What the command says.
use super::participants::NotRun;
use crate::check::{Expectation, Gap, Report, Verdict};
use crate::cli::CommandError;
use crate::cli::output::say;
use serde::Serialize;
use std::path::PathBuf;

/// What the command prints as JSON and writes to `report.json`.
#[derive(Serialize)]
pub struct Summary<'a> {
    pub verdict: Verdict,
    /// Participants that were meant to be there, and why they are not.
    pub not_run: &'a [NotRun],
    /// Stages of this program that no case runs.
    pub stages_not_run: &'a [&'static str],
    pub gaps: &'a [Gap],
    /// Differences that are expected and did not come.
    pub unmet: &'a [&'a Expectation],
    pub report: &'a Report,
    pub captures: &'a [PathBuf],
}

/// The table: a line for every pair at every port that is not equal everywhere, and what is equal in one.
pub fn tell(summary: &Summary<'_>) -> Result<(), CommandError> {
    let report = summary.report;
    for lane in &report.lanes {
        say!(
            "{}: {} ({})",
            lane.name,
            lane.device.name,
            lane.device.driver
        );
    }
    let mut equal = 0;
    for (case, step, port, pair) in report.pairs() {
        if pair.verdict == Verdict::Equal {
            equal += 1;
            continue;
        }
        let verdict = format!("{:?}", pair.verdict).to_lowercase();
        say!(
            "{verdict:<9} {}: {} {} ({} and {}): {} of {} elements unequal, {} undecided, {} refused",
            case.name,
            step.label,
            port.port,
            pair.a,
            pair.b,
            pair.unequal,
            pair.elements,
            pair.undecided,
            pair.refused
        );
        if let Some((frame, worst)) = &pair.worst {
            say!(
                "          worst in frame {frame}, element {}{}: {} and {} ({:.1} ULP, relative {:.2e}); {}",
                worst.element,
                worst.field,
                worst.a,
                worst.b,
                worst.ulps,
                worst.relative,
                comparator(&port.comparator)
            );
        }
    }
    for gap in summary.gaps {
        say!("not looked at: {gap}");
    }
    for capture in summary.captures {
        say!("capture: {}", capture.display());
    }
    if !summary.stages_not_run.is_empty() {
        say!("no case runs {}", summary.stages_not_run.join(", "));
    }
    let ports = report.pairs().count();
    say!(
        "{equal} of {ports} comparisons of a port on a pair equal to the bit, {} elements in {} cases: {:?}",
        report.elements(),
        report.cases.len(),
        summary.verdict
    );
    Ok(())
}

fn comparator(comparator: &gibs_graph::Comparator) -> String {
    format!("{:?}: {}", comparator.floats, comparator.reason)
}
