use super::axis::Span;
use super::*;

fn labels(scale: Scale, values: &[f64]) -> Vec<String> {
    let span = Span::of(scale, values.iter().copied());
    span.ticks().into_iter().map(|t| span.label(t)).collect()
}

#[test]
fn round_values_are_labelled() {
    assert_eq!(
        labels(Scale::Linear, &[0.0, 10.0]),
        ["0", "2", "4", "6", "8", "10"]
    );
    assert_eq!(
        labels(Scale::Linear, &[-0.02, 0.03]),
        ["-0.02", "-0.01", "0", "0.01", "0.02", "0.03"]
    );
    assert_eq!(
        labels(Scale::Log, &[1.0, 100.0]),
        ["1", "2", "5", "10", "20", "50", "100"]
    );
    assert_eq!(
        labels(Scale::Log, &[1e-3, 1e3]),
        ["0.001", "0.01", "0.1", "1", "10", "100", "1000"]
    );
    assert_eq!(labels(Scale::Log, &[2.0, 6.0]), ["2", "3", "4", "5", "6"]);
    // No digit times a power of ten lies within.
    assert_eq!(
        labels(Scale::Log, &[1.22, 1.28]),
        ["1.22", "1.24", "1.26", "1.28"]
    );
    assert_eq!(
        labels(Scale::Log, &[1e-9, 1e-8]),
        ["1e-9", "2e-9", "5e-9", "1e-8"]
    );
}

/// Whatever the values, there is something to read and not too much of it, within the span.
#[test]
fn every_span_has_some_ticks() {
    for scale in [Scale::Linear, Scale::Log] {
        for least in [1e-30, 1e-3, 0.97, 1.0, 3.3, 1e6, 1e20] {
            for ratio in [1.0, 1.0 + 1e-9, 1.001, 1.3, 2.0, 30.0, 1e4, 1e12] {
                let span = Span::of(scale, [least, least * ratio].into_iter());
                let ticks = span.ticks();
                assert!(
                    (1..=14).contains(&ticks.len()),
                    "{scale:?} {least} {ratio}: {ticks:?}"
                );
                let [low, high] = span.ends;
                assert!(low < high && ticks.iter().all(|t| (low..=high).contains(t)));
            }
        }
    }
}

fn plot(series: Vec<Series>) -> Plot {
    Plot {
        title: "a < b".into(),
        x: Axis::log("rays"),
        y: Axis::log("error & more"),
        series,
    }
}

fn series(name: &str, points: &[[f64; 2]]) -> Series {
    Series {
        name: name.into(),
        points: points.to_vec(),
        band: points.iter().map(|p| [p[1] - 0.3, p[1] + 0.3]).collect(),
        ..Series::default()
    }
}

/// The coordinates of the elements of a name.
fn coordinates(svg: &str, element: &str) -> Vec<Vec<[i32; 2]>> {
    let start = format!("<{element} ");
    let lines = svg.lines().filter(|line| line.starts_with(&start));
    let points = |line: &str| {
        let text = line.split("points=\"").nth(1)?.split('"').next()?;
        let pairs = text.split_whitespace().filter_map(|p| p.split_once(','));
        Some(
            pairs
                .map(|(x, y)| [x.parse().expect("x"), y.parse().expect("y")])
                .collect(),
        )
    };
    lines.filter_map(points).collect()
}

#[test]
fn curves_bands_and_names_are_drawn() {
    let rising = series("rising", &[[1.0, 1.0], [10.0, 10.0], [100.0, 100.0]]);
    let flat = series("flat", &[[1.0, 5.0], [100.0, 5.0]]);
    let svg = plot(vec![rising, flat]).svg();
    assert!(
        svg.starts_with("<svg") && svg.ends_with("</svg>\n"),
        "{svg}"
    );
    for text in ["a &lt; b", "error &amp; more", "rays", "rising", "flat"] {
        assert!(svg.contains(text), "{text}");
    }
    // Equal ratios are equal distances, to the rounding of coordinates; y grows upwards, SVG's downwards.
    let curves = coordinates(&svg, "polyline");
    let rising = curves.iter().find(|c| c.len() == 3).expect("three points");
    let steps = [0, 1].map(|i| [0, 1].map(|k| rising[i + 1][k] - rising[i][k]));
    assert!(steps[0][0] > 0 && steps[0][1] < 0, "{steps:?}");
    assert!(
        (0..2).all(|k| (steps[0][k] - steps[1][k]).abs() <= 1),
        "{steps:?}"
    );
    let bands = coordinates(&svg, "polygon");
    assert_eq!(bands.iter().map(Vec::len).collect::<Vec<_>>(), [6, 4]);
    // One curve needs no legend.
    assert!(
        !plot(vec![series("alone", &[[1.0, 1.0]])])
            .svg()
            .contains("alone")
    );
}

/// Zeros on a logarithmic axis, no numbers, nothing at all, one point, and bands that are not there or reach below zero.
#[test]
fn what_cannot_be_drawn_is_left_out() {
    let points = [
        [1.0, 0.0],
        [2.0, f64::NAN],
        [f64::INFINITY, 1.0],
        [4.0, 0.1],
    ];
    for all in [
        vec![],
        vec![Series::default()],
        vec![series("nothing", &points[..3]), series("one", &points)],
        vec![Series {
            band: vec![[f64::NAN, 1.0]],
            ..series("short band", &points)
        }],
    ] {
        for scale in [Scale::Linear, Scale::Log] {
            let mut plot = plot(all.clone());
            plot.y.scale = scale;
            let svg = plot.svg();
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN") && !svg.contains("inf"));
            // Within the picture, but for the rounding of its edge.
            for [x, y] in coordinates(&svg, "polygon").into_iter().flatten() {
                assert!((0..=1280).contains(&x) && (0..=760).contains(&y), "{x} {y}");
            }
        }
    }
}

#[test]
fn the_eighth_curve_is_dashed() {
    let curve = |n: usize| series(&format!("{n}"), &[[1.0, n as f64], [9.0, n as f64]]);
    let lines = |count: usize| {
        let svg = plot((1..=count).map(curve).collect()).svg();
        svg.matches("<polyline").count()
    };
    assert_eq!(lines(7) - lines(6), 2, "a curve and its line in the legend");
    assert!(lines(8) - lines(7) > 4, "dashes are lines of their own");
}

#[test]
fn marks_are_dots_alone_and_steps() {
    let points = [[1.0, 9.0], [4.0, 3.0], [8.0, 1.0]];
    let marked = |marks| Series {
        marks,
        band: Vec::new(),
        ..series("marked", &points)
    };
    let dots = plot(vec![marked(Marks::Scattered)]).svg();
    let stairs = plot(vec![marked(Marks::Stairs)]).svg();
    assert_eq!(dots.matches("<circle").count(), 3);
    assert_eq!(stairs.matches("<circle").count(), 0);
    let steps = coordinates(&stairs, "polyline");
    let steps = steps
        .iter()
        .find(|line| line.len() == 5)
        .expect("three points and two corners");
    // To the right first, then down.
    assert!(steps[1][1] == steps[0][1] && steps[1][0] == steps[2][0] && steps[2][1] > steps[0][1]);
}
