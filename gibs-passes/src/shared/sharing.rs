//! Irradiance shared between neighbouring surfels (GIBS, "Irradiance Sharing").
//!
//! The mean of a surfel and its neighbours is a guess of the surfel's own irradiance that has less noise, and another error:
//! the irradiance is not the same there. Its own mean is drawn towards that guess by its own noise over what the surfels
//! differ by beyond their noise, as in empirical Bayes estimation (Efron and Morris 1975, "Data Analysis Using Stein's
//! Estimator and its Generalizations"). So sharing fades out as a surfel learns, and never crosses an edge that stands out of
//! the noise. What is shared goes into what a surfel says, not into its own mean: a guess is not passed on as knowledge.
//!
//! The surfel itself belongs to those whose mean, noise and differences are taken. Left out, a lucky one would give all its
//! light away to neighbours that take less of it, since their differences look larger from where they are: where one ray in
//! a hundred finds light, a third of it would be lost.
use super::estimator::luminance;
use super::lookup;
use crate::data::{Neighbours, SurfelIrradiance, SurfelLight};
use glam::Vec3;

/// Reach of a neighbour, in radii: as far as depth functions know what stands between. Lists hold surfels that reach the cell
/// with one radius, so that beside a cell's border the farther neighbours of the other side are not asked.
pub const REACH: u32 = 2;

/// Neighbours count by their rays, up to so many.
pub const MOST_RAYS: f32 = 4096.0;

/// Neighbours of less weight do not count: products with dim light would underflow, at another brightness than their sum.
pub const LEAST_WEIGHT: f32 = 1e-6;

/// As many rays as the mean of the neighbours is worth at most.
pub const MOST_WORTH: f32 = 1_048_576.0;

/// Standard deviation of irradiance between neighbours, relative, that is assumed even where none shows: below this,
/// a surfel's own noise is left alone.
pub const LEAST_SPREAD: f32 = 0.05;

/// Relative standard error of its mean below which a surfel does not ask its neighbours.
pub const CERTAIN: f32 = 0.015;

/// Rays before which no standard error is believed: what is rare may not have come yet.
pub const UNCERTAIN_BEFORE: u32 = 256;

/// Rays with which a surfel's own variance counts as that of a neighbour at the same place; with twice the rays twice as much.
/// It takes a few to know it; but later the variance of brighter neighbours would make the mean of a surfel in the dark look
/// like noise, and what they say fill it up.
pub const OWN_RAYS: f32 = 8.0;

/// Part of its weight with which a surfel counts among its neighbours. It is nearest to itself, and with all of it much of its
/// noise would stay in the mean.
pub const OWN_PART: f32 = 0.5;

/// Age, in frames, from which on a surfel asks only once in [`PERIOD`] frames: what its neighbours say changes little. One that has
/// forgotten is young again; where it asked but every second frame from eight on, light that goes out would linger for three more
/// frames in the Cornell box.
pub const FRESH: u32 = 16;

/// Frames from one time that a surfel asks to the next.
pub const PERIOD: u32 = 8;

/// Surfels that ask in the same frames: a workgroup of them, so that those that wait do not keep others waiting.
pub const TOGETHER: u32 = 64;

/// What a surfel and its neighbours say about its irradiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Said {
    /// Weighted mean of their irradiance, W/m^2.
    pub mean: Vec3,
    /// How far to trust that, see [`SurfelLight`]; 0 where there are no neighbours.
    pub trust: f32,
    /// How many of the surfel's own rays say as much: the variance of the luminance that one ray brings, here and around, over
    /// that of irradiance from surfel to surfel.
    pub rays: f32,
    /// Variance of the luminance that one ray brings to the neighbours alone, over the square of their mean's luminance. It knows
    /// what is rare before the surfel's own rays have met with it, and does not know what those found: where a lucky surfel got
    /// more rays than an unlucky one, its luck would be thinned out, and the mean of all be too low.
    pub ray_variance: f32,
}

/// Steps of a packed trust.
pub const TRUST_STEPS: f32 = 255.0;

/// Bits of packed rays: the first of their `f32` after the sign, six of them of the mantissa, which errs by 1.6 % at most.
pub const RAYS_BITS: u32 = 14;

/// Bits of a packed variance of a ray: the first of its `f32` after the sign, two of them of the mantissa, which errs by a
/// quarter at most, an eighth of a standard deviation.
const VARIANCE_BITS: u32 = 10;

/// The variance of a ray is said to be no more than this.
pub const MOST_VARIANCE: f32 = 1_048_576.0;

/// The first bits of a number that is not negative, after the sign.
#[inline]
fn first_bits(value: f32, bits: u32) -> u32 {
    value.to_bits() >> (31 - bits)
}

/// The number that begins with these bits.
#[inline]
fn from_first_bits(first: u32, bits: u32) -> f32 {
    f32::from_bits((first & ((1 << bits) - 1)) << (31 - bits))
}

/// In place of what was packed, for a surfel that is to ask: no rays are so many.
pub const ASKS: Neighbours = Neighbours {
    mean: Vec3::ZERO,
    packed: u32::MAX,
};

impl Said {
    /// Trust in bits 0-7, rays in bits 8-21, the variance of a ray in bits 22-31: ratios, so that scaling every light by a power
    /// of two changes no bit.
    #[inline]
    pub fn pack(&self) -> Neighbours {
        if self.trust <= 0.0 {
            return Neighbours::default();
        }
        let trust = (self.trust * TRUST_STEPS).ceil().min(TRUST_STEPS) as u32;
        Neighbours {
            mean: self.mean,
            packed: trust
                | first_bits(self.rays, RAYS_BITS) << 8
                | first_bits(self.ray_variance, VARIANCE_BITS) << (8 + RAYS_BITS),
        }
    }

    /// What was packed.
    #[inline]
    pub fn unpack(packed: &Neighbours) -> Self {
        Said {
            mean: packed.mean,
            trust: (packed.packed & 0xff) as f32 / TRUST_STEPS,
            rays: from_first_bits(packed.packed >> 8, RAYS_BITS),
            ray_variance: from_first_bits(packed.packed >> (8 + RAYS_BITS), VARIANCE_BITS),
        }
    }
}

/// Variance of the luminance of a surfel's long mean, W^2/m^4, as if all its rays weighed the same: with the weights of a mean
/// that has not settled it is up to 4/3 of that, of one that began anew 16/7.
#[inline]
pub fn mean_variance(state: &SurfelIrradiance) -> f32 {
    state.variance / state.samples.max(1) as f32
}

/// Whether a surfel is uncertain enough to ask its neighbours. One that has found no light has no variance either, and may have
/// been unlucky.
#[inline]
pub fn asks(state: &SurfelIrradiance) -> bool {
    let level = luminance(state.mean);
    state.samples < UNCERTAIN_BEFORE || mean_variance(state) >= CERTAIN * CERTAIN * level * level
}

/// Whether it is the turn of a surfel, and of those that ask together with it.
#[inline]
pub fn is_turn(surfel: u32, frame: u32) -> bool {
    (surfel / TOGETHER)
        .wrapping_add(frame)
        .is_multiple_of(PERIOD)
}

/// Whether a surfel asks in this frame, where it is to forget a share of what it knows; else what it was told before still
/// holds.
#[inline]
pub fn is_due(surfel: u32, state: &SurfelIrradiance, forget: f32, frame: u32) -> bool {
    state.samples == 0
        || frame.wrapping_sub(state.since) < FRESH
        || is_turn(surfel, frame)
        || forget > 0.0
}

/// Sums over the neighbours of a surfel, itself among them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Asked {
    others: u32,
    mean: Vec3,
    sum: f32,
    squares: f32,
    noise: f32,
    trust: f32,
    ray_variance: f32,
    ray_sum: f32,
    around: Around,
}

/// Sums over the neighbours alone. Luminance is that of the short mean where this is brighter: once light has gone, variances fall
/// more slowly than means.
#[derive(Clone, Copy, Debug, Default)]
struct Around {
    ray_variance: f32,
    ray_sum: f32,
    level: f32,
    sum: f32,
}

impl Asked {
    /// Takes in a surfel that has integrated rays, with its weight and its age in frames. `is_own` for the one that asks.
    #[inline]
    pub fn add(&mut self, state: &SurfelIrradiance, weight: f32, age: u32, is_own: bool) {
        if weight < LEAST_WEIGHT {
            return;
        }
        let samples = state.samples as f32;
        let (of_rays, part) = match is_own {
            true => (weight * (samples / OWN_RAYS).max(1.0), OWN_PART),
            false => (weight, 1.0),
        };
        self.ray_variance += of_rays * state.variance;
        self.ray_sum += of_rays;
        self.others += u32::from(!is_own);
        let counts = part * weight * samples.min(MOST_RAYS);
        let level = luminance(state.mean);
        if !is_own {
            self.around.ray_variance += of_rays * state.variance;
            self.around.ray_sum += of_rays;
            self.around.level += counts * level.max(luminance(state.short_mean));
            self.around.sum += counts;
        }
        self.mean += state.mean * counts;
        self.sum += counts;
        self.squares += counts * (level * level);
        self.noise += counts * mean_variance(state);
        self.trust += counts * lookup::trust(age);
    }

    /// What they say.
    #[inline]
    pub fn said(&self) -> Said {
        let mut said = Said::default();
        if self.others == 0 || self.sum <= 0.0 {
            return said;
        }
        said.mean = self.mean / self.sum;
        said.trust = self.trust / self.sum;
        let level = luminance(said.mean);
        let noise = self.noise / self.sum;
        // What they differ by, beyond their noise.
        let apart = (self.squares / self.sum - level * level - noise).max(0.0);
        let least = LEAST_SPREAD * level;
        let spread = apart + least * least;
        let ray_variance = self.ray_variance / self.ray_sum;
        let around = &self.around;
        if around.ray_variance > 0.0 {
            let level = around.level / around.sum;
            let squared = (level * level).max(f32::MIN_POSITIVE);
            said.ray_variance = (around.ray_variance / around.ray_sum / squared).min(MOST_VARIANCE);
        }
        // Where nothing tells that they differ, they are as good as any number of rays.
        said.rays = if ray_variance > 0.0 {
            (ray_variance / spread.max(f32::MIN_POSITIVE)).min(MOST_WORTH)
        } else {
            0.0
        };
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
    // Each counts by its rays.
    let share = neighbours.rays / (neighbours.rays + state.samples as f32);
    SurfelLight {
        irradiance: state.mean + (neighbours.mean - state.mean) * share,
        trust: own + (neighbours.trust - own) * share,
    }
}

#[cfg(test)]
mod tests;
