//! Every comparison of a case.
use super::badge;
use crate::check::table::said;
use crate::html::escaped;
use gibs_graph::check::{CaseReport, PairReport, PortReport, StepReport, Verdict};
use std::fmt::Write;

fn worst(step: &StepReport) -> Verdict {
    let pairs = step.ports.iter().flat_map(|port| &port.pairs);
    pairs
        .map(|pair| pair.verdict)
        .max()
        .unwrap_or(Verdict::Equal)
}

/// A case, open where something differs.
pub(super) fn table(page: &mut String, case: &CaseReport) {
    let verdict = case.steps.iter().map(worst).max().unwrap_or(Verdict::Equal);
    let open = if verdict == Verdict::Differs {
        " open"
    } else {
        ""
    };
    let _ = write!(
        page,
        "<details{open}><summary>{} <b>{}</b>: {} steps, {} frames</summary><table>\
         <tr><th>step<th>stage<th>port<th>pair<th>verdict<th>elements<th>unequal<th>undecided<th>refused<th>worst<th>comparator</tr>",
        badge(verdict),
        escaped(&case.name),
        case.steps.len(),
        case.frames
    );
    for step in &case.steps {
        match worst(step) {
            Verdict::Equal => equal_row(page, step),
            _ => {
                for port in &step.ports {
                    port.pairs
                        .iter()
                        .for_each(|pair| row(page, step, port, pair));
                }
            }
        }
    }
    *page += "</table></details>";
}

/// All pairs at all ports of a step in one row, where nothing differs.
fn equal_row(page: &mut String, step: &StepReport) {
    let ports: Vec<_> = step.ports.iter().map(|port| escaped(&port.port)).collect();
    let held = step.ports.iter().map(|port| {
        let comparator = escaped(&said(port));
        format!("<code>{}</code>: {comparator}", escaped(&port.port))
    });
    let held: Vec<_> = held.collect();
    let pairs = step.ports.iter().flat_map(|port| &port.pairs);
    let _ = write!(
        page,
        "<tr><td><code>{}</code><td><code>{}</code><td><code>{}</code><td>all pairs<td>{}<td class=n>{}<td class=n>0\
         <td class=n>0<td class=n>0<td><td class=why>{}</tr>",
        escaped(&step.label),
        escaped(&step.stage),
        ports.join(", "),
        badge(Verdict::Equal),
        pairs.map(|pair| pair.elements).sum::<u64>(),
        held.join("; ")
    );
}

fn row(page: &mut String, step: &StepReport, port: &PortReport, pair: &PairReport) {
    let worst = pair.worst.as_ref().map_or(String::new(), |(frame, worst)| {
        format!(
            "frame {frame}, [{}]{}: {} and {} ({:.1} ULP, relative {:.2e})",
            worst.element, worst.field, worst.a, worst.b, worst.ulps, worst.relative
        )
    });
    let _ = write!(
        page,
        "<tr><td><code>{}</code><td><code>{}</code><td><code>{}</code><td>{}, {}<td>{}<td class=n>{}<td class=n>{}<td class=n>{}<td class=n>{}\
         <td>{}<td class=why>{}: {}</tr>",
        escaped(&step.label),
        escaped(&step.stage),
        escaped(&port.port),
        escaped(&pair.a),
        escaped(&pair.b),
        badge(pair.verdict),
        pair.elements,
        pair.unequal,
        pair.undecided,
        pair.refused,
        escaped(&worst),
        escaped(&said(port)),
        escaped(port.comparator.reason)
    );
}
