//! The report as one file that a browser opens, with plots and pictures in it.
use super::sections::{pictures, plots, tables};
use super::table::{asked, missed, rounded, times, with_interval};
use super::{BenchReport, Measured, heading};
use crate::bench::{EqualError, Kind};
use crate::html::{escaped, page};
use crate::words::scene_name;
use std::fmt::Write;

/// What the page looks like beside what all have.
const STYLE: &str = "
body { max-width: 84rem; }
h2 { margin-top: 2.4rem; border-bottom: 1px solid #8888; padding-bottom: .2rem; }
.grid { display: grid; grid-template-columns: repeat(3, 1fr); gap: .8rem; margin: .8rem 0; }
.grid .beside { grid-column: span 2; align-self: end; }
.plots { display: grid; grid-template-columns: repeat(auto-fill, minmax(34rem, 1fr)); gap: .8rem; margin: .8rem 0; }
.plots svg { width: 100%; height: auto; border: 1px solid #8884; border-radius: .3rem; }
.grid figure { margin: 0; }
.grid img { width: 100%; display: block; box-sizing: border-box; }
.grid img.photo { image-rendering: auto; }
.wide { overflow-x: auto; }
table.figures td, table.figures th { padding: .15rem .5rem; vertical-align: bottom; }
table.figures td { white-space: nowrap; }
table.figures th.n { text-align: right; }
table.figures tr:nth-child(even) td { background: #8881; }
table.figures td:first-child { white-space: normal; min-width: 9rem; }
table.figures tr.best td:first-child::after { content: ' \\25CF'; color: #0072b2; }
.bar { display: inline-block; width: 10rem; height: .8rem; position: relative; background: #8882; vertical-align: middle; }
.bar i { position: absolute; top: 0; bottom: 0; }
.bar i.more { background: #d55e00; } .bar i.less { background: #0072b2; }
.bar b { position: absolute; left: 50%; top: -.15rem; bottom: -.15rem; width: 1px; background: #8889; }
.ramp { display: inline-block; width: 9rem; height: .7rem; vertical-align: middle; border: 1px solid #8888; }
";

const READING: &str = "<details><summary>How to read this</summary><ul>\
<li>Errors are of <code>E</code>, indirect irradiance, at each pixel that the truth has, as <code>gibs compare</code> computes them. \
MAPE is the mean relative error; relMSE weighs large errors more, as noise does; bias is the mean difference over the mean.\
<li>&plusmn; and the bands of curves are 95 % confidence intervals over the seeds, by Student's t. What falls into them has not been shown to differ.\
<li>Times are those of frames, from their start until the device was done, without reading anything back. All configurations took turns frame by frame, \
so that whatever else the machine did fell on all of them; path tracing ran after them.\
<li><i>Path tracing</i> has a ray to an emitter or the sky at each vertex, <i>brute force</i> has none. <i>Equal rays</i> and <i>equal time</i> give them what \
the first row had up to that frame. <i>The same error</i> is what they need to be as right as the first row.\
<li>Where equal rays or an equal time were missed, the name of the row says how much of it was taken: samples are whole, so that a large one may miss by much, and \
times are noisy.\
<li>A dot behind a name means that nothing measured has a smaller MAPE in no more time, or the same in less (the Pareto front).</ul></details>";

/// The report as one HTML file that needs nothing else and runs no script.
pub fn html(report: &BenchReport) -> String {
    let mut body = String::from("<h1>gibs bench: speed against error</h1>");
    // Writing to a string cannot fail.
    let _ = write!(
        body,
        "<p><code>{}</code></p><p>gibs {} on {}, {} threads.</p>",
        escaped(&report.command),
        escaped(&report.machine.gibs),
        escaped(&report.machine.system),
        report.machine.threads
    );
    for missing in &report.not_run {
        let _ = write!(
            body,
            "<p><b>Not run</b> on <code>{}</code>: {}</p>",
            escaped(&missing.backend),
            escaped(&missing.reason)
        );
    }
    for failed in &report.failed {
        let on = failed.backend.as_ref();
        let on = on.map(|backend| format!(" on <code>{}</code>", escaped(backend)));
        let _ = write!(
            body,
            "<p><b>Not measured</b>{}: <code>{}</code>: {}</p>",
            on.unwrap_or_default(),
            escaped(&failed.scene),
            escaped(&failed.reason)
        );
    }
    body += READING;
    summary(&mut body, &report.measured);
    for measured in &report.measured {
        let _ = write!(
            body,
            "<h2>{} on {}</h2><p>{}. Driver: {}.</p>",
            escaped(&scene_name(&measured.scene)),
            escaped(&measured.backend),
            escaped(&heading(measured)),
            escaped(&measured.driver)
        );
        pictures(&mut body, measured);
        plots(&mut body, measured);
        tables(&mut body, measured);
    }
    page("gibs bench", STYLE, &body)
}

/// What matters most, a row for each scene, backend and number of frames.
fn summary(body: &mut String, all: &[Measured]) {
    *body += "<div class=wide><table class=figures><tr><th>scene<th>backend<th class=n>frames<th class=n>seconds<th class=n>MAPE\
              <th class=n>relMSE<th class=n>path tracing in that time: MAPE<th class=n>path tracing's time for that relMSE\
              <th class=n>brute force's time for that relMSE</tr>";
    for measured in all {
        for frames in asked(&measured.rows) {
            let at = |kind: Kind| {
                let row = measured.rows.iter().find(|row| row.kind == kind)?;
                row.after.iter().find(|after| after.frames == frames)
            };
            let Some(own) = at(Kind::Settings) else {
                continue;
            };
            let traced = at(Kind::EqualTime).map_or_else(String::new, |after| {
                let mape = with_interval(after.errors.mape, 100.0, false);
                format!("{mape} %{}", missed(after))
            });
            let needs = |baseline: &str| {
                let of = |e: &&EqualError| {
                    e.baseline == baseline && e.frames == frames && e.metric == "rel_mse"
                };
                measured.equal_error.iter().find(of).map(|equal| {
                    match (equal.unreached, equal.fewer) {
                        (1.., 1..) => escaped(&times(equal)),
                        _ => escaped(&format!("{} times", times(equal))),
                    }
                })
            };
            let _ = write!(
                body,
                "<tr><td>{}<td>{}<td class=n>{frames}<td class=n>{}<td class=n>{} %<td class=n>{}<td class=n>{traced}\
                 <td class=n>{}<td class=n>{}</tr>",
                escaped(&scene_name(&measured.scene)),
                escaped(&measured.backend),
                rounded(own.seconds.mean, 3, false),
                with_interval(own.errors.mape, 100.0, false),
                with_interval(own.errors.rel_mse, 1.0, false),
                needs("path tracing").unwrap_or_default(),
                needs("brute force").unwrap_or_else(|| {
                    let same = !measured.same_as_path_tracing.is_empty();
                    if same { "the same" } else { "" }.to_owned()
                }),
            );
        }
    }
    *body += "</table></div>";
}
