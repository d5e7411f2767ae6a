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
    let mean = mean_of(half_a, half_b, layer)?;
    let pair = Pair::new(half_a, &mean, truth, layer, false)?;
    Ok(compare_pair(pair, options)?.metrics)
}

/// What makes two pictures doubtful as the halves of a truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HalvesDoubt {
    /// They are the same, so that they tell of no noise.
    Alike,
    /// Their mean is another picture than the truth: its relMSE against it.
    OfAnother {
        /// As in [`Metrics`].
        rel_mse: f64,
    },
}

/// relMSE that storing a truth and its halves in half precision may leave between their mean and the truth, an order of
/// magnitude above: values are off by up to 2^-11, three of them in quadrature.
const ROUNDING: f64 = 1e-6;

/// Whether halves are doubtful, given the `noise` that [`noise_floor`] found of them: a truth that is their mean differs from it by
/// rounding alone, of which more than a hundredth of the noise's relMSE, a tenth in size, would spoil it. `None` also where the mean
/// cannot be compared with the truth.
pub fn halves_doubt(
    half_a: &Picture,
    half_b: &Picture,
    truth: &Picture,
    noise: &Metrics,
    options: &CompareOptions,
) -> Option<HalvesDoubt> {
    if noise.rel_mse == 0.0 {
        return Some(HalvesDoubt::Alike);
    }
    let mean = mean_of(half_a, half_b, &options.layer).ok()?;
    let pair = Pair::new(&mean, truth, truth, &options.layer, false).ok()?;
    let rel_mse = compare_pair(pair, options).ok()?.metrics.rel_mse;
    (rel_mse > ROUNDING.max(0.01 * noise.rel_mse)).then_some(HalvesDoubt::OfAnother { rel_mse })
}

/// A picture with the mean of a layer of two of one size.
fn mean_of(half_a: &Picture, half_b: &Picture, layer: &str) -> Result<Picture, CompareError> {
    let [a, b] = [half_a, half_b].map(|half| half.rgb(layer).map_err(CompareError::Truth));
    let (a, b) = (a?, b?);
    let mut mean = Picture::new(half_a.width, half_a.height);
    let planes = [0, 1, 2].map(|c| {
        let pairs = a[c].iter().zip(b[c]);
        // Halved first: the sum of two large values may not be finite.
        pairs.map(|(a, b)| 0.5 * a + 0.5 * b).collect()
    });
    mean.set_rgb(layer, planes).map_err(CompareError::Truth)?;
    Ok(mean)
}
