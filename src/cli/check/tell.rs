//! What the command says on standard output.
use crate::check::{Row, Summary, Verdict, Worst, word};
use crate::cli::CommandError;
use crate::cli::output::say;
use crate::words::printable;

/// The participants, the table of all ports, what is not equal, what was left open, and in the last line whether it passed.
pub fn tell(summary: &Summary<'_>) -> Result<(), CommandError> {
    let report = summary.report;
    for lane in &report.lanes {
        say!(
            "{}: {} ({})",
            lane.name,
            printable(&lane.device.name),
            printable(&lane.device.driver)
        );
    }
    for line in lines(&summary.table) {
        say!("{}", printable(&line));
    }
    for (case, step, port, pair) in report.pairs() {
        if pair.verdict == Verdict::Equal {
            continue;
        }
        say!(
            "{:<9} {}: {} ({}) {} ({} and {}): {} of {} elements unequal, {} undecided, {} refused",
            word(pair.verdict),
            printable(&case.name),
            step.label,
            step.stage,
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
                port.comparator.reason
            );
        }
    }
    for gap in summary.gaps {
        say!("not looked at: {}", printable(&gap.to_string()));
    }
    for capture in summary.captures {
        say!("capture: {}", printable(&capture.display().to_string()));
    }
    if !summary.stages_not_run.is_empty() {
        say!("no case runs {}", summary.stages_not_run.join(", "));
    }
    let equal = report.pairs().filter(|(.., p)| p.verdict == Verdict::Equal);
    say!(
        "{} of {} comparisons of a port on a pair equal to the bit, {} elements in {} cases",
        equal.count(),
        report.pairs().count(),
        report.elements(),
        report.cases.len()
    );
    if report.skipped() > 0 {
        say!(
            "{} elements of lists that did not fit were not compared, since which are there is chance",
            report.skipped()
        );
    }
    say!("{}", printable(&summary.headline()));
    Ok(())
}

/// The table, with a line of titles.
fn lines(rows: &[Row]) -> Vec<String> {
    let titles = [
        "stage",
        "port",
        "comparator",
        "worst ULP",
        "relative",
        "verdict",
        "where",
    ];
    let mut cells = vec![titles.map(str::to_owned)];
    cells.extend(rows.iter().map(|row| {
        let number = |of: fn(&Worst) -> String| row.worst.as_ref().map_or("0".into(), of);
        [
            row.stage.clone(),
            row.port.clone(),
            row.comparator.clone(),
            number(|worst| format!("{:.1}", worst.difference.ulps)),
            number(|worst| format!("{:.1e}", worst.difference.relative)),
            word(row.verdict).into(),
            row.worst.as_ref().map_or(String::new(), Worst::place),
        ]
    }));
    let width = |column: usize| {
        let widths = cells.iter().map(|row| row[column].chars().count());
        widths.max().unwrap_or_default()
    };
    let widths = [0, 1, 2, 3, 4, 5].map(width);
    let line = |[stage, port, comparator, ulps, relative, verdict, place]: &[String; 7]| {
        let [a, b, c, d, e, f] = widths;
        let line = format!(
            "{stage:<a$}  {port:<b$}  {comparator:<c$}  {ulps:>d$}  {relative:>e$}  {verdict:<f$}  {place}"
        );
        line.trim_end().to_owned()
    };
    cells.iter().map(line).collect()
}
