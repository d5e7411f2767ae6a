//! When the light of a run has converged.
use crate::compare::{BLOCK, BLOCK_MIN_PIXELS, TRUTH_FLOOR};
use crate::picture::luminance;
use gibs_passes::data::SurfacePoint;
use gibs_passes::shared::surface;
use glam::Vec4;

/// Mean luminance of indirect irradiance over the surfaces of each block of [`BLOCK`] x [`BLOCK`] pixels, W/m^2.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockMeans(Vec<Option<f64>>);

impl BlockMeans {
    /// Of the outputs `points` and `irradiance` of a frame. Blocks with fewer surfaces than [`BLOCK_MIN_PIXELS`] have
    /// none.
    pub fn of(points: &[SurfacePoint], irradiance: &[Vec4], width: usize) -> Self {
        let width = width.clamp(1, points.len().max(1));
        let across = width.div_ceil(BLOCK);
        let down = points.len().div_ceil(width).div_ceil(BLOCK);
        let mut sums = vec![(0.0, 0_usize); across * down];
        for (i, (point, e)) in points.iter().zip(irradiance).enumerate() {
            if surface::is_surface(point) {
                let (sum, count) = &mut sums[i / width / BLOCK * across + i % width / BLOCK];
                *sum += luminance(e.truncate().to_array());
                *count += 1;
            }
        }
        let mean =
            |(sum, count): (f64, usize)| (count >= BLOCK_MIN_PIXELS).then(|| sum / count as f64);
        Self(sums.into_iter().map(mean).collect())
    }

    /// The block error of [`Metrics`](crate::compare::Metrics) against other means of the same view: the mean of
    /// |o - t| / max(t, 0.01 m) over the blocks, m the mean of t. `None` where there is no block or no light.
    pub fn error(&self, truth: &Self) -> Option<f64> {
        let pairs = || {
            self.0
                .iter()
                .zip(&truth.0)
                .filter_map(|(o, t)| Some((((*o)?), (*t)?)))
        };
        let count = pairs().count() as f64;
        let mean = pairs().map(|(_, t)| t).sum::<f64>() / count;
        let floor = TRUTH_FLOOR * mean;
        let sum: f64 = pairs().map(|(o, t)| (o - t).abs() / t.max(floor)).sum();
        (mean > 0.0).then_some(sum / count)
    }
}

/// The first frame from which on every error stays below `limit`; `None` where that is not so for the last quarter of them,
/// since a few frames alone say little.
pub fn converged_from(
    errors: impl DoubleEndedIterator<Item = Option<f64>> + ExactSizeIterator,
    limit: f64,
) -> Option<usize> {
    let all = errors.len();
    let good = errors
        .rev()
        .take_while(|error| error.is_some_and(|e| e < limit))
        .count();
    (good > 0 && 4 * good >= all).then_some(all - good)
}
