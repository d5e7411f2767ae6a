//! The report as one file that a browser opens, with pictures of the differences.
use crate::html::{escaped, page, png};
use gibs_graph::check::{
    Capture, CaseReport, Expectation, PairReport, PortReport, Report, StepReport, Verdict, apart,
};
use image::{Rgb, RgbImage};
use std::fmt::Write;

/// What a page looks like beside what all have.
const STYLE: &str = "
.v { border-radius: .3rem; padding: 0 .4rem; color: #fff; white-space: nowrap; }
.equal { background: #2e7d4f; } .within { background: #33658a; } .undecided { background: #8a6d1f; }
.expected { background: #7a5195; } .differs { background: #b3261e; }
";

/// What the pictures show.
const LEGEND: &str = "<h2>Pictures of differences</h2><p>The first of each step. A pixel is an element, row by row: \
<span class=v style=\"background:#000\">equal</span> <span class=v style=\"background:#3c3cff\">one ULP</span> \
<span class=v style=\"background:#e63c3c\">half of the bits</span> \
<span class=v style=\"background:#fff;color:#000;border:1px solid\">all bits</span></p>";

/// The report as one HTML file that needs nothing else. Of each capture, there is a picture per port that was written: an
/// element is a pixel, row by row; black is equal, and from blue over red to white it is off by one ULP to all bits. What has
/// as many elements as the frame has pixels, `size`, is drawn in its shape. `unmet` are expected differences that did not come
/// ([`Expectations::apply`](gibs_graph::check::Expectations::apply)).
pub fn html(
    report: &Report,
    captures: &[Capture],
    unmet: &[&Expectation],
    size: [u32; 2],
) -> String {
    let mut body = String::new();
    let verdict = report.verdict();
    // Writing to a string cannot fail.
    let _ = write!(body, "<h1>gibs check: {}</h1>", badge(verdict));
    body += "<table><tr><th>participant<th>device<th>driver<th></tr>";
    for (i, lane) in report.lanes.iter().enumerate() {
        let role = if i == 0 {
            "its values are what all go on from"
        } else {
            ""
        };
        let _ = write!(
            body,
            "<tr><td><code>{}</code><td>{}<td>{}<td class=why>{role}</tr>",
            escaped(&lane.name),
            escaped(&lane.device.name),
            escaped(&lane.device.driver)
        );
    }
    body += "</table>";
    let count = |verdict: Verdict| {
        report
            .pairs()
            .filter(|(.., p)| p.verdict == verdict)
            .count()
    };
    body += "<p>";
    for verdict in [
        Verdict::Equal,
        Verdict::Within,
        Verdict::Undecided,
        Verdict::Expected,
        Verdict::Differs,
    ] {
        let _ = write!(body, "{} {} &emsp;", badge(verdict), count(verdict));
    }
    let _ = write!(
        body,
        "of {} comparisons, {} elements</p>",
        report.pairs().count(),
        report.elements()
    );
    for expectation in unmet {
        let _ = write!(
            body,
            "<p>{} <code>{}</code> on {} is expected to differ and did not: {}</p>",
            badge(Verdict::Differs),
            escaped(&expectation.stage),
            escaped(&expectation.device),
            escaped(&expectation.reason)
        );
    }
    for case in &report.cases {
        table(&mut body, case);
    }
    if !captures.is_empty() {
        body += LEGEND;
    }
    for capture in captures {
        pictures(&mut body, capture, size);
    }
    page(&format!("gibs check: {}", name(verdict)), STYLE, &body)
}

fn name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Equal => "equal",
        Verdict::Within => "within",
        Verdict::Undecided => "undecided",
        Verdict::Expected => "expected",
        Verdict::Differs => "differs",
    }
}

fn badge(verdict: Verdict) -> String {
    let name = name(verdict);
    format!("<span class=\"v {name}\">{name}</span>")
}

fn worst(step: &StepReport) -> Verdict {
    let pairs = step.ports.iter().flat_map(|port| &port.pairs);
    pairs
        .map(|pair| pair.verdict)
        .max()
        .unwrap_or(Verdict::Equal)
}

/// A case, open where something differs.
fn table(page: &mut String, case: &CaseReport) {
    let verdict = case.steps.iter().map(worst).max().unwrap_or(Verdict::Equal);
    let open = if verdict == Verdict::Differs {
        " open"
    } else {
        ""
    };
    let _ = write!(
        page,
        "<details{open}><summary>{} <b>{}</b>: {} steps, {} frames</summary><table>\
         <tr><th>step<th>port<th>pair<th>verdict<th>elements<th>unequal<th>undecided<th>refused<th>worst<th>comparator</tr>",
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
    let pairs = step.ports.iter().flat_map(|port| &port.pairs);
    let _ = write!(
        page,
        "<tr><td><code>{}</code><td><code>{}</code><td>all pairs<td>{}<td class=n>{}</tr>",
        escaped(&step.label),
        ports.join(", "),
        badge(Verdict::Equal),
        pairs.map(|pair| pair.elements).sum::<u64>()
    );
}

fn row(page: &mut String, step: &StepReport, port: &PortReport, pair: &PairReport) {
    let worst = pair.worst.as_ref().map_or(String::new(), |(frame, worst)| {
        format!(
            "frame {frame}, [{}]{}: {} and {} ({:.1} ULP)",
            worst.element, worst.field, worst.a, worst.b, worst.ulps
        )
    });
    let _ = write!(
        page,
        "<tr><td><code>{}</code><td><code>{}</code><td>{}, {}<td>{}<td class=n>{}<td class=n>{}<td class=n>{}<td class=n>{}\
         <td>{}<td class=why>{:?}, {:?}: {}</tr>",
        escaped(&step.label),
        escaped(&port.port),
        escaped(&pair.a),
        escaped(&pair.b),
        badge(pair.verdict),
        pair.elements,
        pair.unequal,
        pair.undecided,
        pair.refused,
        escaped(&worst),
        port.comparator.floats,
        port.comparator.order,
        escaped(port.comparator.reason)
    );
}

/// Pictures of the first two results of a capture.
fn pictures(page: &mut String, capture: &Capture, size: [u32; 2]) {
    let [a, b, ..] = &capture.results[..] else {
        return;
    };
    let _ = write!(
        page,
        "<h3>{}, {}</h3><p>Frame {}; <code>{}</code> against <code>{}</code>.</p>",
        escaped(&capture.case),
        escaped(&capture.label),
        capture.frame,
        escaped(&b.lane),
        escaped(&a.lane)
    );
    for ((&id, x), y) in a.buffers.iter().zip(&a.outputs).zip(&b.outputs) {
        let buffer = &capture.buffers[id as usize];
        let off = apart(&buffer.element, x, y);
        let unequal = off.iter().filter(|ulps| **ulps > 0.0).count();
        if let Some(picture) = picture(&off, size) {
            let _ = write!(
                page,
                "<figure><img width=\"{w}\" alt=\"differences\" src=\"{picture}\">\
                 <figcaption><code>{key}</code>: {unequal} of {all} elements unequal</figcaption></figure>",
                w = 384,
                key = escaped(&buffer.key),
                all = off.len()
            );
        }
    }
}

/// Widest picture; longer results are shown by the largest difference of neighbours.
const SIDE: usize = 256;

/// Differences as the address of a picture; `None` where there is nothing to show.
fn picture(off: &[f64], [columns, rows]: [u32; 2]) -> Option<String> {
    if off.iter().all(|ulps| *ulps == 0.0) {
        return None;
    }
    let per_pixel = off.len().div_ceil(SIDE * SIDE);
    let pixels: Vec<f64> = off
        .chunks(per_pixel)
        .map(|chunk| chunk.iter().copied().fold(0.0, f64::max))
        .collect();
    let width = match u64::from(columns) * u64::from(rows) == off.len() as u64 && per_pixel == 1 {
        true => columns as usize,
        false => (pixels.len() as f64).sqrt().ceil() as usize,
    };
    let mut image = RgbImage::new(width as u32, pixels.len().div_ceil(width) as u32);
    for (i, &ulps) in pixels.iter().enumerate() {
        image.put_pixel((i % width) as u32, (i / width) as u32, color(ulps));
    }
    png(&image)
}

/// Black for equal, then over a logarithmic scale from blue (one ULP) over red (half of the bits of a float) to white.
fn color(ulps: f64) -> Rgb<u8> {
    if ulps <= 0.0 {
        return Rgb([0, 0, 0]);
    }
    let t = ((ulps + 1.0).log2() / 24.0).clamp(0.0, 1.0);
    let mix = |from: f64, to: f64, t: f64| (from + (to - from) * t) as u8;
    match t < 0.5 {
        true => Rgb([mix(60.0, 230.0, 2.0 * t), 60, mix(255.0, 60.0, 2.0 * t)]),
        false => {
            let t = 2.0 * t - 1.0;
            Rgb([
                mix(230.0, 255.0, t),
                mix(60.0, 255.0, t),
                mix(60.0, 255.0, t),
            ])
        }
    }
}
