// The multiscale mean estimator (GIBS, "Integrator"; Barre-Brisebois et al. 2019, Ray Tracing Gems, chapter 25): a long
// mean, and a short-term mean and variance that tell when it is out of date, judged over the surfels of a cell.
import package::types::{ClampedLight, Drift, SurfelIrradiance};

/// Blend of the short-term mean for a sample of full confidence.
const ESTIMATOR_SHORT_BLEND: f32 = 0.08;
/// Rays that make a sample of full confidence.
const ESTIMATOR_FULL_CONFIDENCE: f32 = 4.0;
/// Samples brighter than the short mean by this many standard deviations are clamped.
const ESTIMATOR_FIREFLY_SIGMAS: f32 = 8.0;
/// The clamp does not act before this many rays.
const ESTIMATOR_CLAMP_AFTER: u32 = 64u;
/// Rays up to which the long mean is a plain one.
const ESTIMATOR_PLAIN_MEAN: u32 = 64u;
/// Weight of a ray after that, over its share in a plain mean.
const ESTIMATOR_RECENCY: f32 = 2.0;
/// Age, in frames, from which on a mean has settled.
const ESTIMATOR_SETTLED: u32 = 128u;
/// Weight of a ray in a settled mean that is noisy.
const ESTIMATOR_SETTLED_RECENCY: f32 = 1.0;
/// Relative standard error up to which a settled mean is quiet.
const ESTIMATOR_QUIET: f32 = 0.02;
/// Weight of a ray in a mean that began anew.
const ESTIMATOR_ANEW_RECENCY: f32 = 4.0;
/// Frames for which it counts as one that began anew.
const ESTIMATOR_ANEW: u32 = 32u;
/// The long mean remembers no more rays than this.
const ESTIMATOR_MOST_SAMPLES: u32 = 131072u;
/// Surfels of a cell whose drift is summed.
const ESTIMATOR_DRIFT_OF: u32 = 32u;
/// Drift of a cell, in its standard deviations, from which on surfels forget.
const ESTIMATOR_DRIFT_LEAST: f32 = 3.0;
/// Drift of a cell, in its standard deviations, at which surfels begin anew.
const ESTIMATOR_DRIFT_MOST: f32 = 5.0;
/// Drift of a cell, in its standard deviations, that keeps it from following all others.
const ESTIMATOR_DRIFT_AGAINST: f32 = -0.5;
/// Drift of a cell, in its standard deviations, from which on it follows all others.
const ESTIMATOR_DRIFT_FOR: f32 = 1.0;
/// Drift that is taken for noise, over the level.
const ESTIMATOR_DRIFT_FLOOR: f32 = 0.02;
/// Share of a change that its drift is taken to show.
const ESTIMATOR_DRIFT_SHOWS: f32 = 0.125;

/// Rec. 709 luminance.
fn estimator_luminance(c: vec3<f32>) -> f32 {
    return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z;
}

/// A sample of irradiance, or none where its luminance is below the faintest.
fn estimator_unless_faint(sample: vec3<f32>, faintest: f32) -> vec3<f32> {
    if estimator_luminance(sample) < faintest {
        return vec3<f32>(0.0);
    }
    return sample;
}

/// With one more surfel; one without rays adds nothing.
fn estimator_with_drift(drift: Drift, state: SurfelIrradiance) -> Drift {
    let short_level = estimator_luminance(state.short_mean);
    let long_level = estimator_luminance(state.mean);
    let own = Drift(short_level - long_level, state.short_noise, max(short_level, long_level), 0u);
    return estimator_plus_drift(drift, own);
}

/// Of the surfels of both.
fn estimator_plus_drift(a: Drift, b: Drift) -> Drift {
    return Drift(a.sum + b.sum, a.noise + b.noise, a.level + b.level, 0u);
}

/// In standard deviations of chance; negative where light has gone.
fn estimator_relative_drift(drift: Drift) -> f32 {
    let floor_level = ESTIMATOR_DRIFT_FLOOR * drift.level;
    let deviation = sqrt(drift.noise + floor_level * floor_level);
    if deviation > 0.0 {
        return drift.sum / deviation;
    }
    return 0.0;
}

fn estimator_significance(drift: f32) -> f32 {
    let t = clamp((drift - ESTIMATOR_DRIFT_LEAST) / (ESTIMATOR_DRIFT_MOST - ESTIMATOR_DRIFT_LEAST), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/// Over the level.
fn estimator_change(drift: Drift) -> f32 {
    if drift.level > 0.0 {
        return abs(drift.sum) / drift.level;
    }
    return 0.0;
}

/// Share of what they know that the surfels of a cell should forget, from its drift and that of all surfels, and by how much
/// their light has changed.
fn estimator_to_forget(cell: Drift, everywhere: Drift) -> vec2<f32> {
    let own = estimator_relative_drift(cell);
    let all_surfels = estimator_relative_drift(everywhere);
    let sign_of_all = select(1.0, -1.0, all_surfels < 0.0);
    let agreement = clamp(
        (sign_of_all * own - ESTIMATOR_DRIFT_AGAINST) / (ESTIMATOR_DRIFT_FOR - ESTIMATOR_DRIFT_AGAINST), 0.0, 1.0
    );
    let of_cell = estimator_significance(abs(own));
    let of_all = estimator_significance(abs(all_surfels)) * agreement;
    if of_cell >= of_all {
        return vec2<f32>(of_cell, estimator_change(cell));
    }
    return vec2<f32>(of_all, estimator_change(everywhere));
}

/// What is left of the state when a share of it is forgotten, because its light has changed by so much of its level.
fn estimator_forget(state: SurfelIrradiance, share: f32, change: f32, frame: u32) -> SurfelIrradiance {
    if share <= 0.0 {
        return state;
    }
    let samples = f32(state.samples);
    let level = max(estimator_luminance(state.short_mean), estimator_luminance(state.mean));
    let error = (1.0 / ESTIMATOR_DRIFT_SHOWS) * (change * level);
    var least = samples;
    if error > 0.0 {
        least = min(state.variance / (error * error), samples);
    }
    let remaining = max(samples * (1.0 - share), least);
    var kept = state;
    kept.samples = u32(remaining);
    kept.since = frame - u32(f32(frame - state.since) * (remaining / max(samples, 1.0)));
    return kept;
}

/// The sample of `rays` rays that the clamp leaves.
fn estimator_clamped(state: SurfelIrradiance, mean_of_rays: vec3<f32>, rays: u32) -> vec3<f32> {
    let deviation = sqrt(max(state.variance / f32(rays), 0.0));
    let limit = estimator_luminance(state.short_mean) + ESTIMATOR_FIREFLY_SIGMAS * deviation;
    let level = estimator_luminance(mean_of_rays);
    if state.samples <= ESTIMATOR_CLAMP_AFTER || level <= limit {
        return mean_of_rays;
    }
    return mean_of_rays * (limit / level);
}

/// What the clamp takes from a sample.
fn estimator_taken(state: SurfelIrradiance, mean_of_rays: vec3<f32>, rays: u32) -> ClampedLight {
    let before = estimator_luminance(mean_of_rays);
    let after = estimator_luminance(estimator_clamped(state, mean_of_rays, rays));
    return ClampedLight(f32(rays) * (before - after), f32(rays) * before, select(0u, 1u, after < before), 0u);
}

/// Weight of a ray in the long mean, over its share in a plain one.
fn estimator_recency(state: SurfelIrradiance, frame: u32) -> f32 {
    let age = frame - state.since;
    if state.drawn > state.samples && age < ESTIMATOR_ANEW {
        return ESTIMATOR_ANEW_RECENCY;
    }
    if state.samples < ESTIMATOR_PLAIN_MEAN {
        return 1.0;
    }
    let error = ESTIMATOR_QUIET * estimator_luminance(state.mean);
    let is_quiet = state.variance <= f32(state.samples) * (error * error);
    return select(ESTIMATOR_SETTLED_RECENCY, ESTIMATOR_RECENCY, age < ESTIMATOR_SETTLED || is_quiet);
}

/// Takes in the mean of `rays` new rays, W/m^2. With `cut`, fireflies are clamped.
fn estimator_update(
    state: SurfelIrradiance,
    mean_of_rays: vec3<f32>,
    rays: u32,
    frame: u32,
    cut: bool,
) -> SurfelIrradiance {
    let n = f32(rays);
    var drawn = state.drawn + rays;
    if drawn >= ESTIMATOR_MOST_SAMPLES {
        drawn = ESTIMATOR_MOST_SAMPLES / 2u + drawn % (ESTIMATOR_MOST_SAMPLES / 2u);
    }
    let level = estimator_luminance(mean_of_rays);
    if state.samples == 0u {
        return SurfelIrradiance(
            mean_of_rays, rays, mean_of_rays, frame, n * (level * level), level * level, drawn, 0u
        );
    }
    let confidence = min(n / ESTIMATOR_FULL_CONFIDENCE, 1.0);
    var y = mean_of_rays;
    if cut {
        y = estimator_clamped(state, mean_of_rays, rays);
    }
    // Long term.
    let weight = n * estimator_recency(state, frame);
    let share = weight / (f32(state.samples) + weight);
    // Short term. While few rays are in, the two are the same.
    let blend = max(ESTIMATOR_SHORT_BLEND * confidence, share);
    let delta = level - estimator_luminance(state.short_mean);
    let short_mean = state.short_mean + (y - state.short_mean) * blend;
    // Of one ray, and of the sample as it came: a variance of clamped samples would shrink the limit further, and so lose
    // energy.
    let spread = n * (delta * delta * (1.0 - blend));
    // The variance of all rays so far; later it follows more slowly than the mean, so that it does not shrink with the
    // mean's own jumps.
    let variance = state.variance + (spread - state.variance) * max(share, 0.5 * blend);
    // Variance of the short mean: what a sample adds, and what is left of those before.
    let kept = (1.0 - blend) * (1.0 - blend);
    let short_noise = kept * state.short_noise + blend * blend * (variance / n);
    return SurfelIrradiance(
        state.mean + (y - state.mean) * share,
        min(state.samples + rays, ESTIMATOR_MOST_SAMPLES),
        short_mean,
        state.since,
        variance,
        short_noise,
        drawn,
        0u,
    );
}
