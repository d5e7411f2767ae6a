//! All that a check has to say, beside its report.
use super::table::{Row, rows};
use gibs_graph::check::{Expectation, Gap, Report, Verdict};
use serde::Serialize;
use std::path::PathBuf;

/// What `gibs check` prints as JSON and writes to `report.json`; [`html`](super::html) draws it.
#[derive(Debug, Serialize)]
pub struct Summary<'a> {
    /// Nothing differs, everything was looked at, and every expected difference came.
    pub passed: bool,
    /// The worst verdict of all comparisons.
    pub verdict: Verdict,
    /// Only steps and stages with this in their names were compared.
    pub stage: Option<&'a str>,
    /// Participants that were meant to be there, and why they are not.
    pub not_run: &'a [NotRun],
    /// Stages of this program that no case runs.
    pub stages_not_run: &'a [&'static str],
    /// What was not looked at.
    pub gaps: &'a [Gap],
    /// Differences that are expected and did not come.
    pub unmet: &'a [&'a Expectation],
    /// A row for each port of each stage.
    pub table: Vec<Row>,
    /// Comparison by comparison.
    pub report: &'a Report,
    /// Files of captures.
    pub captures: &'a [PathBuf],
}

/// A participant that is missing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NotRun {
    /// Its name.
    pub name: String,
    /// Why it is missing.
    pub reason: String,
}

impl<'a> Summary<'a> {
    /// Of a report with its gaps and its expected differences that did not come. The rest is empty.
    pub fn new(report: &'a Report, gaps: &'a [Gap], unmet: &'a [&'a Expectation]) -> Self {
        let verdict = report.verdict();
        Self {
            passed: verdict < Verdict::Differs && gaps.is_empty() && unmet.is_empty(),
            verdict,
            stage: None,
            not_run: &[],
            stages_not_run: &[],
            gaps,
            unmet,
            table: rows(report),
            report,
            captures: &[],
        }
    }

    /// Comparisons that differ.
    pub fn differences(&self) -> usize {
        let pairs = self.report.pairs();
        pairs
            .filter(|(.., pair)| pair.verdict == Verdict::Differs)
            .count()
    }

    /// Whether the check passed, and what it leaves open, in one line.
    pub fn headline(&self) -> String {
        let mut said = Vec::new();
        let mut add = |count: usize, one: &str, several: &str| match count {
            0 => {}
            1 => said.push(format!("1 {one}")),
            n => said.push(format!("{n} {several}")),
        };
        add(
            self.differences(),
            "comparison differs",
            "comparisons differ",
        );
        add(
            self.gaps.len(),
            "place was not looked at",
            "places were not looked at",
        );
        add(
            self.unmet.len(),
            "expected difference did not come",
            "expected differences did not come",
        );
        add(
            self.not_run.len(),
            "participant not run",
            "participants not run",
        );
        add(
            self.stages_not_run.len(),
            "stage in no case",
            "stages in no case",
        );
        if let Some(stage) = self.stage {
            said.push(format!("only what has `{stage}` in its name was compared"));
        }
        let passed = match self.passed {
            true => format!("passed, {}", word(self.verdict)),
            false => "failed".to_owned(),
        };
        match said.is_empty() {
            true => passed,
            false => format!("{passed}: {}", said.join(", ")),
        }
    }
}

/// A verdict in a word.
pub(crate) fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Equal => "equal",
        Verdict::Within => "within",
        Verdict::Undecided => "undecided",
        Verdict::Expected => "expected",
        Verdict::Differs => "differs",
    }
}
