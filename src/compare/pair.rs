//! Two pictures brought to one size, with the mask over which they are compared.
use crate::picture::{Picture, luminance};

use super::error::CompareError;
use super::report::NonFinite;
use super::surfaces::elsewhere;

/// How many of the truth's pixels count, and why the others do not (the first reason that holds).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct MaskCounts {
    /// Pixels of the truth.
    pub pixels: usize,
    /// Pixels that are compared.
    pub valid: usize,
    /// Pixels without `mask.A` = 1.
    pub missed: usize,
    /// Pixels with a `blend.A` other than 0.
    pub blended: usize,
    /// Pixels with a `firefly.A` other than 0.
    pub fireflies: usize,
}

/// Planes of `width * height` values at the truth's size.
pub(super) struct Pair {
    pub width: usize,
    pub height: usize,
    /// Our pixels in a row for each one of the truth's.
    pub factor: usize,
    pub ours: [Vec<f32>; 3],
    pub truth: [Vec<f32>; 3],
    /// Whether the pixel is compared. The truth is finite wherever this holds.
    pub mask: Vec<bool>,
    pub counts: MaskCounts,
    /// How many of them show another surface in ours, where both tell depths.
    pub elsewhere: Option<usize>,
    pub non_finite: NonFinite,
}

impl Pair {
    /// Brings one layer of two pictures together, with the mask that `masks` carries (of the
    /// truth's size).
    pub fn new(
        ours: &Picture,
        truth: &Picture,
        masks: &Picture,
        layer: &str,
        centers: bool,
    ) -> Result<Self, CompareError> {
        let truth_rgb = truth.rgb(layer).map_err(CompareError::Truth)?;
        let ours_rgb = ours.rgb(layer).map_err(CompareError::Ours)?;
        let factor = size_factor(ours, truth)?;
        if centers && factor % 2 == 0 {
            return Err(CompareError::NoCenters { factor });
        }
        if (masks.width, masks.height) != (truth.width, truth.height) {
            return Err(size_error(truth, masks));
        }
        let (mask, counts) = mask(masks)?;
        let (width, height) = (truth.width as usize, truth.height as usize);
        if let Some((count, first)) = not_finite(truth_rgb, |i| mask[i]) {
            return Err(CompareError::TruthNotFinite {
                count,
                x: first % width,
                y: first / width,
            });
        }
        let ours_width = ours.width as usize;
        let cell = |i: usize| (i / ours_width / factor) * width + i % ours_width / factor;
        let at = |i: usize| [(i % ours_width) as u32, (i / ours_width) as u32];
        let anywhere = not_finite(ours_rgb, |_| true);
        let in_mask = not_finite(ours_rgb, |i| mask[cell(i)]);
        let elsewhere = elsewhere(ours, truth, factor, &mask)?;
        Ok(Self {
            width,
            height,
            factor,
            elsewhere,
            ours: ours_rgb.map(|plane| match centers {
                true => middles(plane, width, factor),
                false => average_down(plane, width, height, factor),
            }),
            truth: truth_rgb.map(<[f32]>::to_vec),
            mask,
            counts,
            non_finite: NonFinite {
                anywhere: anywhere.map_or(0, |(count, _)| count),
                in_mask: in_mask.map_or(0, |(count, _)| count),
                first: in_mask.or(anywhere).map(|(_, i)| at(i)),
            },
        })
    }

    /// Our colour at pixel `i`.
    pub fn ours_at(&self, i: usize) -> [f32; 3] {
        std::array::from_fn(|c| self.ours[c][i])
    }

    /// The truth's colour at pixel `i`.
    pub fn truth_at(&self, i: usize) -> [f32; 3] {
        std::array::from_fn(|c| self.truth[c][i])
    }

    /// m: the truth's mean luminance over the mask.
    pub fn mean_truth(&self) -> Result<f64, CompareError> {
        let indices = (0..self.mask.len()).filter(|&i| self.mask[i]);
        let sum: f64 = indices.map(|i| luminance(self.truth_at(i))).sum();
        let mean = sum / self.counts.valid as f64;
        if mean > 0.0 {
            Ok(mean)
        } else {
            Err(CompareError::BlackTruth { mean })
        }
    }
}

/// The whole factor by which ours is larger than the truth, the same in both directions.
fn size_factor(ours: &Picture, truth: &Picture) -> Result<usize, CompareError> {
    let factor = ours.width.checked_div(truth.width).unwrap_or(0);
    let fits = |truth: u32, ours: u32| truth.checked_mul(factor) == Some(ours);
    if factor > 0 && fits(truth.width, ours.width) && fits(truth.height, ours.height) {
        Ok(factor as usize)
    } else {
        Err(size_error(ours, truth))
    }
}

fn size_error(ours: &Picture, truth: &Picture) -> CompareError {
    CompareError::Size {
        ours_width: ours.width,
        ours_height: ours.height,
        truth_width: truth.width,
        truth_height: truth.height,
    }
}

fn mask(picture: &Picture) -> Result<(Vec<bool>, MaskCounts), CompareError> {
    let optional = |name| {
        let channel = picture.has(name).then(|| picture.scalar(name));
        channel.transpose().map_err(CompareError::Truth)
    };
    let (hit, blend, firefly) = (
        optional("mask.A")?,
        optional("blend.A")?,
        optional("firefly.A")?,
    );
    // Written so that a NaN excludes the pixel.
    let is = |channel: Option<&[f32]>, i: usize, wanted| channel.is_none_or(|c| c[i] == wanted);
    let mut counts = MaskCounts {
        pixels: picture.pixels(),
        ..MaskCounts::default()
    };
    let mask = (0..counts.pixels)
        .map(|i| {
            let reason = if !is(hit, i, 1.0) {
                &mut counts.missed
            } else if !is(blend, i, 0.0) {
                &mut counts.blended
            } else if !is(firefly, i, 0.0) {
                &mut counts.fireflies
            } else {
                counts.valid += 1;
                return true;
            };
            *reason += 1;
            false
        })
        .collect();
    if counts.valid == 0 {
        return Err(CompareError::EmptyMask {
            pixels: counts.pixels,
            missed: counts.missed,
            blended: counts.blended,
            fireflies: counts.fireflies,
        });
    }
    Ok((mask, counts))
}

/// How many pixels for which `counts` holds have a value that is not finite, and the first one.
fn not_finite(rgb: [&[f32]; 3], counts: impl Fn(usize) -> bool) -> Option<(usize, usize)> {
    let mut bad = (0..rgb[0].len())
        .filter(|&i| !rgb.iter().all(|plane| plane[i].is_finite()))
        .filter(|&i| counts(i));
    let first = bad.next()?;
    Some((1 + bad.count(), first))
}

/// The middle pixels of cells of `factor` x `factor`, which is odd; the result has `width` of them in a row.
fn middles(plane: &[f32], width: usize, factor: usize) -> Vec<f32> {
    let rows = plane.chunks_exact(width * factor);
    let middle = factor / 2;
    rows.skip(middle)
        .step_by(factor)
        .flat_map(|row| row.iter().skip(middle).step_by(factor).copied())
        .collect()
}

/// Means over cells of `factor` x `factor` pixels; the result has `width` x `height` of them.
fn average_down(plane: &[f32], width: usize, height: usize, factor: usize) -> Vec<f32> {
    if factor == 1 {
        return plane.to_vec();
    }
    let mut means = Vec::with_capacity(width * height);
    let mut sums = vec![0.0_f64; width];
    for rows in plane.chunks_exact(width * factor * factor) {
        sums.fill(0.0);
        for row in rows.chunks_exact(width * factor) {
            for (sum, cell) in sums.iter_mut().zip(row.chunks_exact(factor)) {
                *sum += cell.iter().copied().map(f64::from).sum::<f64>();
            }
        }
        means.extend(
            sums.iter()
                .map(|sum| (sum / (factor * factor) as f64) as f32),
        );
    }
    means
}
