//! How small an error a noisy truth can show.
use crate::picture::Picture;

use super::error::CompareError;
use super::metrics::Metrics;
use super::pair::Pair;
use super::{CompareOptions, compare_pair};

/// The errors that a *perfect* picture would show against a truth that is the mean of two halves.
///
/// Let a and b be the halves: independent, unbiased, each with half of the samples. The truth is
/// t = (a + b) / 2. With s^2 the variance of t (at a pixel, or of a block's mean), a and b have the
/// variance 2 s^2 each, so a - b has 4 s^2, and
///
/// > (a - b) / 2 has mean 0 and variance s^2,
///
/// which is how t itself is spread about the true value. Every metric of |a - b| / 2 against t
/// therefore estimates what a picture without any error would get; as (a - b) / 2 = a - t, that is
/// the comparison of the half a with the mean t. The block error so found is the mean over blocks
/// of |A - B| / 2 / max(T, 0.01 m) with capital letters for means over the block.
///
/// Squares add: a measured `rel_mse` minus this one estimates the picture's own `rel_mse`, and
/// likewise `rmse` squared. Absolute errors (`mape`, `block_error`) do not add, but none is likely
/// to fall below. A second picture with noise of the same size would show sqrt(2) times these
/// values. `bias` is the difference of the halves, a chance value near 0. FLIP is not linear, so
/// its value is a guide only.
///
/// `truth` gives the mask, and nothing else.
///
/// # Errors
/// As [`compare`](super::compare), and [`CompareError::Size`] where the halves or the mask differ
/// in size; a half that is not finite within the mask counts as a truth that is not.
pub fn noise_floor(
    half_a: &Picture,
    half_b: &Picture,
    truth: &Picture,
    options: &CompareOptions,
) -> Result<Metrics, CompareError> {
    let layer = &options.layer;
    if (half_a.width, half_a.height) != (half_b.width, half_b.height) {
        return Err(CompareError::Size {
            ours_width: half_a.width,
            ours_height: half_a.height,
            truth_width: half_b.width,
            truth_height: half_b.height,
        });
    }
    let [a, b] = [half_a, half_b].map(|half| half.rgb(layer).map_err(CompareError::Truth));
    let (a, b) = (a?, b?);
    let mut mean = Picture::new(half_a.width, half_a.height);
    let planes = [0, 1, 2].map(|c| {
        let pairs = a[c].iter().zip(b[c]);
        // Halved first: the sum of two large values may not be finite.
        pairs.map(|(a, b)| 0.5 * a + 0.5 * b).collect()
    });
    mean.set_rgb(layer, planes).map_err(CompareError::Truth)?;
    let pair = Pair::new(half_a, &mean, truth, layer, false)?;
    Ok(compare_pair(pair, options)?.metrics)
}
