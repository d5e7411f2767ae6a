//! Irradiance shared between neighbouring surfels (GIBS, "Irradiance Sharing").
//!
//! The mean of the neighbours is a guess of a surfel's own irradiance that has less noise, and another error: the
//! irradiance is not the same there. Both are measured, and the guess counts by the inverse of its variance, as in
//! empirical Bayes estimation (Efron and Morris 1975, "Data Analysis Using Stein's Estimator and its Generalizations"). So
//! sharing fades out as a surfel learns, and never crosses an edge that stands out of the noise. What is shared goes
//! into what a surfel says, not into its own mean: a guess is not passed on as knowledge.
use super::estimator::luminance;
use super::lookup;
use crate::data::{Neighbours, SurfelIrradiance, SurfelLight};
use glam::Vec3;

/// Reach of a neighbour, in radii: as far as depth functions know what stands between.
pub const REACH: f32 = 2.0;

/// Neighbours count by their rays, up to so many.
pub const MOST_RAYS: f32 = 4096.0;

/// Standard deviation of irradiance between neighbours, relative, that is assumed even where none shows: below this,
/// a surfel's own noise is left alone.
pub const LEAST_SPREAD: f32 = 0.03;

/// Relative standard error of its mean below which a surfel does not ask its neighbours.
pub const CERTAIN: f32 = 0.015;

/// Rays before which no standard error is believed: what is rare may not have come yet.
pub const UNCERTAIN_BEFORE: u32 = 256;

/// Variance of the luminance of a surfel's long mean, W^2/m^4.
#[inline]
pub fn mean_variance(state: &SurfelIrradiance) -> f32 {
    state.variance / state.samples.max(1) as f32
}

/// Whether a surfel is uncertain enough to ask its neighbours.
#[inline]
pub fn asks(state: &SurfelIrradiance) -> bool {
    let level = luminance(state.mean);
    state.samples < UNCERTAIN_BEFORE || mean_variance(state) > CERTAIN * CERTAIN * level * level
}

/// Sums over the neighbours of a surfel, itself among them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Asked {
    mean: Vec3,
    sum: f32,
    squares: f32,
    weights_squared: f32,
    noise: f32,
    trust: f32,
    ray_variance: f32,
    ray_sum: f32,
}

impl Asked {
    /// Takes in a surfel that has integrated rays, with its weight and its age in frames. `is_own` for the one that asks.
    #[inline]
    pub fn add(&mut self, state: &SurfelIrradiance, weight: f32, age: u32, is_own: bool) {
        let variance = mean_variance(state);
        self.ray_variance += weight * state.variance;
        self.ray_sum += weight;
        if is_own {
            return;
        }
        let counts = weight * (state.samples as f32).min(MOST_RAYS);
        let level = luminance(state.mean);
        self.mean += state.mean * counts;
        self.sum += counts;
        self.squares += counts * (level * level);
        self.weights_squared += counts * counts;
        self.noise += counts * variance;
        self.trust += counts * lookup::trust(age);
    }

    /// What they say.
    #[inline]
    pub fn said(&self) -> Neighbours {
        let mut said = Neighbours::default();
        if self.ray_sum > 0.0 {
            said.ray_variance = self.ray_variance / self.ray_sum;
        }
        if self.sum <= 0.0 {
            return said;
        }
        said.mean = self.mean / self.sum;
        said.trust = self.trust / self.sum;
        let level = luminance(said.mean);
        let noise = self.noise / self.sum;
        // What the neighbours differ by, beyond their noise.
        let apart = (self.squares / self.sum - level * level - noise).max(0.0);
        // The noise of their mean.
        let left = noise * (self.weights_squared / (self.sum * self.sum));
        said.spread = apart + left;
        said
    }
}

/// What a surfel says, from its own irradiance and what its neighbours say. `age` is in frames.
#[inline]
pub fn light(state: &SurfelIrradiance, age: u32, neighbours: &Neighbours) -> SurfelLight {
    let own = lookup::trust(age);
    if neighbours.trust == 0.0 {
        return SurfelLight {
            irradiance: state.mean,
            trust: if state.samples > 0 { own } else { 0.0 },
        };
    }
    if state.samples == 0 {
        return SurfelLight {
            irradiance: neighbours.mean,
            trust: neighbours.trust,
        };
    }
    let noise = neighbours.ray_variance / state.samples as f32;
    let level = LEAST_SPREAD * luminance(neighbours.mean);
    let total = noise + neighbours.spread + level * level;
    let share = if total > 0.0 { noise / total } else { 0.0 };
    SurfelLight {
        irradiance: state.mean + (neighbours.mean - state.mean) * share,
        trust: own + (neighbours.trust - own) * share,
    }
}
