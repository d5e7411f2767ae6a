//! The drawing of a plot, with plotters.
use super::axis::Span;
use super::{Marks, Plot, Scale, Series};
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;

/// Width and height. Plotters rounds coordinates to whole units, so that these are fine ones; a page scales them down.
const SIZE: (u32, u32) = (1280, 760);

/// Size of text, as plotters takes it: 1.24 times that of the font.
const TEXT: i32 = 28;

/// Width of an average character of that size.
const CHARACTER: f64 = 12.5;

/// Radius of a dot.
const DOT: i32 = 5;

const INK: RGBColor = RGBColor(0x24, 0x29, 0x2f);
const RULE: RGBColor = RGBColor(0xd8, 0xde, 0xe4);

/// M. Okabe and K. Ito, "Color Universal Design", 2008, without yellow, which is too light for a line on white.
const COLORS: [RGBColor; 7] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x00, 0x00, 0x00),
];

type Drawn<'a, T = ()> =
    Result<T, DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

pub(super) fn svg(plot: &Plot) -> String {
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
    // Only a file can fail to be written; this is a string.
    let _ = draw(plot, &root);
    drop(root);
    svg
}

fn draw<'a>(plot: &Plot, root: &Area<'a>) -> Drawn<'a> {
    root.fill(&WHITE)?;
    let legend = match plot.series.len() {
        0 | 1 => 24,
        _ => legend_width(&plot.series),
    };
    let (left, right) = root.split_horizontally(SIZE.0 as i32 - legend);
    curves(plot, &left)?;
    if plot.series.len() > 1 {
        entries(&plot.series, &right)?;
    }
    root.present()
}

fn curves<'a>(plot: &Plot, area: &Area<'a>) -> Drawn<'a> {
    let points = || plot.series.iter().flat_map(|s| &s.points);
    let x = Span::of(plot.x.scale, points().map(|p| p[0]));
    let y = Span::of(plot.y.scale, points().map(|p| p[1]).chain(seen_bands(plot)));
    let mut chart = ChartBuilder::on(area)
        .caption(&plot.title, ("sans-serif", TEXT + 6, &INK))
        .margin(18)
        .x_label_area_size(76)
        .y_label_area_size(112)
        .build_cartesian_2d(x.clone(), y.clone())?;
    chart
        .configure_mesh()
        .bold_line_style(RULE)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .label_style(("sans-serif", TEXT, &INK))
        .axis_desc_style(("sans-serif", TEXT, &INK))
        .x_desc(&plot.x.label)
        .y_desc(&plot.y.label)
        .draw()?;
    for (index, series) in plot.series.iter().enumerate() {
        let line: Vec<(f64, f64)> = series
            .points
            .iter()
            .filter_map(|p| Some((x.place(p[0])?, y.place(p[1])?)))
            .collect();
        let ends = series.points.iter().zip(&series.band);
        let ends: Vec<(f64, [f64; 2])> = ends
            .filter(|(_, band)| band.iter().all(|end| end.is_finite()))
            .filter_map(|(p, band)| Some((x.place(p[0])?, band.map(|end| y.held(end)))))
            .collect();
        let there = ends.iter().map(|(x, band)| (*x, band[1]));
        let back = ends.iter().rev().map(|(x, band)| (*x, band[0]));
        let outline: Vec<(f64, f64)> = there.chain(back).collect();
        if !outline.is_empty() {
            chart.draw_series([Polygon::new(outline, color(index).mix(0.15))])?;
        }
        if series.marks == Marks::Stairs {
            chart.draw_series(LineSeries::new(stairs(&line), INK.stroke_width(3)))?;
            continue;
        }
        let style = color(index).stroke_width(3);
        match (series.marks, dashed(index)) {
            (Marks::Joined, false) => {
                chart.draw_series(LineSeries::new(line.clone(), style))?;
            }
            (Marks::Joined, true) => {
                chart.draw_series(DashedLineSeries::new(line.clone(), 9, 6, style))?;
            }
            _ => {}
        }
        let dots = line.iter();
        match index / COLORS.len() % 3 {
            0 => chart.draw_series(dots.map(|p| Circle::new(*p, DOT, color(index).filled())))?,
            1 => chart.draw_series(dots.map(|p| Circle::new(*p, DOT, style)))?,
            _ => chart.draw_series(dots.map(|p| Cross::new(*p, DOT, style)))?,
        };
    }
    Ok(())
}

/// Points with a corner between any two, so that each value lasts until the next.
fn stairs(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut line = Vec::new();
    let mut last = None;
    for &(x, y) in points {
        line.extend(last.map(|before| (x, before)));
        line.push((x, y));
        last = Some(y);
    }
    line
}

/// Ends of bands that count for the span: on a logarithmic axis a wide band, or one that reaches down to zero, would take all of it.
fn seen_bands(plot: &Plot) -> impl Iterator<Item = f64> {
    let bands = plot
        .series
        .iter()
        .flat_map(|s| s.points.iter().zip(&s.band));
    bands.flat_map(|(p, band)| match plot.y.scale {
        Scale::Linear => *band,
        Scale::Log => band.map(|end| end.max(0.3 * p[1]).min(p[1] / 0.3)),
    })
}

fn color(index: usize) -> RGBColor {
    COLORS[index % COLORS.len()]
}

fn dashed(index: usize) -> bool {
    index / COLORS.len() % 2 == 1
}

/// Room that the legend takes, half of the picture at most.
fn legend_width(series: &[Series]) -> i32 {
    let longest = series.iter().map(|s| s.name.chars().count()).max();
    let text = longest.unwrap_or(0) as f64 * CHARACTER;
    (text as i32 + 80).min(SIZE.0 as i32 / 2)
}

fn entries<'a>(series: &[Series], area: &Area<'a>) -> Drawn<'a> {
    let most = (SIZE.1 as i32 - 120) / series.len().max(1) as i32;
    let height = most.min(TEXT + 10);
    for (index, series) in series.iter().enumerate() {
        let y = 66 + index as i32 * height;
        let middle = y + TEXT / 2 - 3;
        let line = vec![(0, middle), (44, middle)];
        let style = color(index).stroke_width(3);
        match (series.marks, dashed(index)) {
            (Marks::Stairs, _) => area.draw(&PathElement::new(line, INK.stroke_width(3)))?,
            (Marks::Joined, false) => area.draw(&PathElement::new(line, style))?,
            (Marks::Joined, true) => area.draw(&DashedPathElement::new(line, 9, 6, style))?,
            (Marks::Scattered, _) => {}
        }
        let dot = (22, middle);
        match (series.marks, index / COLORS.len() % 3) {
            (Marks::Stairs, _) => {}
            (_, 0) => area.draw(&Circle::new(dot, DOT, color(index).filled()))?,
            (_, 1) => area.draw(&Circle::new(dot, DOT, style))?,
            _ => area.draw(&Cross::new(dot, DOT, style))?,
        }
        let font = ("sans-serif", TEXT).into_font().color(&INK);
        area.draw(&Text::new(series.name.clone(), (56, y), font))?;
    }
    Ok(())
}
