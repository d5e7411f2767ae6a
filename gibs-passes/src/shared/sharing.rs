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

/// Age, in frames, from which on a surfel asks only once in [`PERIOD`] frames: what its neighbours say changes little.
pub const FRESH: u32 = 16;

/// Frames from one time that a surfel asks to the next.
pub const PERIOD: u32 = 4;

/// Surfels that ask in the same frames: a workgroup of them, so that those that wait do not keep others waiting.
pub const TOGETHER: u32 = 64;

/// What a surfel's neighbours say about its irradiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Said {
    /// Weighted mean of their irradiance, W/m^2.
    pub mean: Vec3,
    /// How far to trust that, see [`SurfelLight`]; 0 where there are no neighbours.
    pub trust: f32,
    /// Variance of the luminance that one ray brings, here and around, W^2/m^4.
    pub ray_variance: f32,
    /// Variance of the luminance between this surfel's irradiance and the mean, beyond what the surfel's own noise makes,
    /// W^2/m^4.
    pub spread: f32,
}

/// Steps of a packed trust.
const TRUST_STEPS: f32 = 255.0;

/// Bits that a packed ratio lacks of its `f32`: the sign, and all but four of the mantissa.
const RATIO_SHIFT: u32 = 19;

/// A ratio, not negative, in 12 bits: within 3.2 %.
#[inline]
fn pack_ratio(ratio: f32) -> u32 {
    (ratio.min(f32::MAX * 0.5).to_bits() + (1 << (RATIO_SHIFT - 1))) >> RATIO_SHIFT
}

#[inline]
fn unpack_ratio(bits: u32) -> f32 {
    f32::from_bits((bits & 0xfff) << RATIO_SHIFT)
}

impl Said {
    /// Trust in bits 0-7, and the variances over the square of the mean's luminance, the spread in bits 8-19: ratios, so
    /// that scaling every light by a power of two changes no bit.
    #[inline]
    pub fn pack(&self) -> Neighbours {
        if self.trust <= 0.0 {
            return Neighbours::default();
        }
        let level = luminance(self.mean);
        let over = |variance: f32| match level > 0.0 {
            true => pack_ratio(variance / (level * level)),
            false => 0,
        };
        let trust = (self.trust * TRUST_STEPS).ceil().min(TRUST_STEPS) as u32;
        Neighbours {
            mean: self.mean,
            packed: trust | over(self.spread) << 8 | over(self.ray_variance) << 20,
        }
    }

    /// What was packed.
    #[inline]
    pub fn unpack(packed: &Neighbours) -> Self {
        let level = luminance(packed.mean);
        let squared = level * level;
        Said {
            mean: packed.mean,
            trust: (packed.packed & 0xff) as f32 / TRUST_STEPS,
            spread: unpack_ratio(packed.packed >> 8) * squared,
            ray_variance: unpack_ratio(packed.packed >> 20) * squared,
        }
    }
}

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

/// Whether a surfel asks in this frame; else what it was told before still holds.
#[inline]
pub fn is_due(surfel: u32, state: &SurfelIrradiance, frame: u32) -> bool {
    state.samples == 0
        || frame.wrapping_sub(state.since) < FRESH
        || (surfel / TOGETHER)
            .wrapping_add(frame)
            .is_multiple_of(PERIOD)
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
    pub fn said(&self) -> Said {
        let mut said = Said::default();
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
pub fn light(state: &SurfelIrradiance, age: u32, neighbours: &Said) -> SurfelLight {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::hash;

    #[test]
    fn packing_keeps_trust_and_noise() {
        for i in 0..10_000u32 {
            let unit = |k| hash::unit(hash::hash2(i, k));
            let mean = Vec3::new(unit(0), unit(1), unit(2)) * 10f32.powf(20.0 * unit(3) - 10.0);
            let squared = luminance(mean) * luminance(mean);
            let said = Said {
                mean,
                trust: 1.0 - unit(4),
                ray_variance: squared * 10f32.powf(16.0 * unit(5) - 8.0),
                spread: squared * 10f32.powf(16.0 * unit(6) - 8.0),
            };
            let back = Said::unpack(&said.pack());
            assert_eq!(back.mean, mean);
            assert!(back.trust > 0.0 && (back.trust - said.trust).abs() <= 1.0 / TRUST_STEPS);
            for (a, b) in [
                (back.ray_variance, said.ray_variance),
                (back.spread, said.spread),
            ] {
                assert!((a / b - 1.0).abs() < 0.032, "{a} for {b}");
            }
            assert_eq!(Said::unpack(&back.pack()), back);
            let scaled = Said {
                mean: mean * 1024.0,
                ray_variance: said.ray_variance * 1_048_576.0,
                spread: said.spread * 1_048_576.0,
                ..said
            };
            assert_eq!(scaled.pack().packed, said.pack().packed);
        }
    }

    #[test]
    fn packing_survives_its_extremes() {
        let none = Said::default();
        assert_eq!(Said::unpack(&none.pack()), none);
        let dark = Said {
            trust: 1.0,
            ray_variance: 1.0,
            spread: 1.0,
            ..none
        };
        let back = Said::unpack(&dark.pack());
        assert_eq!(
            (back.trust, back.ray_variance, back.spread),
            (1.0, 0.0, 0.0)
        );
        let wild = Said {
            mean: Vec3::splat(1e-18),
            trust: 1e-9,
            ray_variance: f32::MAX,
            spread: f32::INFINITY,
        };
        let back = Said::unpack(&wild.pack());
        assert!(back.trust > 0.0 && back.ray_variance.is_finite() && back.spread.is_finite());
    }

    /// Every surfel asks once in a period, when it is born, and while it is fresh.
    #[test]
    fn every_surfel_asks_in_turn() {
        let state = SurfelIrradiance {
            samples: 100,
            ..SurfelIrradiance::default()
        };
        for surfel in [0, 63, 64, 1000] {
            let times = (100..200)
                .filter(|&frame| is_due(surfel, &state, frame))
                .count();
            assert_eq!(times, 25);
            assert!((0..FRESH).all(|frame| is_due(surfel, &state, frame)));
            assert!((100..200).all(|frame| is_due(surfel, &SurfelIrradiance::default(), frame)));
        }
    }
}
