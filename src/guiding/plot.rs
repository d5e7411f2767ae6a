//! Error against rays as an SVG picture: both axes logarithmic, as noise falls by a power of the rays.
use super::{Error, Row};
use std::fmt::Write;

const SIZE: [f64; 2] = [640.0, 420.0];

/// Left, top, right and bottom of the area of the curves.
const AREA: [f64; 4] = [70.0, 46.0, 620.0, 370.0];

/// One curve: its name, its colour and its values.
type Curve = (&'static str, &'static str, fn(&Row) -> Error);

const CURVES: [Curve; 2] = [
    ("cosine lobe", "#2166ac", |row| row.cosine),
    ("guided", "#e08214", |row| row.guided),
];

/// The errors under one environment, with bands two standard errors wide to either side. Errors of zero do not show.
pub fn plot(title: &str, rows: &[Row]) -> String {
    let shown = |e: &Error| e.error.is_finite() && e.error > 0.0;
    let errors: Vec<f64> = rows
        .iter()
        .flat_map(|row| CURVES.map(|(_, _, of)| of(row)))
        .filter(shown)
        .map(|e| e.error)
        .collect();
    let least = errors.iter().copied().fold(f64::MAX, f64::min).min(1.0);
    let most = errors.iter().copied().fold(0.0, f64::max).max(least);
    let axes = Axes {
        x: bounds(rows.iter().map(|row| f64::from(row.rays)), 1.0),
        y: [(least * 0.7).log10(), (most * 1.4).log10()],
    };
    let mut svg = String::new();
    // Writing to a string does not fail.
    let _ = draw(&mut svg, title, rows, &axes);
    svg
}

/// Decadic logarithms of the smallest and the largest value, apart at least a little.
fn bounds(values: impl Iterator<Item = f64>, none: f64) -> [f64; 2] {
    let values: Vec<f64> = values.collect();
    let least = values.iter().copied().fold(f64::MAX, f64::min);
    let most = values.iter().copied().fold(0.0, f64::max);
    match least <= most {
        true => [least.log10(), most.log10().max(least.log10() + 0.1)],
        false => [none.log10(), none.log10() + 1.0],
    }
}

/// Decadic logarithms at the ends of the axes.
struct Axes {
    x: [f64; 2],
    y: [f64; 2],
}

impl Axes {
    fn x(&self, value: f64) -> f64 {
        let share = (value.log10() - self.x[0]) / (self.x[1] - self.x[0]);
        AREA[0] + share * (AREA[2] - AREA[0])
    }

    fn y(&self, value: f64) -> f64 {
        let share = (value.log10() - self.y[0]) / (self.y[1] - self.y[0]);
        AREA[3] + share.clamp(0.0, 1.0) * (AREA[1] - AREA[3])
    }
}

fn draw(svg: &mut String, title: &str, rows: &[Row], axes: &Axes) -> std::fmt::Result {
    let [width, height] = SIZE;
    let [left, top, right, bottom] = AREA;
    writeln!(
        svg,
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" font-family="sans-serif" font-size="12">"#
    )?;
    writeln!(
        svg,
        r#"<rect width="{width}" height="{height}" fill="white"/>"#
    )?;
    writeln!(
        svg,
        r#"<text x="{left}" y="26" font-size="15">{}</text>"#,
        escape(title)
    )?;
    for row in rows {
        let (x, rays) = (axes.x(f64::from(row.rays)), row.rays);
        writeln!(
            svg,
            r##"<path d="M{x:.1} {top}V{bottom}" stroke="#ddd"/><text x="{x:.1}" y="{:.1}" text-anchor="middle">{rays}</text>"##,
            bottom + 18.0
        )?;
    }
    for (value, label) in percents(axes.y) {
        let y = axes.y(value);
        writeln!(
            svg,
            r##"<path d="M{left} {y:.1}H{right}" stroke="#ddd"/><text x="{:.1}" y="{:.1}" text-anchor="end">{label}</text>"##,
            left - 8.0,
            y + 4.0
        )?;
    }
    writeln!(
        svg,
        r#"<text x="{:.1}" y="{:.1}" text-anchor="middle">rays of a probe</text>"#,
        (left + right) / 2.0,
        bottom + 40.0
    )?;
    writeln!(
        svg,
        r#"<text transform="translate(18 {:.1}) rotate(-90)" text-anchor="middle">relative error of irradiance</text>"#,
        (top + bottom) / 2.0
    )?;
    for (index, (name, colour, of)) in (0..).zip(CURVES) {
        curve(svg, rows, axes, colour, of)?;
        let x = right - 200.0 + f64::from(index) * 110.0;
        writeln!(
            svg,
            r#"<path d="M{x} 22h22" stroke="{colour}" stroke-width="2"/><text x="{}" y="26">{name}</text>"#,
            x + 28.0
        )?;
    }
    writeln!(svg, "</svg>")
}

fn curve(
    svg: &mut String,
    rows: &[Row],
    axes: &Axes,
    colour: &str,
    of: fn(&Row) -> Error,
) -> std::fmt::Result {
    let points: Vec<(f64, Error)> = rows
        .iter()
        .map(|row| (axes.x(f64::from(row.rays)), of(row)))
        .filter(|(_, e)| e.error.is_finite() && e.error > 0.0)
        .collect();
    let at = |x: f64, value: f64| format!("{x:.1},{:.1} ", axes.y(value.max(1e-12)));
    let upper = points.iter().map(|(x, e)| at(*x, e.error + e.plus_minus));
    let lower = points
        .iter()
        .rev()
        .map(|(x, e)| at(*x, e.error - e.plus_minus));
    let band: String = upper.chain(lower).collect();
    let line: String = points.iter().map(|(x, e)| at(*x, e.error)).collect();
    writeln!(
        svg,
        r#"<polygon points="{band}" fill="{colour}" fill-opacity="0.2"/><polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"/>"#
    )
}

/// Values of 1, 2 and 5 times a power of ten between two logarithms, as percentages.
fn percents([least, most]: [f64; 2]) -> Vec<(f64, String)> {
    let mut ticks = Vec::new();
    for power in (least.floor() as i32)..=(most.ceil() as i32) {
        for digit in [1.0, 2.0, 5.0] {
            let value = digit * 10f64.powi(power);
            if (least..=most).contains(&value.log10()) {
                let decimals = (-(power + 2)).max(0) as usize;
                ticks.push((value, format!("{:.decimals$} %", value * 100.0)));
            }
        }
    }
    ticks
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
