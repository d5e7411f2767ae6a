//! The multiscale mean estimator (GIBS, "Integrator"; Barre-Brisebois et al. 2019, Ray Tracing Gems, chapter 25).
//!
//! A long mean that converges, and a short-term mean and variance that tell when what it holds is out of date. The first
//! rays make a true mean; later the weight of a ray grows with its index, so that the bounces missing from the first frames
//! are forgotten. Whether the short mean has left the long one is judged over all surfels of a cell ([`Drift`]): one
//! surfel's rays are too noisy to tell a light that went out from bad luck before hundreds of frames have passed, and a
//! surfel that follows its own luck is biased, because luck is more often low than high. All thresholds are relative, so
//! that scaling every light by a power of two scales the result by exactly that.
use crate::data::{ClampedLight, Drift, SurfelIrradiance};
use glam::{Vec2, Vec3};

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
/// Age, in frames, from which on a mean has settled.
pub const SETTLED: u32 = 128;
/// Weight of a ray in a settled mean that is noisy: that of a plain one, so that it does not flicker.
pub const SETTLED_RECENCY: f32 = 1.0;
/// Relative standard error up to which a settled mean is quiet: it goes on forgetting the first frames, which in a room of
/// high albedo takes long.
pub const QUIET: f32 = 0.02;
/// Weight of a ray in a mean that began anew: the surfels that its first rays hit did not all begin anew in the same
/// frame, and what they said is forgotten with the fourth power of its share.
pub const ANEW_RECENCY: f32 = 4.0;
/// Frames for which it counts as one that began anew.
pub const ANEW: u32 = 32;
/// The long mean remembers no more rays than this.
pub const MOST_SAMPLES: u32 = 1 << 17;
/// Surfels of a cell whose drift is summed: the first ones of its list, which are an unbiased subset.
pub const DRIFT_OF: u32 = 32;
/// Drift of a cell, in its standard deviations, from which on surfels forget. Chance passes it once in some hundred times.
pub const DRIFT_LEAST: f32 = 3.0;
/// Drift of a cell, in its standard deviations, at which surfels begin anew.
pub const DRIFT_MOST: f32 = 5.0;
/// Drift of a cell, in its standard deviations, that keeps it from following all others.
pub const DRIFT_AGAINST: f32 = -0.5;
/// Drift of a cell, in its standard deviations, from which on it follows all others.
pub const DRIFT_FOR: f32 = 1.0;
/// Drift that is taken for noise, over the level.
pub const DRIFT_FLOOR: f32 = 0.02;
/// Share of a change that its drift is taken to show: the short mean has only just begun to follow.
pub const DRIFT_SHOWS: f32 = 0.125;

/// Rec. 709 luminance.
#[inline]
pub fn luminance(c: Vec3) -> f32 {
    0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z
}

/// A sample of irradiance, or none where its luminance is below the faintest.
#[inline]
pub fn unless_faint(sample: Vec3, faintest: f32) -> Vec3 {
    if luminance(sample) < faintest {
        Vec3::ZERO
    } else {
        sample
    }
}

/// How far the short means of several surfels have left their long ones.
pub trait Drifting: Sized {
    /// With one more surfel; one without rays adds nothing.
    fn with(self, state: &SurfelIrradiance) -> Self;
    /// Of the surfels of both.
    fn plus(self, other: &Self) -> Self;
    /// In standard deviations of chance; negative where light has gone.
    fn relative(&self) -> f32;
    /// Over the level.
    fn change(&self) -> f32;
}

impl Drifting for Drift {
    #[inline]
    fn with(self, state: &SurfelIrradiance) -> Self {
        let (short, long) = (luminance(state.short_mean), luminance(state.mean));
        self.plus(&Self {
            sum: short - long,
            noise: state.short_noise,
            level: short.max(long),
            pad: 0,
        })
    }

    #[inline]
    fn plus(self, other: &Self) -> Self {
        Self {
            sum: self.sum + other.sum,
            noise: self.noise + other.noise,
            level: self.level + other.level,
            pad: 0,
        }
    }

    #[inline]
    fn relative(&self) -> f32 {
        let floor = DRIFT_FLOOR * self.level;
        let deviation = (self.noise + floor * floor).sqrt();
        if deviation > 0.0 {
            self.sum / deviation
        } else {
            0.0
        }
    }

    #[inline]
    fn change(&self) -> f32 {
        if self.level > 0.0 {
            self.sum.abs() / self.level
        } else {
            0.0
        }
    }
}

/// 0 below [`DRIFT_LEAST`], 1 from [`DRIFT_MOST`] on.
#[inline]
fn significance(drift: f32) -> f32 {
    let t = ((drift - DRIFT_LEAST) / (DRIFT_MOST - DRIFT_LEAST)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Share of what they know that the surfels of a cell should forget, from its drift and that of all surfels, and by how much
/// their light has changed. Where light changes everywhere, that is known long before a single cell is sure of it; a cell
/// follows unless its own drift speaks against it.
#[inline]
pub fn to_forget(cell: &Drift, everywhere: &Drift) -> Vec2 {
    let (own, all) = (cell.relative(), everywhere.relative());
    let sign = if all < 0.0 { -1.0 } else { 1.0 };
    let agreement = ((sign * own - DRIFT_AGAINST) / (DRIFT_FOR - DRIFT_AGAINST)).clamp(0.0, 1.0);
    let (own, all) = (significance(own.abs()), significance(all.abs()) * agreement);
    if own >= all {
        Vec2::new(own, cell.change())
    } else {
        Vec2::new(all, everywhere.change())
    }
}

/// What is left of the state when a share of it is forgotten, because its light has changed by so much of its level: it counts
/// for fewer rays, and is younger. It keeps the rays below which its noise would be more than the change.
#[inline]
pub fn forget(state: &SurfelIrradiance, share: f32, change: f32, frame: u32) -> SurfelIrradiance {
    if share <= 0.0 {
        return *state;
    }
    let samples = state.samples as f32;
    let level = luminance(state.short_mean).max(luminance(state.mean));
    let error = (1.0 / DRIFT_SHOWS) * (change * level);
    let least = if error > 0.0 {
        (state.variance / (error * error)).min(samples)
    } else {
        samples
    };
    let kept = (samples * (1.0 - share)).max(least);
    let age = frame.wrapping_sub(state.since) as f32;
    SurfelIrradiance {
        samples: kept as u32,
        since: frame.wrapping_sub((age * (kept / samples.max(1.0))) as u32),
        ..*state
    }
}

/// The sample of `rays` rays that the clamp leaves: no brighter than [`FIREFLY_SIGMAS`] above the short mean. Its colour
/// stays.
#[inline]
pub fn clamped(state: &SurfelIrradiance, sample: Vec3, rays: u32) -> Vec3 {
    let deviation = (state.variance / rays as f32).max(0.0).sqrt();
    let limit = luminance(state.short_mean) + FIREFLY_SIGMAS * deviation;
    let level = luminance(sample);
    if state.samples <= CLAMP_AFTER || level <= limit {
        return sample;
    }
    sample * (limit / level)
}

/// What [`clamped`] takes from a sample.
#[inline]
pub fn taken(state: &SurfelIrradiance, sample: Vec3, rays: u32) -> ClampedLight {
    let (before, after) = (luminance(sample), luminance(clamped(state, sample, rays)));
    ClampedLight {
        taken: rays as f32 * (before - after),
        brought: rays as f32 * before,
        samples: u32::from(after < before),
        pad: 0,
    }
}

#[inline]
fn is_quiet(state: &SurfelIrradiance) -> bool {
    let error = QUIET * luminance(state.mean);
    state.variance <= state.samples as f32 * (error * error)
}

/// Weight of a ray in the long mean, over its share in a plain one.
#[inline]
fn recency(state: &SurfelIrradiance, frame: u32) -> f32 {
    let age = frame.wrapping_sub(state.since);
    if state.drawn > state.samples && age < ANEW {
        ANEW_RECENCY
    } else if state.samples < PLAIN_MEAN {
        1.0
    } else if age < SETTLED || is_quiet(state) {
        RECENCY
    } else {
        SETTLED_RECENCY
    }
}

/// Takes in the mean of `rays` new rays, W/m^2, in a frame. With `clamp`, fireflies are cut.
#[inline]
pub fn update(
    state: &SurfelIrradiance,
    sample: Vec3,
    rays: u32,
    frame: u32,
    clamp: bool,
) -> SurfelIrradiance {
    let n = rays as f32;
    let mut drawn = state.drawn + rays;
    if drawn >= MOST_SAMPLES {
        // The sequence of directions goes through its second half again: numbers beyond lose digits.
        drawn = MOST_SAMPLES / 2 + drawn % (MOST_SAMPLES / 2);
    }
    let level = luminance(sample);
    if state.samples == 0 {
        return SurfelIrradiance {
            mean: sample,
            samples: rays,
            short_mean: sample,
            since: frame,
            // Nothing is known yet: a ray that varies as much as it brings.
            variance: n * (level * level),
            short_noise: level * level,
            drawn,
            pad: 0,
        };
    }
    let confidence = (n / FULL_CONFIDENCE).min(1.0);
    let y = if clamp {
        clamped(state, sample, rays)
    } else {
        sample
    };
    // Long term.
    let weight = n * recency(state, frame);
    let share = weight / (state.samples as f32 + weight);
    // Short term. While few rays are in, the two are the same.
    let blend = (SHORT_BLEND * confidence).max(share);
    let delta = level - luminance(state.short_mean);
    let short_mean = state.short_mean + (y - state.short_mean) * blend;
    // Of one ray, and of the sample as it came: a variance of clamped samples would shrink the limit further, and so lose
    // energy.
    let spread = n * (delta * delta * (1.0 - blend));
    // The variance of all rays so far; later it follows more slowly than the mean, so that it does not shrink with the
    // mean's own jumps.
    let variance = state.variance + (spread - state.variance) * share.max(0.5 * blend);
    // Variance of the short mean: what a sample adds, and what is left of those before.
    let kept = (1.0 - blend) * (1.0 - blend);
    let short_noise = kept * state.short_noise + blend * blend * (variance / n);
    SurfelIrradiance {
        mean: state.mean + (y - state.mean) * share,
        samples: (state.samples + rays).min(MOST_SAMPLES),
        short_mean,
        since: state.since,
        variance,
        short_noise,
        drawn,
        pad: 0,
    }
}

#[cfg(test)]
mod tests;
