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
    // The variance follows more slowly than the mean, so that it does not shrink with the mean's own jumps.
    let variance = state.variance + (spread - state.variance) * (0.5 * blend);
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
mod tests {
    use super::*;
    use crate::shared::hash;

    fn run(frames: u32, rays: u32, value: impl Fn(u32) -> Vec3) -> SurfelIrradiance {
        let mut state = SurfelIrradiance::default();
        for i in 0..frames {
            state = update(&state, value(i), rays, i, true);
        }
        state
    }

    /// Surfels of one cell, each with samples of its own, which judge their drift together.
    fn cell(surfels: u32, frames: u32, sample: impl Fn(u32, u32) -> f32) -> Vec<SurfelIrradiance> {
        let mut states = vec![SurfelIrradiance::default(); surfels as usize];
        for frame in 0..frames {
            let drift = states.iter().fold(Drift::default(), |sum, s| sum.with(s));
            let [share, change] = to_forget(&drift, &Drift::default()).to_array();
            for (i, state) in (0..).zip(&mut states) {
                let kept = forget(state, share, change, frame);
                *state = update(&kept, Vec3::splat(sample(i, frame)), 4, frame, false);
            }
        }
        states
    }

    /// Bright once in `1 / chance` times, with a mean of one.
    fn rare(i: u32, frame: u32, seed: u32, chance: f32) -> f32 {
        let bright = hash::unit(hash::hash3(i, frame, seed)) < chance;
        if bright { 1.0 / chance } else { 0.0 }
    }

    fn mean(states: &[SurfelIrradiance]) -> f32 {
        states.iter().map(|s| s.mean.x).sum::<f32>() / states.len() as f32
    }

    #[test]
    fn a_constant_is_kept() {
        let state = run(1000, 4, |_| Vec3::new(0.1, 2.0, 30.0));
        assert!((state.mean - Vec3::new(0.1, 2.0, 30.0)).abs().max_element() < 1e-5);
        assert_eq!((state.samples, state.drawn), (4000, 4000));
    }

    /// Uniform noise on [0, 2): mean 1, variance 1/3. After 1000 frames weights of at most 2i/n^2 leave a standard error of at
    /// most sqrt(4/3 / 1000 / 3) = 0.021; 5 of those are 0.105.
    #[test]
    fn noise_converges_to_its_mean() {
        for seed in 0..20 {
            let noise = |i| Vec3::splat(2.0 * hash::unit(hash::hash2(i, seed)));
            let state = run(1000, 4, noise);
            assert!(
                (state.mean.x - 1.0).abs() < 0.105,
                "seed {seed}: {}",
                state.mean.x
            );
        }
    }

    /// Of one ray, the variance of uniform noise on [0, 2) in samples of 4 is 4/3; the short mean of samples of variance 1/3
    /// has 0.08 / 1.92 of that. Both are estimates over about 25 samples: a relative error of sqrt(2 / 25) = 0.28 each, and
    /// less in the mean over 40 runs, 0.045; 4 of those are 0.18.
    #[test]
    fn variances_are_those_of_a_ray_and_of_the_short_mean() {
        let (mut ray, mut short) = (0.0, 0.0);
        for seed in 0..40 {
            let noise = |i| Vec3::splat(2.0 * hash::unit(hash::hash2(i, seed)));
            let state = run(500, 4, noise);
            ray += state.variance / 40.0;
            short += state.short_noise / 40.0;
        }
        assert!((ray / (4.0 / 3.0) - 1.0).abs() < 0.18, "{ray}");
        let expected = SHORT_BLEND / (2.0 - SHORT_BLEND) / 3.0;
        assert!((short / expected - 1.0).abs() < 0.18, "{short}");
    }

    /// Samples that are 0 but for one in twenty, which is 20: the standard error of a surfel is sqrt(4/3 * 19 / 1000) =
    /// 0.16, of the mean over 16 runs of 32 surfels 0.0070; 5 of those are 0.035. An estimator that follows each
    /// surfel's own short mean comes out 8 % low on the like.
    #[test]
    fn rare_light_is_not_lost() {
        let runs = (0..16).map(|seed| mean(&cell(32, 1000, |i, f| rare(i, f, seed, 0.05))));
        let mean = runs.sum::<f32>() / 16.0;
        assert!((mean - 1.0).abs() < 0.035, "{mean}");
    }

    /// Chance alone makes a cell forget little: over 16 runs, 90 % of the rays still count in the mean.
    #[test]
    fn chance_is_not_taken_for_a_change() {
        let counted = (0..16).map(|seed| {
            let states = cell(32, 1000, |i, f| rare(i, f, seed, 0.05));
            states[0].samples as f32 / 4000.0
        });
        let counted = counted.sum::<f32>() / 16.0;
        assert!(counted > 0.9, "{counted}");
    }

    /// A plain mean would keep 400/430 of the light.
    #[test]
    fn a_light_that_went_out_is_gone_within_thirty_frames() {
        for seed in 0..8 {
            let states = cell(32, 430, |i, f| match f < 400 {
                true => rare(i, f, seed, 0.2),
                false => 0.0,
            });
            assert!(mean(&states) < 0.05, "{} is left", mean(&states));
        }
    }

    /// Half the light goes: within thirty frames the mean is nearer to what is left than to what was.
    #[test]
    fn a_light_that_fades_is_followed() {
        for seed in 0..8 {
            let states = cell(32, 430, |i, f| {
                rare(i, f, seed, 0.2) * if f < 400 { 1.0 } else { 0.5 }
            });
            let left = mean(&states);
            assert!((0.4..0.65).contains(&left), "{left}");
        }
    }

    #[test]
    fn a_cell_follows_all_others_unless_it_knows_better() {
        let share = |cell, everywhere| {
            let drift = |sum| Drift {
                sum,
                noise: 1.0,
                ..Drift::default()
            };
            to_forget(&drift(cell), &drift(everywhere)).x
        };
        assert_eq!(share(0.0, 0.0), 0.0);
        assert_eq!(share(-5.0, 0.0), 1.0);
        assert_eq!(share(-1.0, -9.0), 1.0);
        assert_eq!(share(0.5, -9.0), 0.0);
        assert_eq!(share(1.0, 9.0), 1.0);
        // What is not significant is no measure of the change.
        let few = Drift {
            sum: -0.36,
            noise: 0.1,
            level: 1.0,
            pad: 0,
        };
        let all = Drift {
            sum: -100.0,
            noise: 1.0,
            level: 500.0,
            pad: 0,
        };
        assert_eq!(to_forget(&few, &all), Vec2::new(1.0, 0.2));
        let half = share(-0.25, -9.0);
        assert!((0.4..0.6).contains(&half), "{half}");
    }

    #[test]
    fn what_is_forgotten_counts_for_fewer_rays() {
        let state = run(200, 4, |_| Vec3::ONE);
        let half = forget(&state, 0.5, 1.0, 200);
        assert_eq!((half.samples, half.since), (400, 100));
        assert_eq!(forget(&state, 0.0, 1.0, 200), state);
        // Of a ray's variance of 1, 1 / (8 * 0.02)^2 = 39 rays leave an error of 8 * 2 %.
        let noisy = SurfelIrradiance {
            variance: 1.0,
            ..state
        };
        assert_eq!(forget(&noisy, 1.0, 0.02, 200).samples, 39);
        assert_eq!(forget(&noisy, 1.0, 0.0, 200), noisy);
        let none = forget(&state, 1.0, 1.0, 200);
        let anew = update(&none, Vec3::splat(3.0), 2, 200, false);
        assert_eq!((anew.samples, anew.since, anew.drawn), (2, 200, 802));
        assert_eq!(anew.mean, Vec3::splat(3.0));
    }

    #[test]
    fn the_clamp_keeps_the_colour_and_cuts_nothing_else() {
        let state = run(200, 4, |i| Vec3::splat(hash::unit(hash::hash2(i, 5))));
        assert_eq!(clamped(&state, Vec3::ONE, 4), Vec3::ONE);
        let cut = clamped(&state, Vec3::new(100.0, 50.0, 0.0), 4);
        assert!(cut.x < 100.0 && (cut.x - 2.0 * cut.y).abs() < 1e-5 && cut.z == 0.0);
        // Mean 1/2, and eight times the deviation of about sqrt(1/12).
        assert!((2.0..4.0).contains(&luminance(cut)), "{cut}");
    }

    #[test]
    fn scaling_by_a_power_of_two_is_exact() {
        let noise = |i: u32| Vec3::splat(hash::unit(hash::hash2(i, 3)));
        let one = run(300, 2, noise);
        let many = run(300, 2, |i| noise(i) * 1024.0);
        assert_eq!(one.mean * 1024.0, many.mean);
        let drift = |state: &SurfelIrradiance| Drift::default().with(state).relative();
        assert_eq!(drift(&one), drift(&many));
    }

    #[test]
    fn darkness_stays_finite() {
        let states = cell(4, 100, |_, _| 0.0);
        assert!(
            states
                .iter()
                .all(|s| s.mean == Vec3::ZERO && s.short_noise == 0.0)
        );
    }

    /// 100 000 frames: the count stays bounded and the mean stays put.
    #[test]
    fn a_long_life_ends_nowhere() {
        let state = run(100_000, 4, |i| {
            Vec3::splat(0.5 + hash::unit(hash::hash2(i, 9)))
        });
        assert_eq!(state.samples, MOST_SAMPLES);
        assert!((MOST_SAMPLES / 2..MOST_SAMPLES).contains(&state.drawn));
        assert!((state.mean.x - 1.0).abs() < 0.01, "{}", state.mean.x);
    }
}
