// Irradiance shared between neighbouring surfels (GIBS, "Irradiance Sharing"): their mean is a guess that has less noise, towards
// which a surfel's own mean is drawn by its noise over what they differ by.
import package::estimator::estimator_luminance;
import package::lookup::lookup_trust;
import package::types::{Neighbours, SurfelIrradiance, SurfelLight};

/// Reach of a neighbour, in radii: as far as depth functions know what stands between.
const SHARING_REACH: u32 = 2u;
/// Neighbours count by their rays, up to so many.
const SHARING_MOST_RAYS: f32 = 4096.0;
/// Neighbours of less weight do not count: products with dim light would underflow.
const SHARING_LEAST_WEIGHT: f32 = 1e-6;
/// As many rays as the mean of the neighbours is worth at most.
const SHARING_MOST_WORTH: f32 = 1048576.0;
/// Relative standard deviation of irradiance between neighbours that is assumed even where none shows.
const SHARING_LEAST_SPREAD: f32 = 0.05;
/// Relative standard error of its mean below which a surfel does not ask its neighbours.
const SHARING_CERTAIN: f32 = 0.015;
/// Rays before which no standard error is believed.
const SHARING_UNCERTAIN_BEFORE: u32 = 256u;

/// Rays with which a surfel's own variance counts as that of a neighbour at the same place.
const SHARING_OWN_RAYS: f32 = 8.0;
/// Part of its weight with which a surfel counts among its neighbours.
const SHARING_OWN_PART: f32 = 0.5;
/// Age, in frames, from which on a surfel asks only once in a period.
const SHARING_FRESH: u32 = 16u;
/// Frames from one time that a surfel asks to the next.
const SHARING_PERIOD: u32 = 8u;
/// Surfels that ask in the same frames.
const SHARING_TOGETHER: u32 = 64u;
/// Steps of a packed trust.
const SHARING_TRUST_STEPS: f32 = 255.0;
/// Bits of packed rays: the first of their float after the sign.
const SHARING_RAYS_BITS: u32 = 14u;
/// Bits of a packed variance of a ray.
const SHARING_VARIANCE_BITS: u32 = 10u;
/// The variance of a ray is said to be no more than this.
const SHARING_MOST_VARIANCE: f32 = 1048576.0;

/// In place of what was packed, for a surfel that is to ask: no rays are so many.
const SHARING_ASKS: u32 = 0xffffffffu;

/// What a surfel's neighbours say about its irradiance: its mean, how far to trust it, and how many of the surfel's own rays
/// are as good.
struct SharingSaid {
    mean: vec3<f32>,
    trust: f32,
    rays: f32,
    /// Variance of the luminance that one ray brings to the neighbours alone, over the square of their mean's luminance.
    ray_variance: f32,
}

/// The first bits of a number that is not negative, after the sign.
fn sharing_first_bits(value: f32, bits: u32) -> u32 {
    return bitcast<u32>(value) >> (31u - bits);
}

/// The number that begins with these bits.
fn sharing_from_first_bits(first: u32, bits: u32) -> f32 {
    return bitcast<f32>((first & ((1u << bits) - 1u)) << (31u - bits));
}

/// Trust in bits 0-7, rays in bits 8-21, the variance of a ray in bits 22-31.
fn sharing_pack(said: SharingSaid) -> Neighbours {
    if said.trust <= 0.0 {
        return Neighbours();
    }
    let trust = u32(min(ceil(said.trust * SHARING_TRUST_STEPS), SHARING_TRUST_STEPS));
    let rays = sharing_first_bits(said.rays, SHARING_RAYS_BITS) << 8u;
    let variance = sharing_first_bits(said.ray_variance, SHARING_VARIANCE_BITS) << (8u + SHARING_RAYS_BITS);
    return Neighbours(said.mean, trust | rays | variance);
}

fn sharing_unpack(neighbours: Neighbours) -> SharingSaid {
    return SharingSaid(
        neighbours.mean,
        f32(neighbours.packed & 0xffu) / SHARING_TRUST_STEPS,
        sharing_from_first_bits(neighbours.packed >> 8u, SHARING_RAYS_BITS),
        sharing_from_first_bits(neighbours.packed >> (8u + SHARING_RAYS_BITS), SHARING_VARIANCE_BITS),
    );
}

/// Whether a surfel asks in this frame, where it is to forget a share of what it knows; else what it was told before still
/// holds.
fn sharing_is_due(surfel: u32, state: SurfelIrradiance, forget: f32, frame: u32) -> bool {
    return state.samples == 0u
        || forget > 0.0
        || frame - state.since < SHARING_FRESH
        || (surfel / SHARING_TOGETHER + frame) % SHARING_PERIOD == 0u;
}

/// Variance of the luminance of a surfel's long mean, W^2/m^4.
fn sharing_mean_variance(state: SurfelIrradiance) -> f32 {
    return state.variance / f32(max(state.samples, 1u));
}

/// Whether a surfel is uncertain enough to ask its neighbours.
fn sharing_asks(state: SurfelIrradiance) -> bool {
    let level = estimator_luminance(state.mean);
    return state.samples < SHARING_UNCERTAIN_BEFORE
        || sharing_mean_variance(state) >= SHARING_CERTAIN * SHARING_CERTAIN * level * level;
}

/// What a surfel says, from its own irradiance and what its neighbours say.
fn sharing_light(state: SurfelIrradiance, age: u32, neighbours: SharingSaid) -> SurfelLight {
    let own = lookup_trust(age);
    if neighbours.trust == 0.0 {
        return SurfelLight(state.mean, select(0.0, own, state.samples > 0u));
    }
    if state.samples == 0u {
        return SurfelLight(neighbours.mean, neighbours.trust);
    }
    // Each counts by its rays.
    let share = neighbours.rays / (neighbours.rays + f32(state.samples));
    return SurfelLight(
        state.mean + (neighbours.mean - state.mean) * share,
        own + (neighbours.trust - own) * share,
    );
}
