//! What the page shows of one scene on one backend.
use super::Measured;
use super::plots::{MAPE, Over, REL_MSE, curves, elements, front};
use super::table::{EQUAL_HEADS, HEADS, asked, cells, equal_cells, name, rounded, with_interval};
use crate::bench::{Kind, Row, Shot};
use crate::compare::HEAT_FULL_SCALE;
use crate::html::{escaped, png};
use crate::picture::{FINAL_IMAGE, Picture, inferno, tone_map};
use crate::words::counted;
use std::fmt::Write;

/// Pictures, with maps of their errors below.
pub(super) fn pictures(body: &mut String, measured: &Measured) {
    let pictures = &measured.pictures;
    if pictures.shots.is_empty() {
        return;
    }
    if let Some(look) = &pictures.look
        && let Some(address) = photo(&look.picture, measured.exposure)
    {
        let samples = match (look.samples, &measured.truth.file) {
            // A file is the truth; what is drawn in its place is not.
            (Some(samples), Some(file)) => format!(
                "<b>To look at</b>: path-traced here with {samples} samples of every pixel; errors are against {}",
                escaped(file)
            ),
            (Some(samples), None) => {
                format!("<b>Truth</b>, path-traced with {samples} samples of every pixel")
            }
            (None, _) => "<b>Truth</b>".to_owned(),
        };
        let _ = write!(
            body,
            "<div class=grid><figure><img class=photo alt=\"truth\" src=\"{address}\"><figcaption>{samples}</figcaption>\
             </figure><div class=\"beside why\"><p>Below: pictures of the first seed, and their relative errors at the pixels of the \
             truth.<br>Black is none, the brightest {:.0} % and more, grey is not compared: \
             <span class=ramp style=\"background:linear-gradient(90deg,{})\"></span></div></div>",
            HEAT_FULL_SCALE * 100.0,
            ramp()
        );
    }
    for frames in asked(&measured.rows) {
        *body += "<div class=grid>";
        for shot in pictures.shots.iter().filter(|shot| shot.frames == frames) {
            figure(body, measured, shot);
        }
        *body += "</div>";
    }
}

fn figure(body: &mut String, measured: &Measured, shot: &Shot) {
    let Some(address) = photo(&shot.picture, measured.exposure) else {
        return;
    };
    let heat = png(&shot.heat).unwrap_or_default();
    let frames = shot.frames;
    let row = measured.rows.iter().find(|row| row.name == shot.name);
    let what = match row {
        Some(row) if row.kind == Kind::EqualTime => format!("to {}", counted(frames, "frame")),
        _ => format!("after {}", counted(frames, "frame")),
    };
    let after = row.and_then(|row| row.after.iter().find(|after| after.frames == frames));
    let name = match row.zip(after) {
        Some((row, after)) => name(row, after),
        None => shot.name.clone(),
    };
    let name = escaped(&name);
    let seconds = after.map_or_else(String::new, |after| {
        format!(", {} s", rounded(after.seconds.mean, 2, false))
    });
    let _ = write!(
        body,
        "<figure><img class=photo alt=\"{name} {what}\" src=\"{address}\"><img alt=\"errors of {name} {what}\" src=\"{heat}\">\
         <figcaption><b>{name}</b> {what}{seconds}: MAPE {} %</figcaption></figure>",
        rounded(shot.mape * 100.0, 3, false)
    );
}

/// A picture as people see it: the final image, or the first colours that it has.
fn photo(picture: &Picture, exposure: f32) -> Option<String> {
    let layers = picture.rgb_layers();
    let layer = layers.first().copied().unwrap_or(FINAL_IMAGE);
    let rgb = picture.rgb(layer).ok()?;
    png(&tone_map(picture.width, picture.height, rgb, exposure))
}

/// The colours of a map of errors, for a style.
fn ramp() -> String {
    let color = |i: u8| {
        let [r, g, b] = inferno(f32::from(i) / 8.0);
        format!("rgb({r},{g},{b})")
    };
    (0..=8).map(color).collect::<Vec<_>>().join(",")
}

/// The plots that matter, and the others to unfold.
pub(super) fn plots(body: &mut String, measured: &Measured) {
    *body += "<div class=plots>";
    *body += &curves(measured, Over::Seconds, MAPE).svg();
    *body += &front(measured).svg();
    *body += &curves(measured, Over::Frames, MAPE).svg();
    *body += &curves(measured, Over::Rays, MAPE).svg();
    *body += "</div><details><summary>Plots of relMSE</summary><div class=plots>";
    for over in Over::ALL {
        *body += &curves(measured, over, REL_MSE).svg();
    }
    *body += "</div></details>";
    if measured.rows.iter().any(|row| row.kind == Kind::Element) {
        *body += "<details><summary>Plots of each element switched</summary><div class=plots>";
        for over in [Over::Seconds, Over::Frames] {
            *body += &elements(measured, over, MAPE).svg();
        }
        *body += "</div></details>";
    }
}

/// Elements, equal error, and all figures.
pub(super) fn tables(body: &mut String, measured: &Measured) {
    for frames in asked(&measured.rows).into_iter().rev().take(1) {
        switched(body, &measured.rows, frames);
    }
    if !measured.equal_error.is_empty() {
        let _ = write!(
            body,
            "<h3>What path tracing needs for the same error</h3><div class=wide><table class=figures><tr><th>{}</tr>",
            EQUAL_HEADS.join("<th class=n>")
        );
        for equal in &measured.equal_error {
            row(body, "", &equal_cells(equal));
        }
        *body += "</table></div>";
    }
    *body += "<h3>All figures</h3>";
    for frames in asked(&measured.rows) {
        let _ = write!(
            body,
            "<div class=wide><table class=figures><tr><th>after {}<th class=n>{}</tr>",
            counted(frames, "frame"),
            HEADS.join("<th class=n>")
        );
        for each in &measured.rows {
            for after in each.after.iter().filter(|after| after.frames == frames) {
                let mut all = vec![name(each, after)];
                all.extend(cells(after));
                row(body, if after.pareto { "best" } else { "" }, &all);
            }
        }
        *body += "</table></div>";
    }
}

fn row(body: &mut String, class: &str, cells: &[String]) {
    let _ = write!(body, "<tr class=\"{class}\">");
    for (i, cell) in cells.iter().enumerate() {
        let class = if i == 0 { "" } else { " class=n" };
        let _ = write!(body, "<td{class}>{}", escaped(cell));
    }
    *body += "</tr>";
}

/// What each element gains and costs.
fn switched(body: &mut String, rows: &[Row], frames: u32) {
    if !rows.iter().any(|row| row.kind == Kind::Element) {
        return;
    }
    let _ = write!(
        body,
        "<h3>Each element switched, after {}</h3><div class=wide><table class=figures><tr><th>settings\
         <th colspan=2>error (MAPE) over the first row's<th colspan=2>time over the first row's<th></tr>",
        counted(frames, "frame")
    );
    for row in rows.iter().filter(|row| row.kind == Kind::Element) {
        for after in row.after.iter().filter(|after| after.frames == frames) {
            let _ = write!(
                body,
                "<tr><td>{}<td class=n>{}<td>{}<td class=n>{}<td>{}<td class=why>{}</tr>",
                escaped(&row.name),
                with_interval(after.mape_ratio, 1.0, false),
                bar(after.mape_ratio.mean),
                rounded(after.ratio.median, 3, false),
                bar(after.ratio.median),
                escaped(&row.about)
            );
        }
    }
    *body += "</table></div>";
}

/// The ratio at which a bar ends.
const MOST: f64 = 4.0;

/// A ratio as a bar from the middle, to the right where it is above one; logarithmic, so that half and twice are as long.
fn bar(ratio: f64) -> String {
    let length = (ratio.ln() / MOST.ln()).clamp(-1.0, 1.0) * 50.0;
    let bar = match length {
        more if more > 0.0 => format!("<i class=more style=\"left:50%;width:{more:.1}%\"></i>"),
        less if less < 0.0 => format!("<i class=less style=\"right:50%;width:{:.1}%\"></i>", -less),
        _ => String::new(),
    };
    format!("<span class=bar>{bar}<b></b></span>")
}
