//! Values that are no numbers, and truths that cannot judge.
use super::*;

#[test]
fn values_that_are_not_finite_fail_the_comparison() {
    let truth = with(grey(16, 16, |_, _| 1.0), "mask.A", |x, _| f32::from(x > 0));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let ours = grey(16, 16, |x, y| if (x, y) == (5, 3) { bad } else { 1.5 });
        let report = run(&ours, &truth);
        assert!(!report.passed());
        assert_eq!(report.non_finite.in_mask, 1);
        assert_eq!(report.non_finite.first, Some([5, 3]));
        let m = report.metrics;
        for value in all(&m) {
            assert!(value.is_nan());
        }
        let rest = report.finite_only.unwrap();
        close(rest.mape, 0.5);
        assert!(rest.flip.is_finite());
        assert_eq!(report.heat_map(0.5).get_pixel(5, 3).0, NON_FINITE_COLOR);
        assert!(report.to_string().contains("NOT FINITE: 1"), "{report}");

        // Outside the mask it spoils no number, and is a fault nevertheless.
        let outside = grey(16, 16, |x, y| if (x, y) == (0, 2) { bad } else { 1.5 });
        let report = run(&outside, &truth);
        assert!(!report.passed());
        assert_eq!(
            (report.non_finite.anywhere, report.non_finite.in_mask),
            (1, 0)
        );
        close(report.metrics.mape, 0.5);
    }
}

#[test]
fn one_bad_pixel_of_a_cell_is_found_at_its_own_place() {
    let truth = grey(8, 8, |_, _| 1.0);
    let ours = grey(16, 16, |x, y| if (x, y) == (7, 2) { f32::NAN } else { 1.0 });
    let report = run(&ours, &truth);
    assert_eq!(report.non_finite.first, Some([7, 2]));
    assert!(report.metrics.rel_mse.is_nan());
    // Its cell is left out of the rest: 63 of 64 pixels, none with an error.
    close(report.finite_only.unwrap().rmse, 0.0);
}

#[test]
fn all_pixels_bad_is_still_a_report() {
    let report = run(&grey(8, 8, |_, _| f32::NAN), &grey(8, 8, |_, _| 1.0));
    assert_eq!(report.non_finite.in_mask, 64);
    assert!(report.finite_only.unwrap().p99.is_nan());
}

#[test]
fn truths_that_cannot_judge_are_refused() {
    let ours = grey(8, 8, |_, _| 1.0);
    let fails =
        |truth: Picture, options: &CompareOptions| compare(&ours, &truth, options).unwrap_err();
    let options = CompareOptions::default();

    let black = fails(grey(8, 8, |_, _| 0.0), &options);
    assert!(matches!(black, CompareError::BlackTruth { .. }), "{black}");
    let nan = grey(8, 8, |x, y| if (x, y) == (3, 4) { f32::NAN } else { 1.0 });
    let spoiled = fails(nan.clone(), &options);
    assert!(
        matches!(
            spoiled,
            CompareError::TruthNotFinite {
                count: 1,
                x: 3,
                y: 4
            }
        ),
        "{spoiled}"
    );
    let empty = fails(with(grey(8, 8, |_, _| 1.0), "mask.A", |_, _| 0.0), &options);
    assert!(
        matches!(empty, CompareError::EmptyMask { missed: 64, .. }),
        "{empty}"
    );
    let missing = fails(Picture::new(8, 8), &options);
    assert!(matches!(missing, CompareError::Truth(_)), "{missing}");
    for exposure in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = CompareOptions {
            exposure: Some(exposure),
            ..CompareOptions::default()
        };
        let error = fails(grey(8, 8, |_, _| 1.0), &options);
        assert!(matches!(error, CompareError::Exposure { .. }), "{error}");
    }

    // Masked out, the NaN of a truth does no harm.
    let masked = with(nan, "firefly.A", |x, y| f32::from((x, y) == (3, 4)));
    assert_eq!(run(&ours, &masked).metrics.flip, 0.0);
}
