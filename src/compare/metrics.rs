//! The error metrics.
use crate::picture::luminance;

use super::flip::{PIXELS_PER_DEGREE, flip};
use super::pair::Pair;
use super::report::Maps;

/// Relative errors divide by at least this share of the truth's mean, so that black pixels do not
/// dominate.
pub const TRUTH_FLOOR: f64 = 0.01;

/// The side of a block in pixels. Blocks start at the top left; those at the right and lower edge
/// may be cut.
pub const BLOCK: usize = 8;

/// Blocks with fewer pixels in the mask are left out of the block error.
pub const BLOCK_MIN_PIXELS: usize = 8;

/// Errors over the mask, all without unit: o is ours and t the truth, both as luminance (weights
/// 0.2126, 0.7152, 0.0722) where nothing else is said; m is the mean of t.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Metrics {
    /// Mean over pixels and over R, G and B of (o - t)^2 / (t^2 + (0.01 m)^2), where o and t are
    /// the colour component.
    pub rel_mse: f64,
    /// sqrt(mean (o - t)^2) / m.
    pub rmse: f64,
    /// Mean of |o - t| / max(t, 0.01 m).
    pub mape: f64,
    /// mean(o - t) / m; positive where ours is brighter.
    pub bias: f64,
    /// The 99th percentile of |o - t| / max(t, 0.01 m): the smallest value that at least 99 of 100
    /// pixels do not exceed.
    pub p99: f64,
    /// MAPE of the means over blocks of 8x8 pixels that have at least 8 in the mask, every block
    /// counting alike; NaN where there is none.
    pub block_error: f64,
    /// Blocks that count.
    pub blocks: usize,
    /// Mean of the FLIP difference, 0 to 1, after the exposure; see [`flip`].
    pub flip: f64,
}

impl Metrics {
    /// No number where a value that is not finite spoils all.
    pub(super) const UNDEFINED: Self = Self {
        rel_mse: f64::NAN,
        rmse: f64::NAN,
        mape: f64::NAN,
        bias: f64::NAN,
        p99: f64::NAN,
        block_error: f64::NAN,
        blocks: 0,
        flip: f64::NAN,
    };
}

/// All metrics over the pixels of the mask where ours is finite (all of them, in a sound picture),
/// and the errors per pixel.
pub(super) fn measure(pair: &Pair, mean: f64, exposure: f64) -> (Metrics, Maps) {
    let floor = TRUTH_FLOOR * mean;
    let finite = |i: usize| pair.ours_at(i).iter().all(|v| v.is_finite());
    let counted: Vec<bool> = (0..pair.mask.len())
        .map(|i| pair.mask[i] && finite(i))
        .collect();
    let flip_map = masked_flip(pair, &counted, exposure);

    let mut blocks = Blocks::new(pair.width, pair.height);
    let mut sums = Sums::default();
    let mut magnitudes = Vec::with_capacity(pair.counts.valid);
    let mut relative = vec![f32::NAN; pair.mask.len()];
    for i in (0..counted.len()).filter(|&i| counted[i]) {
        let (ours, truth) = (pair.ours_at(i), pair.truth_at(i));
        for (o, t) in ours.iter().zip(truth) {
            let (o, t) = (f64::from(*o), f64::from(t));
            sums.relative_squares += (o - t).powi(2) / (t * t + floor * floor);
        }
        let (o, t) = (luminance(ours), luminance(truth));
        let error = (o - t) / t.max(floor);
        sums.squares += (o - t).powi(2);
        sums.differences += o - t;
        sums.flip += f64::from(flip_map[i]);
        magnitudes.push(error.abs());
        relative[i] = error as f32;
        blocks.add(i, o, t);
    }

    let count = magnitudes.len() as f64;
    let (block_error, block_count) = blocks.error(floor);
    let metrics = Metrics {
        rel_mse: sums.relative_squares / (3.0 * count),
        rmse: (sums.squares / count).sqrt() / mean,
        mape: magnitudes.iter().sum::<f64>() / count,
        bias: sums.differences / count / mean,
        p99: percentile(&mut magnitudes, 0.99),
        block_error,
        blocks: block_count,
        flip: sums.flip / count,
    };
    let maps = Maps {
        relative,
        flip: flip_map,
        mask: pair.mask.clone(),
    };
    (metrics, maps)
}

#[derive(Default)]
struct Sums {
    relative_squares: f64,
    squares: f64,
    differences: f64,
    flip: f64,
}

/// FLIP after the exposure. What is not counted takes the truth's value in both pictures, so that
/// the filters, which reach about ten pixels far, carry nothing from there into the mask.
fn masked_flip(pair: &Pair, counted: &[bool], exposure: f64) -> Vec<f32> {
    let display = |value: f32| {
        let exposed = f64::from(value) * exposure;
        // A background that is not finite is black: both pictures have it.
        if exposed.is_nan() {
            0.0
        } else {
            exposed.clamp(0.0, 1.0) as f32
        }
    };
    let truth = [0, 1, 2].map(|c| {
        pair.truth[c]
            .iter()
            .copied()
            .map(display)
            .collect::<Vec<_>>()
    });
    let ours = [0, 1, 2].map(|c| {
        let pixels = pair.ours[c].iter().zip(&truth[c]).zip(counted);
        pixels
            .map(|((&o, &t), &counts)| if counts { display(o) } else { t })
            .collect::<Vec<_>>()
    });
    let [truth, ours] = [&truth, &ours].map(|image| image.each_ref().map(Vec::as_slice));
    flip(truth, ours, pair.width, PIXELS_PER_DEGREE)
}

/// The smallest of `values` that at least `share` of them do not exceed (nearest rank); NaN if
/// there are none. Reorders the values.
fn percentile(values: &mut [f64], share: f64) -> f64 {
    let rank = (share * values.len() as f64).ceil() as usize;
    match rank.checked_sub(1) {
        Some(index) => *values.select_nth_unstable_by(index, f64::total_cmp).1,
        None => f64::NAN,
    }
}

/// Sums of ours, of the truth and of pixels per block.
struct Blocks {
    width: usize,
    columns: usize,
    sums: Vec<(f64, f64, usize)>,
}

impl Blocks {
    fn new(width: usize, height: usize) -> Self {
        let columns = width.div_ceil(BLOCK);
        Self {
            width,
            columns,
            sums: vec![(0.0, 0.0, 0); columns * height.div_ceil(BLOCK)],
        }
    }

    fn add(&mut self, pixel: usize, ours: f64, truth: f64) {
        let (x, y) = (pixel % self.width, pixel / self.width);
        let block = &mut self.sums[y / BLOCK * self.columns + x / BLOCK];
        block.0 += ours;
        block.1 += truth;
        block.2 += 1;
    }

    /// The mean relative error of block means and the number of blocks that count.
    fn error(&self, floor: f64) -> (f64, usize) {
        let full = self.sums.iter().filter(|block| block.2 >= BLOCK_MIN_PIXELS);
        let (sum, count) = full.fold((0.0, 0), |(sum, count), &(ours, truth, pixels)| {
            let [o, t] = [ours, truth].map(|sum| sum / pixels as f64);
            (sum + (o - t).abs() / t.max(floor), count + 1)
        });
        (sum / count as f64, count)
    }
}
