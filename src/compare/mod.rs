//! How far a picture is from the truth.
//!
//! Every number is over the truth's mask: pixels that hit a surface (`mask.A` = 1), with nothing
//! blended in front (`blend.A` = 0) and no firefly in the truth (`firefly.A` = 0); a channel that
//! is absent excludes nothing. See [`Metrics`] for the formulas.

mod error;
mod flip;
mod metrics;
mod noise;
mod pair;
mod report;
mod surfaces;
#[cfg(test)]
mod tests;

use crate::picture::Picture;

pub use error::CompareError;
pub use flip::{PIXELS_PER_DEGREE, flip};
pub use metrics::{BLOCK, BLOCK_MIN_PIXELS, Metrics, TRUTH_FLOOR};
pub use noise::{HalvesDoubt, halves_doubt, noise_floor};
pub use pair::MaskCounts;
pub use report::{HEAT_FULL_SCALE, Maps, NonFinite, Report};

use metrics::measure;
use pair::Pair;

/// The luminance that the truth's mean is exposed to where no exposure is asked for: the
/// reflectance of a photographer's grey card.
pub const MIDDLE_GREY: f64 = 0.18;

/// What to compare, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct CompareOptions {
    /// The layer whose `R`, `G` and `B` are compared: `E`, `indirect`, or
    /// [`FINAL_IMAGE`](crate::picture::FINAL_IMAGE).
    pub layer: String,
    /// The factor on both pictures before FLIP. `None` brings the mean luminance of the truth over
    /// the mask to [`MIDDLE_GREY`]; it depends on the truth alone, so that whatever is compared
    /// with one truth is exposed alike.
    pub exposure: Option<f64>,
    /// Of a picture that is an odd multiple of the truth's size, takes the pixels whose centres are the truth's, in place
    /// of means. A truth of every fifth pixel costs a twenty-fifth.
    pub centers: bool,
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self {
            layer: "E".to_owned(),
            exposure: None,
            centers: false,
        }
    }
}

/// Compares `ours` with `truth`. An image that is an integer multiple of the truth's size is
/// averaged down first, all pixels of a cell alike, or with [`CompareOptions::centers`] thinned out.
///
/// A value in ours that is NaN or infinite does not vanish: [`Report::non_finite`] counts it,
/// [`Report::passed`] is false, and if it lies inside the mask [`Report::metrics`] is NaN
/// throughout, while [`Report::finite_only`] tells what the other pixels show.
///
/// # Errors
/// [`CompareError`] for a missing layer, sizes that do not fit, an empty mask, an exposure that is
/// no positive number, and a truth that is black or not finite within its mask.
pub fn compare(
    ours: &Picture,
    truth: &Picture,
    options: &CompareOptions,
) -> Result<Report, CompareError> {
    let pair = Pair::new(ours, truth, truth, &options.layer, options.centers)?;
    compare_pair(pair, options)
}

/// How many pixels of `ours` show another surface than the truth's, and of how many that are compared. `None` where that cannot be told:
/// without depths, or where the two cannot be compared at all.
pub fn elsewhere(ours: &Picture, truth: &Picture, options: &CompareOptions) -> Option<[usize; 2]> {
    let pair = Pair::new(ours, truth, truth, &options.layer, options.centers).ok()?;
    Some([pair.elsewhere?, pair.counts.valid])
}

/// Whether so many pixels that show another surface, of so many, are more than a tenth: then the pictures are not of one scene and view.
pub fn is_other_view([elsewhere, of]: [usize; 2]) -> bool {
    elsewhere as f64 > surfaces::OTHER_VIEW * of as f64
}

/// The two numbers, if the first is a large part of the second.
fn many(elsewhere: usize, of: usize) -> Option<[usize; 2]> {
    Some([elsewhere, of]).filter(|counts| is_other_view(*counts))
}

fn compare_pair(pair: Pair, options: &CompareOptions) -> Result<Report, CompareError> {
    let mean = pair.mean_truth()?;
    let exposure = options.exposure.unwrap_or(MIDDLE_GREY / mean);
    if !(exposure.is_finite() && exposure > 0.0) {
        return Err(CompareError::Exposure { exposure });
    }
    let (measured, maps) = measure(&pair, mean, exposure);
    let spoiled = pair.non_finite.in_mask > 0;
    Ok(Report {
        layer: options.layer.clone(),
        width: pair.width as u32,
        height: pair.height as u32,
        averaged: pair.factor as u32,
        centers: options.centers,
        mask: pair.counts,
        elsewhere: pair.elsewhere,
        mean,
        exposure,
        metrics: if spoiled {
            Metrics::UNDEFINED
        } else {
            measured
        },
        finite_only: spoiled.then_some(measured),
        non_finite: pair.non_finite,
        noise: None,
        maps,
    })
}
