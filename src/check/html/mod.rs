//! The report as one file that a browser opens, with pictures of the differences.
mod cases;
mod pictures;

use super::summary::{Summary, word};
use super::table::Row;
use crate::html::{escaped, page};
use gibs_graph::check::{Capture, Lane, Verdict};
use std::fmt::Write;

/// What a page looks like beside what all have.
const STYLE: &str = "
.v { border-radius: .3rem; padding: 0 .4rem; color: #fff; white-space: nowrap; }
.equal { background: #2e7d4f; } .within { background: #33658a; } .undecided { background: #8a6d1f; }
.expected { background: #7a5195; } .differs, .failed { background: #b3261e; } .passed { background: #2e7d4f; }
";

/// The report as one HTML file that needs nothing else: whether the check passed and what it leaves open, a table of the ports of
/// all stages, every comparison, and pictures of `captures`. Of each capture, there is a picture per port that was written: an
/// element is a pixel, row by row; black is equal, and from blue over red to white it is off by one ULP to all bits. What has
/// as many elements as the frame has pixels, `size`, is drawn in its shape.
pub fn html(summary: &Summary<'_>, captures: &[Capture], size: [u32; 2]) -> String {
    let report = summary.report;
    let mut body = String::new();
    let outcome = match summary.passed {
        true => "passed",
        false => "failed",
    };
    // Writing to a string cannot fail.
    let _ = write!(
        body,
        "<h1>gibs check: <span class=\"v {outcome}\">{outcome}</span></h1><p>{}</p>",
        escaped(&summary.headline())
    );
    lanes(&mut body, &report.lanes);
    left_open(&mut body, summary);
    counts(&mut body, summary);
    table(&mut body, &summary.table);
    body += "<h2>Case by case</h2>";
    for case in &report.cases {
        cases::table(&mut body, case);
    }
    if !captures.is_empty() {
        body += pictures::LEGEND;
    }
    for capture in captures {
        pictures::pictures(&mut body, report, capture, size);
    }
    page(&format!("gibs check: {outcome}"), STYLE, &body)
}

/// What took part.
fn lanes(page: &mut String, lanes: &[Lane]) {
    *page += "<table><tr><th>participant<th>device<th>driver<th></tr>";
    for (i, lane) in lanes.iter().enumerate() {
        let role = match i {
            0 => "its values are what all go on from",
            _ => "",
        };
        let _ = write!(
            page,
            "<tr><td><code>{}</code><td>{}<td>{}<td class=why>{role}</tr>",
            escaped(&lane.name),
            escaped(&lane.device.name),
            escaped(&lane.device.driver)
        );
    }
    *page += "</table>";
}

/// What did not run, was not looked at, or did not come.
fn left_open(page: &mut String, summary: &Summary<'_>) {
    for missing in summary.not_run {
        let _ = write!(
            page,
            "<p>not run: <code>{}</code>: {}</p>",
            escaped(&missing.name),
            escaped(&missing.reason)
        );
    }
    if !summary.stages_not_run.is_empty() {
        let names = escaped(&summary.stages_not_run.join(", "));
        let _ = write!(page, "<p>in no case: <code>{names}</code></p>");
    }
    let failed = "<p><span class=\"v failed\">failed</span>";
    for expectation in summary.unmet {
        let _ = write!(
            page,
            "{failed} <code>{}</code> on {} is expected to differ and did not: {}</p>",
            escaped(&expectation.stage),
            escaped(&expectation.device),
            escaped(&expectation.reason)
        );
    }
    for gap in summary.gaps {
        let gap = escaped(&gap.to_string());
        let _ = write!(page, "{failed} not looked at: {gap}</p>");
    }
}

/// How many comparisons have which verdict.
fn counts(page: &mut String, summary: &Summary<'_>) {
    let report = summary.report;
    *page += "<p>";
    for verdict in [
        Verdict::Equal,
        Verdict::Within,
        Verdict::Undecided,
        Verdict::Expected,
        Verdict::Differs,
    ] {
        let pairs = report.pairs().filter(|(.., p)| p.verdict == verdict);
        let _ = write!(page, "{} {} &emsp;", badge(verdict), pairs.count());
    }
    let _ = write!(
        page,
        "of {} comparisons, {} elements, and {} of lists that did not fit, which were not compared</p>",
        report.pairs().count(),
        report.elements(),
        report.skipped()
    );
}

/// The ports of all stages.
fn table(page: &mut String, rows: &[Row]) {
    *page += "<h2>Ports</h2><table><tr><th>stage<th>port<th>comparator<th>worst ULP<th>relative<th>where<th>values\
              <th>verdict</tr>";
    for row in rows {
        let _ = write!(
            page,
            "<tr><td><code>{}</code><td><code>{}</code><td>{}",
            escaped(&row.stage),
            escaped(&row.port),
            escaped(&row.comparator)
        );
        let _ = match &row.worst {
            None => write!(page, "<td class=n>0<td class=n>0<td><td>"),
            Some(worst) => write!(
                page,
                "<td class=n>{:.1}<td class=n>{:.2e}<td>{}<td>{} on {}, {} on {}",
                worst.difference.ulps,
                worst.difference.relative,
                escaped(&worst.place()),
                escaped(&worst.difference.a),
                escaped(&worst.a),
                escaped(&worst.difference.b),
                escaped(&worst.b)
            ),
        };
        let _ = write!(page, "<td>{}</tr>", badge(row.verdict));
    }
    *page += "</table>";
}

fn badge(verdict: Verdict) -> String {
    let name = word(verdict);
    format!("<span class=\"v {name}\">{name}</span>")
}
