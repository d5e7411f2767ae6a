//! Irradiance shared between neighbouring surfels (GIBS, "Irradiance Sharing").
//!
//! The mean of the neighbours is a guess of a surfel's own irradiance that has less noise, and another error: the
//! irradiance is not the same there. Both are measured, and the guess counts by the inverse of its variance, as in
//! empirical Bayes estimation (Efron and Morris 1975, "Data Analysis Using Stein's Estimator and its Generalizations"). So
//! sharing fades out as a surfel learns, and never crosses an edge that stands out of the noise. What is shared goes
//! into what a surfel says, not into its own mean: a guess is not passed on as knowledge.
use super::estimator::luminance;
use super::lookup::{self, Surfels};
use crate::data::{Neighbours, SurfelBirth, SurfelIrradiance, SurfelLight, SurfelPose};
use glam::Vec3;

/// Reach of a neighbour, in radii: as far as depth functions know what stands between.
pub const REACH: f32 = 2.0;

/// Neighbours count by their rays, up to so many.
pub const MOST_RAYS: f32 = 4096.0;

/// Standard deviation of irradiance between neighbours, relative, that is assumed even where none shows: below this,
/// a surfel's own noise is left alone.
pub const LEAST_SPREAD: f32 = 0.03;

/// Relative standard error of its mean below which a surfel does not ask its neighbours.
pub const CERTAIN: f32 = 0.01;

/// Rays before which no standard error is believed: what is rare may not have come yet.
pub const UNCERTAIN_BEFORE: u32 = 1024;

/// Variance of the luminance of a surfel's long mean, from that of a frame's sample and its age in frames, W^2/m^4.
#[inline]
pub fn mean_variance(state: &SurfelIrradiance, age: u32) -> f32 {
    luminance(state.variance).max(0.0) / age.max(1) as f32
}

/// Whether a surfel is uncertain enough to ask its neighbours.
#[inline]
pub fn asks(state: &SurfelIrradiance, age: u32) -> bool {
    let level = luminance(state.mean);
    state.samples < UNCERTAIN_BEFORE
        || mean_variance(state, age) > CERTAIN * CERTAIN * level * level
}

/// What the neighbours of a surfel that is looked up at its own position say: weights are those of the lookup, with a
/// wider reach.
#[inline]
pub fn ask(
    own: usize,
    s: &Surfels<'_>,
    irradiance: &[SurfelIrradiance],
    births: &[SurfelBirth],
    frame: u32,
) -> Neighbours {
    let (point, normal) = (s.poses[own].position, s.poses[own].normal);
    let mut mean = Vec3::ZERO;
    let (mut sum, mut squares, mut weights_squared) = (0.0f32, 0.0f32, 0.0f32);
    let (mut noise, mut trust) = (0.0f32, 0.0f32);
    let (mut ray_variance, mut ray_sum) = (0.0f32, 0.0f32);
    for &id in s.around(point) {
        let id = id as usize;
        let state = &irradiance[id];
        if state.samples == 0 {
            continue;
        }
        let pose = &s.poses[id];
        let wide = SurfelPose {
            radius: REACH * pose.radius,
            ..*pose
        };
        let d = point - pose.position;
        let mut weight = lookup::falloff(d, &wide) * lookup::alignment(normal, pose);
        if weight <= 0.0 {
            continue;
        }
        if !s.depths.is_empty() {
            weight *= lookup::visibility(&s.depths[id], pose, d);
        }
        let age = frame.wrapping_sub(births[id].frame);
        let variance = mean_variance(state, age);
        ray_variance += weight * (variance * state.samples as f32);
        ray_sum += weight;
        if id == own {
            continue;
        }
        let counts = weight * (state.samples as f32).min(MOST_RAYS);
        let level = luminance(state.mean);
        mean += state.mean * counts;
        sum += counts;
        squares += counts * (level * level);
        weights_squared += counts * counts;
        noise += counts * variance;
        trust += counts * lookup::trust(age);
    }
    if sum <= 0.0 {
        return Neighbours {
            ray_variance: if ray_sum > 0.0 {
                ray_variance / ray_sum
            } else {
                0.0
            },
            ..Neighbours::default()
        };
    }
    let mean = mean / sum;
    let level = luminance(mean);
    let noise = noise / sum;
    // What the neighbours differ by, beyond their noise.
    let apart = (squares / sum - level * level - noise).max(0.0);
    // The noise of their mean.
    let left = noise * (weights_squared / (sum * sum));
    Neighbours {
        mean,
        trust: trust / sum,
        ray_variance: ray_variance / ray_sum,
        spread: apart + left,
        pad0: 0,
        pad1: 0,
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
