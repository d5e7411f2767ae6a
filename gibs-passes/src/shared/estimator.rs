//! The multiscale mean estimator (GIBS, "Integrator"; Barre-Brisebois et al. 2019, Ray Tracing Gems, chapter 25).
//!
//! A long mean whose blend factor is steered by a short-term mean and variance. All thresholds are relative to the
//! short-term statistics, so that scaling every light by a power of two scales the result by exactly that. The first
//! rays make a true mean; later the weight of a ray grows with its index, so that the bounces missing from the first
//! frames are forgotten.
use crate::data::SurfelIrradiance;
use glam::Vec3;

/// Blend of the short-term mean for a sample of full confidence.
pub const SHORT_BLEND: f32 = 0.08;
/// Rays that make a sample of full confidence.
pub const FULL_CONFIDENCE: f32 = 4.0;
/// Samples brighter than the short mean by this many standard deviations are clamped.
pub const FIREFLY_SIGMAS: f32 = 8.0;
/// The clamp does not act before this many rays.
pub const CLAMP_AFTER: u32 = 64;
/// Rays up to which the long mean is a plain one.
pub const PLAIN_MEAN: u32 = 64;
/// Weight of a ray after that, over its share in a plain mean. A weight that grows linearly, 2, forgets a bias of the
/// first frames with the square of their share and has 4/3 of the plain mean's variance.
pub const RECENCY: f32 = 2.0;
/// Here the ray count falls back to its upper half, which bounds the memory of the long mean; the sequence of
/// directions, which it numbers, goes through that half again.
pub const MOST_SAMPLES: u32 = 1 << 17;

/// Rec. 709 luminance.
#[inline]
pub fn luminance(c: Vec3) -> f32 {
    0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z
}

#[inline]
fn smoothstep(x: f32) -> f32 {
    let t = x.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Takes in the mean of `rays` new rays, W/m^2. With `clamp`, fireflies are cut.
#[inline]
pub fn update(state: &SurfelIrradiance, sample: Vec3, rays: u32, clamp: bool) -> SurfelIrradiance {
    let n = rays as f32;
    if state.samples == 0 {
        return SurfelIrradiance {
            mean: sample,
            samples: rays,
            short_mean: sample,
            reduction: 1.0,
            variance: sample * sample,
            inconsistency: 0.0,
        };
    }
    let confidence = (n / FULL_CONFIDENCE).min(1.0);
    let mut y = sample;
    if clamp && state.samples > CLAMP_AFTER {
        let dev = Vec3::new(
            state.variance.x.sqrt(),
            state.variance.y.sqrt(),
            state.variance.z.sqrt(),
        );
        y = y.min(state.short_mean + dev * FIREFLY_SIGMAS);
    }
    // Short term. While few rays are in, it is a plain mean too.
    let plain = n / (state.samples as f32 + n);
    let blend = (SHORT_BLEND * confidence).max(plain);
    let delta = sample - state.short_mean;
    let short_mean = state.short_mean + (y - state.short_mean) * blend;
    // Of the sample as it came: a variance of clamped samples would shrink the limit further, and so lose energy.
    let spread = delta * delta * (1.0 - blend);
    // The variance follows more slowly than the mean, so that it does not shrink with the mean's own jumps.
    let variance = state.variance + (spread - state.variance) * (blend * 0.5);
    // How far the short mean has strayed, in standard deviations of the short mean itself.
    let sigma = luminance(variance).max(0.0).sqrt();
    let stray = luminance((state.mean - short_mean).abs());
    let floor = 1e-4 * luminance(short_mean);
    let deviation = sigma.max(floor);
    let relative = if deviation > 0.0 {
        stray / deviation
    } else {
        0.0
    };
    let inconsistency = state.inconsistency + (relative - state.inconsistency) * 0.08;
    // Of the brighter mean: a light that goes out must not look like noise around black.
    let level = luminance(short_mean).max(luminance(state.mean));
    let steady = if deviation > 0.0 {
        (0.5 * level / deviation).clamp(1.0 / 32.0, 1.0)
    } else {
        1.0
    };
    let catch_up =
        smoothstep(relative * (inconsistency - 0.2).max(0.02)) * state.reduction * confidence;
    let reduction = state.reduction + (steady - state.reduction) * 0.1;
    // Long term.
    let share = if state.samples < PLAIN_MEAN {
        plain
    } else {
        (RECENCY * plain).min(1.0)
    };
    let mean = state.mean + (y - state.mean) * share.max(catch_up);
    let mut samples = state.samples + rays;
    if samples >= MOST_SAMPLES {
        samples = MOST_SAMPLES / 2 + samples % (MOST_SAMPLES / 2);
    }
    SurfelIrradiance {
        mean,
        samples,
        short_mean,
        reduction,
        variance,
        inconsistency,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::hash;

    fn run(frames: u32, rays: u32, value: impl Fn(u32) -> Vec3) -> SurfelIrradiance {
        let mut state = SurfelIrradiance::default();
        for i in 0..frames {
            state = update(&state, value(i), rays, true);
        }
        state
    }

    #[test]
    fn a_constant_is_kept() {
        let state = run(1000, 4, |_| Vec3::new(0.1, 2.0, 30.0));
        assert!((state.mean - Vec3::new(0.1, 2.0, 30.0)).abs().max_element() < 1e-5);
        assert_eq!(state.samples, 4000);
    }

    /// Uniform noise on [0, 2): mean 1, variance 1/3. After 1000 frames the weights 2i/n^2 leave a standard error of
    /// sqrt(4/3 / 1000 / 3) = 0.021; catching up adds to it. 5 sigma of that is 0.11.
    #[test]
    fn noise_converges_to_its_mean() {
        for seed in 0..20 {
            let state = run(1000, 4, |i| {
                Vec3::splat(2.0 * hash::unit(hash::hash2(i, seed)))
            });
            assert!(
                (state.mean.x - 1.0).abs() < 0.11,
                "seed {seed}: {}",
                state.mean.x
            );
        }
    }

    /// A plain mean would keep 400/460 of the light; the catch-up leaves less than a tenth.
    #[test]
    fn a_light_that_went_out_is_forgotten_within_sixty_frames() {
        let noise = |i: u32| 0.5 + hash::unit(hash::hash2(i, 7));
        let state = run(460, 4, |i| {
            Vec3::splat(if i < 400 { 10.0 * noise(i) } else { 0.0 })
        });
        assert!(state.mean.x < 1.0, "{} of 10 is left", state.mean.x);
    }

    #[test]
    fn scaling_by_a_power_of_two_is_exact() {
        let noise = |i: u32| Vec3::splat(hash::unit(hash::hash2(i, 3)));
        let one = run(300, 2, noise);
        let many = run(300, 2, |i| noise(i) * 1024.0);
        assert_eq!(one.mean * 1024.0, many.mean);
    }

    #[test]
    fn darkness_stays_finite() {
        let state = run(100, 1, |_| Vec3::ZERO);
        assert_eq!(state.mean, Vec3::ZERO);
        assert!(state.inconsistency.is_finite() && state.reduction.is_finite());
    }
}
