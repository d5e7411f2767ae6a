//! A report folded to a row for each port of each stage.
use gibs_graph::check::{Difference, PairReport, PortReport, Report, Verdict};
use gibs_graph::{Comparator, Floats, Order};
use serde::Serialize;

/// A port of a stage, over all cases, steps, frames and pairs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Type name of the stage; `clear` for clears.
    pub stage: String,
    /// Port; `(only read)` for all that it leaves as it is.
    pub port: String,
    /// How it was compared, in short.
    pub comparator: String,
    /// Comparisons: steps of cases, times pairs.
    pub comparisons: u64,
    /// Elements that were compared.
    pub elements: u64,
    /// The worst of what was found.
    pub verdict: Verdict,
    /// The worst number, if any differs.
    pub worst: Option<Worst>,
}

/// The worst number of a port, and where it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst {
    /// Case.
    pub case: String,
    /// Step.
    pub step: String,
    /// First of the pair.
    pub a: String,
    /// Second of the pair.
    pub b: String,
    /// Frame, from 0.
    pub frame: u32,
    /// Element, values and how far they are apart.
    pub difference: Difference,
}

impl Worst {
    /// Case, step, frame and element.
    pub fn place(&self) -> String {
        let Difference { element, field, .. } = &self.difference;
        let (case, step, frame) = (&self.case, &self.step, self.frame);
        format!("{case}: {step}, frame {frame}, [{element}]{field}")
    }
}

/// The rows, in the order in which stages come first.
pub fn rows(report: &Report) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for (case, step, port, pair) in report.pairs() {
        let stage = match step.stage.as_str() {
            "" => "clear",
            stage => stage,
        };
        let comparator = comparator_of(port, pair);
        // One row for all of them, where nothing happened to any.
        let name = match port.only_read && pair.verdict == Verdict::Equal {
            true => "(only read)",
            false => &port.port,
        };
        let known = rows.iter().position(|row| {
            (
                row.stage.as_str(),
                row.port.as_str(),
                row.comparator.as_str(),
            ) == (stage, name, comparator.as_str())
        });
        let at = known.unwrap_or_else(|| {
            rows.push(Row {
                stage: stage.into(),
                port: name.into(),
                comparator,
                comparisons: 0,
                elements: 0,
                verdict: Verdict::Equal,
                worst: None,
            });
            rows.len() - 1
        });
        let row = &mut rows[at];
        row.comparisons += 1;
        row.elements += pair.elements;
        row.verdict = row.verdict.max(pair.verdict);
        if let Some((frame, found)) = &pair.worst {
            let rank = |found: &Difference| (found.refused, found.ulps);
            let known = row.worst.as_ref().map(|worst| rank(&worst.difference));
            if known.is_none_or(|known| rank(found) > known) {
                row.worst = Some(Worst {
                    case: case.name.clone(),
                    step: step.label.clone(),
                    a: pair.a.clone(),
                    b: pair.b.clone(),
                    frame: *frame,
                    difference: found.clone(),
                });
            }
        }
    }
    rows
}

/// What a pair was held to.
fn comparator_of(port: &PortReport, pair: &PairReport) -> String {
    match pair.exact && port.comparator.order == Order::InOrder {
        true => "exact".into(),
        false => said(port),
    }
}

/// How a port is compared, in short.
pub(crate) fn said(port: &PortReport) -> String {
    match (port.only_read, port.comparator.order) {
        (true, _) => "untouched".into(),
        (_, Order::InOrder) if port.integers => "integers".into(),
        _ => short(&port.comparator),
    }
}

/// A comparator without its reason.
fn short(comparator: &Comparator) -> String {
    let mut said = match comparator.floats {
        Floats::Exact => "exact".to_owned(),
        Floats::Ulps(n) => format!("{n} ULP"),
        Floats::Scaled(n) => format!("{n} ULP of the largest"),
        Floats::Absolute(most) => format!("{most:e}"),
    };
    match comparator.order {
        Order::InOrder => {}
        Order::Any => said += ", any order",
        Order::AnyWithin(lists) => said += &format!(", any order within {}", lists.name),
    }
    if comparator.non_finite {
        said += ", non-finite";
    }
    said
}
