// The multiscale mean estimator (GIBS, "Integrator"; Barre-Brisebois et al. 2019, Ray Tracing Gems, chapter 25): a long
// mean whose blend factor is steered by a short-term mean and variance.
import package::types::SurfelIrradiance;

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
/// Here the ray count falls back to its upper half, which bounds the memory of the long mean.
const ESTIMATOR_MOST_SAMPLES: u32 = 131072u;

/// Rec. 709 luminance.
fn estimator_luminance(c: vec3<f32>) -> f32 {
    return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z;
}

fn estimator_smoothstep(x: f32) -> f32 {
    let t = clamp(x, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/// Takes in the mean of `rays` new rays, W/m^2. With `cut`, fireflies are clamped.
fn estimator_update(state: SurfelIrradiance, mean_of_rays: vec3<f32>, rays: u32, cut: bool) -> SurfelIrradiance {
    let n = f32(rays);
    if state.samples == 0u {
        return SurfelIrradiance(mean_of_rays, rays, mean_of_rays, 1.0, mean_of_rays * mean_of_rays, 0.0);
    }
    let confidence = min(n / ESTIMATOR_FULL_CONFIDENCE, 1.0);
    var y = mean_of_rays;
    if cut && state.samples > ESTIMATOR_CLAMP_AFTER {
        y = min(y, state.short_mean + sqrt(state.variance) * ESTIMATOR_FIREFLY_SIGMAS);
    }
    // Short term. While few rays are in, it is a plain mean too.
    let plain = n / (f32(state.samples) + n);
    let blend = max(ESTIMATOR_SHORT_BLEND * confidence, plain);
    let delta = mean_of_rays - state.short_mean;
    let short_mean = state.short_mean + (y - state.short_mean) * blend;
    // Of the sample as it came: a variance of clamped samples would shrink the limit further, and so lose energy.
    let spread = delta * delta * (1.0 - blend);
    // The variance follows more slowly than the mean, so that it does not shrink with the mean's own jumps.
    let variance = state.variance + (spread - state.variance) * (blend * 0.5);
    // How far the short mean has strayed, in standard deviations of the short mean itself.
    let sigma = sqrt(max(estimator_luminance(variance), 0.0));
    let stray = estimator_luminance(abs(state.mean - short_mean));
    let deviation = max(sigma, 1e-4 * estimator_luminance(short_mean));
    var relative = 0.0;
    var steady = 1.0;
    if deviation > 0.0 {
        relative = stray / deviation;
        // Of the brighter mean: a light that goes out must not look like noise around black.
        let level = max(estimator_luminance(short_mean), estimator_luminance(state.mean));
        steady = clamp(0.5 * level / deviation, 1.0 / 32.0, 1.0);
    }
    let inconsistency = state.inconsistency + (relative - state.inconsistency) * 0.08;
    let catch_up =
        estimator_smoothstep(relative * max(inconsistency - 0.2, 0.02)) * state.reduction * confidence;
    let reduction = state.reduction + (steady - state.reduction) * 0.1;
    // Long term.
    var share = plain;
    if state.samples >= ESTIMATOR_PLAIN_MEAN {
        share = min(ESTIMATOR_RECENCY * plain, 1.0);
    }
    let mean = state.mean + (y - state.mean) * max(share, catch_up);
    var samples = state.samples + rays;
    if samples >= ESTIMATOR_MOST_SAMPLES {
        samples = ESTIMATOR_MOST_SAMPLES / 2u + samples % (ESTIMATOR_MOST_SAMPLES / 2u);
    }
    return SurfelIrradiance(mean, samples, short_mean, reduction, variance, inconsistency);
}
