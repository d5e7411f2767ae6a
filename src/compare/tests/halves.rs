//! The noise of a truth, from its halves.
use super::*;

/// Uniform noise in -0.5..0.5 from an integer hash (lowbias32).
fn noise(index: u32) -> f32 {
    let mut h = index.wrapping_add(0x9e37_79b9);
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    ((h ^ (h >> 16)) as f32 / u32::MAX as f32) - 0.5
}

#[test]
fn halves_tell_the_error_of_their_mean() {
    let (width, height) = (256, 256);
    let perfect = grey(width, height, |_, _| 1.0);
    let half = |seed: u32| grey(width, height, move |x, y| 1.0 + noise(seed + y * width + x));
    let (a, b) = (half(0), half(1 << 20));
    let mean = grey(width, height, |x, y| {
        let i = y * width + x;
        1.0 + 0.5 * (noise(i) + noise((1 << 20) + i))
    });
    let options = CompareOptions::default();
    let floor = noise_floor(&a, &b, &mean, &options).unwrap();
    let actual = run(&perfect, &mean).metrics;
    // Both are means of absolute values over 1024 independent blocks; of a Gaussian's absolute
    // value the deviation is 0.76 of the mean, so each mean is good to 2.4 % and their quotient to
    // 3.3 %. Four deviations.
    let quotient = actual.block_error / floor.block_error;
    assert!((quotient - 1.0).abs() < 0.13, "{quotient}");
    // The variance of the mean of two values uniform over a width of 1 is 1/24; over 65536 pixels
    // its estimate is good to 0.4 %.
    for rmse in [actual.rmse, floor.rmse] {
        assert!((rmse * rmse * 24.0 - 1.0).abs() < 0.016, "{rmse}");
    }
}

#[test]
fn the_noise_of_halves_in_closed_form() {
    // a = 1.2, b = 0.8 in even blocks and the reverse in odd ones: |A - B| / 2 = 0.2 throughout.
    let sign = |x: u32| if (x / 8).is_multiple_of(2) { 0.2 } else { -0.2 };
    let a = grey(32, 8, |x, _| 1.0 + sign(x));
    let b = grey(32, 8, |x, _| 1.0 - sign(x));
    let truth = grey(32, 8, |_, _| 1.0);
    let floor = noise_floor(&a, &b, &truth, &CompareOptions::default()).unwrap();
    close(floor.block_error, 0.2);
    close(floor.mape, 0.2);
    close(floor.bias, 0.0);

    let other = grey(16, 8, |_, _| 1.0);
    for error in [
        noise_floor(&a, &other, &truth, &CompareOptions::default()).unwrap_err(),
        noise_floor(&a, &b, &other, &CompareOptions::default()).unwrap_err(),
    ] {
        assert!(matches!(error, CompareError::Size { .. }), "{error}");
    }
}

#[test]
fn halves_are_those_of_the_truth_or_doubted() {
    let half = |sign: f32| grey(32, 8, move |x, y| 1.0 + sign * 0.02 * noise(x + 32 * y));
    let (a, b) = (half(1.0), half(-1.0));
    // Stored in half precision, of which values from 1 to 2 have 1024.
    let rounded = grey(32, 8, |x, y| {
        let exact = 1.0 + 1e-3 * noise(x * 7 + y);
        (exact * 1024.0).round() / 1024.0
    });
    let options = CompareOptions::default();
    let doubt = |a: &Picture, b: &Picture, truth: &Picture| {
        let noise = noise_floor(a, b, truth, &options).unwrap();
        halves_doubt(a, b, truth, &noise, &options)
    };
    assert_eq!(doubt(&a, &b, &grey(32, 8, |_, _| 1.0)), None);
    assert_eq!(doubt(&a, &b, &rounded), None);
    // A quiet truth's halves differ by little more than rounding.
    let quiet = |sign: f32| grey(32, 8, move |x, _| 1.0 + sign * 1e-4 * noise(x));
    assert_eq!(
        doubt(&quiet(1.0), &quiet(-1.0), &grey(32, 8, |_, _| 1.0004)),
        None
    );
    let other = doubt(&a, &b, &grey(32, 8, |_, _| 1.01));
    let Some(HalvesDoubt::OfAnother { rel_mse }) = other else {
        panic!("{other:?}");
    };
    // (0.01 / 1.01)^2, with a ten-thousandth in the denominator.
    assert!((rel_mse / 9.802e-5 - 1.0).abs() < 1e-3, "{rel_mse}");
    assert_eq!(doubt(&a, &a, &a), Some(HalvesDoubt::Alike));
}
