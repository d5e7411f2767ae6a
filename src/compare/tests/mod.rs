mod broken;
mod halves;

use super::*;
use crate::picture::{FINAL_IMAGE, NON_FINITE_COLOR, OUTSIDE_COLOR, inferno};

/// Rounding of f32 pixel values; the sums are f64.
const ROUNDING: f64 = 1e-6;

fn close(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() <= ROUNDING * expected.abs().max(1.0),
        "found {found}, expected {expected}"
    );
}

/// A picture with the layer E in grey.
fn grey(width: u32, height: u32, value: impl Fn(u32, u32) -> f32) -> Picture {
    let mut picture = Picture::new(width, height);
    let plane: Vec<f32> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| value(x, y))
        .collect();
    picture
        .set_rgb("E", [plane.clone(), plane.clone(), plane])
        .unwrap();
    picture
}

fn with(mut picture: Picture, name: &str, value: impl Fn(u32, u32) -> f32) -> Picture {
    let (width, height) = (picture.width, picture.height);
    let values = (0..width * height).map(|i| value(i % width, i / width));
    picture.set_scalar(name, values.collect()).unwrap();
    picture
}

/// Every error.
fn all(m: &Metrics) -> [f64; 7] {
    [
        m.rel_mse,
        m.rmse,
        m.mape,
        m.bias,
        m.p99,
        m.block_error,
        m.flip,
    ]
}

fn run(ours: &Picture, truth: &Picture) -> Report {
    compare(ours, truth, &CompareOptions::default()).unwrap()
}

#[test]
fn equal_pictures_have_no_error() {
    let truth = grey(20, 12, |x, y| 0.1 + (x * y) as f32);
    let report = run(&truth, &truth);
    let m = report.metrics;
    for value in all(&m) {
        assert_eq!(value, 0.0);
    }
    assert_eq!(m.blocks, 6);
    assert!(report.passed());
}

#[test]
fn a_constant_factor_gives_closed_forms() {
    // o = 1.5 t with t = 2 everywhere, so m = 2 and each relative error is 0.5.
    let report = run(&grey(16, 16, |_, _| 3.0), &grey(16, 16, |_, _| 2.0));
    let m = report.metrics;
    close(report.mean, 2.0);
    close(m.rel_mse, 1.0 / (4.0 + 0.02 * 0.02));
    close(m.rmse, 0.5);
    close(m.mape, 0.5);
    close(m.bias, 0.5);
    close(m.p99, 0.5);
    close(m.block_error, 0.5);
    close(report.exposure, 0.09);
}

#[test]
fn dark_pixels_divide_by_the_floor() {
    // Half of the pixels are black: m = 1, floor 0.01. Ours is 0.005 brighter everywhere.
    let truth = grey(16, 16, |x, _| if x < 8 { 0.0 } else { 2.0 });
    let ours = grey(16, 16, |x, _| if x < 8 { 0.005 } else { 2.005 });
    let m = run(&ours, &truth).metrics;
    close(m.mape, (0.5 + 0.0025) / 2.0);
    close(m.block_error, (0.5 + 0.0025) / 2.0);
    close(m.p99, 0.5);
    close(m.bias, 0.005);
    close(m.rmse, 0.005);
    let squares = [0.005_f64.powi(2) / 1e-4, 0.005_f64.powi(2) / (4.0 + 1e-4)];
    close(m.rel_mse, (squares[0] + squares[1]) / 2.0);
}

#[test]
fn colour_weighs_by_luminance_except_in_rel_mse() {
    let truth = grey(8, 8, |_, _| 1.0);
    let mut ours = truth.clone();
    ours.channels.insert("E.G".to_owned(), vec![1.1; 64]);
    let m = run(&ours, &truth).metrics;
    close(m.bias, 0.07152);
    close(m.mape, 0.07152);
    close(m.rel_mse, 0.01 / 3.0 / (1.0 + 1e-4));
}

#[test]
fn noise_that_averages_out_in_blocks_leaves_no_block_error() {
    let truth = grey(16, 16, |_, _| 1.0);
    let ours = grey(16, 16, |x, y| if (x + y) % 2 == 0 { 1.25 } else { 0.75 });
    let m = run(&ours, &truth).metrics;
    close(m.mape, 0.25);
    close(m.rmse, 0.25);
    close(m.bias, 0.0);
    close(m.block_error, 0.0);
}

#[test]
fn the_percentile_is_the_nearest_rank() {
    // 200 pixels with relative errors 0.001 to 0.200: 198 of them are at most 0.198.
    let truth = grey(20, 10, |_, _| 1.0);
    let ours = grey(20, 10, |x, y| 1.0 + (y * 20 + x + 1) as f32 / 1000.0);
    close(run(&ours, &truth).metrics.p99, 0.198);
}

#[test]
fn blocks_need_eight_pixels() {
    // 9 columns: the second column of blocks is one pixel wide, and only 8 rows make it count.
    let truth = grey(9, 15, |_, _| 1.0);
    let ours = grey(9, 15, |x, _| if x < 8 { 1.0 } else { 1.4 });
    let m = run(&ours, &truth).metrics;
    // Upper right: 8 pixels. Lower right: 7 pixels, left out.
    assert_eq!(m.blocks, 3);
    close(m.block_error, 0.4 / 3.0);

    let tiny = run(&grey(2, 3, |_, _| 2.0), &grey(2, 3, |_, _| 1.0)).metrics;
    assert_eq!(tiny.blocks, 0);
    assert!(tiny.block_error.is_nan());
    close(tiny.mape, 1.0);
}

#[test]
fn the_mask_keeps_out_what_is_not_compared() {
    let truth = grey(16, 8, |_, _| 1.0);
    let truth = with(truth, "mask.A", |x, _| if x == 0 { 0.0 } else { 1.0 });
    let truth = with(truth, "blend.A", |x, _| if x <= 1 { 0.3 } else { 0.0 });
    let truth = with(truth, "firefly.A", |x, _| if x == 2 { 1.0 } else { 0.0 });
    let ours = grey(16, 8, |x, _| if x <= 2 { 1e6 } else { 1.0 });
    let report = run(&ours, &truth);
    let expected = MaskCounts {
        pixels: 128,
        valid: 104,
        missed: 8,
        blended: 8,
        fireflies: 8,
    };
    assert_eq!(report.mask, expected);
    close(report.metrics.rel_mse, 0.0);
    // Its filters reach across the mask's border, so this would see the bright columns.
    assert_eq!(report.metrics.flip, 0.0);
    assert_eq!(report.heat_map(0.5).get_pixel(1, 0).0, OUTSIDE_COLOR);
    assert_eq!(report.heat_map(0.5).get_pixel(3, 0).0, inferno(0.0));
}

#[test]
fn larger_pictures_are_averaged_down() {
    let truth = grey(8, 8, |x, y| 1.0 + (x + y) as f32);
    // The four pixels of a cell differ and have the truth's value as their mean.
    let ours = grey(16, 16, |x, y| {
        let spread = if x % 2 == y % 2 { 0.5 } else { -0.5 };
        1.0 + (x / 2 + y / 2) as f32 + spread
    });
    let report = run(&ours, &truth);
    assert_eq!(report.averaged, 2);
    close(report.metrics.rel_mse, 0.0);

    for (width, height) in [(8, 16), (12, 12), (4, 4), (9, 8), (0, 0)] {
        let error = compare(
            &grey(width, height, |_, _| 1.0),
            &truth,
            &CompareOptions::default(),
        );
        let error = error.unwrap_err();
        assert!(matches!(error, CompareError::Size { .. }), "{error}");
    }
}

#[test]
fn pictures_are_thinned_out_to_the_centres_of_the_truth() {
    let truth = grey(6, 4, |x, y| 1.0 + (x + 10 * y) as f32);
    // Right in the middle of each cell and nowhere else.
    let ours = grey(18, 12, |x, y| match (x % 3, y % 3) {
        (1, 1) => 1.0 + (x / 3 + 10 * (y / 3)) as f32,
        _ => 1000.0,
    });
    let options = CompareOptions {
        centers: true,
        ..CompareOptions::default()
    };
    let report = compare(&ours, &truth, &options).unwrap();
    close(report.metrics.rel_mse, 0.0);
    let even = compare(&grey(12, 8, |_, _| 1.0), &truth, &options).unwrap_err();
    assert!(
        matches!(even, CompareError::NoCenters { factor: 2 }),
        "{even}"
    );
}

#[test]
fn the_layer_is_chosen() {
    let mut truth = grey(8, 8, |_, _| 1.0);
    truth
        .set_rgb(FINAL_IMAGE, [2.0; 3].map(|v| vec![v; 64]))
        .unwrap();
    let mut ours = truth.clone();
    ours.set_rgb(FINAL_IMAGE, [3.0; 3].map(|v| vec![v; 64]))
        .unwrap();
    let options = CompareOptions {
        layer: FINAL_IMAGE.to_owned(),
        ..CompareOptions::default()
    };
    close(compare(&ours, &truth, &options).unwrap().metrics.bias, 0.5);
    close(run(&ours, &truth).metrics.bias, 0.0);
}

#[test]
fn brightness_as_a_whole_changes_no_metric() {
    let truth = grey(24, 16, |x, y| 0.05 + ((x * 7 + y * 5) % 11) as f32 * 0.1);
    let ours = grey(24, 16, |x, y| 0.06 + ((x * 7 + y * 5) % 13) as f32 * 0.1);
    let scaled = |picture: &Picture| {
        let mut picture = picture.clone();
        let values = picture.channels.values_mut().flatten();
        values.for_each(|v| *v *= 1024.0);
        picture
    };
    let plain = run(&ours, &truth).metrics;
    let bright = run(&scaled(&ours), &scaled(&truth)).metrics;
    // A power of two is exact in f32; m, and with it each quotient, is rounded in f64.
    for (a, b) in [
        (plain.rel_mse, bright.rel_mse),
        (plain.rmse, bright.rmse),
        (plain.mape, bright.mape),
        (plain.p99, bright.p99),
        (plain.block_error, bright.block_error),
        (plain.flip, bright.flip),
    ] {
        assert!((a - b).abs() <= 1e-9 * a, "{a} and {b}");
    }
}

#[test]
fn pictures_of_other_views_are_told_from_edges() {
    let truth = with(grey(10, 10, |_, _| 1.0), "depth.Z", |_, _| 1.0);
    // So many of a hundred pixels are elsewhere.
    for (count, doubted) in [(10, None), (11, Some([11, 100]))] {
        let ours = with(grey(10, 10, |_, _| 1.0), "depth.Z", |x, y| {
            if x + 10 * y < count { 2.0 } else { 1.0 }
        });
        let report = run(&ours, &truth);
        assert_eq!(report.elsewhere, Some(count as usize));
        assert_eq!(report.other_view(), doubted);
        let options = CompareOptions::default();
        let counts = elsewhere(&ours, &truth, &options);
        assert_eq!(counts, Some([count as usize, 100]));
        assert_eq!(counts.map(is_other_view), Some(doubted.is_some()));
        let text = report.to_string();
        assert!(
            text.contains(&format!("{count} of those compared show another surface")),
            "{text}"
        );
    }
    let unknown = run(&grey(10, 10, |_, _| 1.0), &truth);
    assert_eq!((unknown.elsewhere, unknown.other_view()), (None, None));
}

#[test]
fn reports_read_well() {
    let truth = grey(16, 16, |_, _| 2.0);
    let mut report = run(&grey(16, 16, |_, _| 3.0), &truth);
    report.noise = Some(report.metrics);
    let table = report.to_string();
    for part in [
        "channel E, 16x16: 256 of 256",
        "MAPE",
        "0.5000",
        "noise of truth",
    ] {
        assert!(table.contains(part), "{table}");
    }
    let json = serde_json::to_value(&report).unwrap();
    assert_eq!(json["metrics"]["mape"], 0.5);
    assert_eq!(json["non_finite"]["anywhere"], 0);

    let errors = report.error_picture().unwrap();
    assert_eq!(errors.scalar("error.Y").unwrap(), [0.5; 256]);
    assert_eq!(errors.scalar("mask.A").unwrap(), [1.0; 256]);
}
