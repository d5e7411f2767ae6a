// Weights of a surfel at a point, and the moments of its depth function (GIBS, "Light Apply", "Radial Gaussian Depth").
import package::plane::plane_unpack;
import package::surface::surface_unorm16;
import package::types::{Gathered, SurfelPose};
import package::vector::vector_dot;

/// Distances off a surfel's plane count this many times: a Mahalanobis distance with a flat ellipsoid.
const LOOKUP_SQUASH: f32 = 4.0;
/// Weight of a surfel at its own centre.
const LOOKUP_PEAK: f32 = 4.0;
/// Surfels of a cell that its average takes in: the first ones, which are an unbiased subset.
const LOOKUP_AVERAGE_OF: u32 = 8u;
/// Surfels of less weight do not count: their product with dim light would underflow.
const LOOKUP_LEAST_WEIGHT: f32 = 1e-12;
/// Where a cell's list would begin that did not fit.
const LOOKUP_DROPPED: u32 = 0xffffffffu;
/// Summed weight at which a lookup at a ray's hit ends.
const LOOKUP_ENOUGH_AT_HITS: f32 = 2.0;
/// Summed weight below which a cell's average is not made up to a full one.
const LOOKUP_AVERAGE_LEAST: f32 = 0.25;
/// Age, in frames, at which a surfel's irradiance is fully trusted as the light of further bounces.
const LOOKUP_TRUSTED_AFTER: f32 = 32.0;
/// Least variance of the depth function, squared surfel diameters: the quantization of the moments.
const LOOKUP_LEAST_VARIANCE: f32 = 1e-4;
/// Chebyshev bounds below this count as none: the bound is not tight, and a bright room shines through it.
const LOOKUP_CHEBYSHEV_FLOOR: f32 = 0.6;

/// One step of a moment.
const LOOKUP_MOMENT_SCALE: f32 = 1.0 / 65535.0;

/// The farthest distance that a ray teaches, in diameters: one step below one, so that a texel that has learned from a ray
/// differs from `LOOKUP_UNKNOWN`.
const LOOKUP_FARTHEST: f32 = 65534.0 / 65535.0;
/// A texel that no ray has reached, nor one beside it that found something close: both moments one, so that it hides nothing.
const LOOKUP_UNKNOWN: u32 = 0xffffffffu;

/// A surfel's radius as a first moment, in steps.
const LOOKUP_RADIUS_STEPS: u32 = 0x8000u;

/// By how many steps the mean distance in a texel may lack a radius, in the mean, before surfaces count as close.
const LOOKUP_CLOSE: u32 = LOOKUP_RADIUS_STEPS / 32u;

/// Irradiance where surfels cover a point in part: their weighted mean, and the cell's average for what their weight leaves.
fn lookup_complete(g: Gathered) -> vec3<f32> {
    return g.irradiance + g.average * (1.0 - g.weight);
}

/// Whether a ray has reached a texel. What none has reached is `LOOKUP_UNKNOWN`, or a guess, whose second moment is zero.
fn lookup_is_known(texel: u32) -> bool {
    return texel != LOOKUP_UNKNOWN && (texel >> 16u) != 0u;
}

/// A texel that no ray has reached beside one whose mean distance, in steps, is this.
fn lookup_guess(nearest: u32) -> u32 {
    return select(LOOKUP_UNKNOWN, nearest, nearest < LOOKUP_RADIUS_STEPS);
}

/// The first and second moment in a texel, in steps of `LOOKUP_MOMENT_SCALE`.
fn lookup_steps(texel: u32) -> vec2<f32> {
    return vec2<f32>(f32(texel & 0xffffu), f32(texel >> 16u));
}

/// The first and second moment in a texel.
fn lookup_moments(texel: u32) -> vec2<f32> {
    return lookup_steps(texel) * LOOKUP_MOMENT_SCALE;
}

/// Moments in a texel, each in `[0, 1]`.
fn lookup_pack_moments(m: vec2<f32>) -> u32 {
    return surface_unorm16(m.x) | (surface_unorm16(m.y) << 16u);
}

/// A texel of a depth function over another diameter, which is that of before over `shrinks`; `squared` is its square.
fn lookup_rescaled(texel: u32, shrinks: f32, squared: f32) -> u32 {
    if texel == LOOKUP_UNKNOWN {
        return LOOKUP_UNKNOWN;
    }
    let m = lookup_moments(texel);
    let least = select(0.0, LOOKUP_MOMENT_SCALE, lookup_is_known(texel));
    return lookup_pack_moments(vec2<f32>(
        min(m.x * shrinks, LOOKUP_FARTHEST),
        min(max(m.y * squared, least), LOOKUP_FARTHEST),
    ));
}

/// Bound on the share of the light around a surfel that reaches distance `t` (over the diameter), from moments of the
/// depth there: Chebyshev's inequality, 1 up to the mean (Donnelly and Lauritzen 2006).
fn lookup_chebyshev(m: vec2<f32>, t: f32) -> f32 {
    if t <= m.x {
        return 1.0;
    }
    let variance = max(m.y - m.x * m.x, LOOKUP_LEAST_VARIANCE);
    let d = t - m.x;
    let bound = variance / (variance + d * d);
    let tight = max((bound - LOOKUP_CHEBYSHEV_FLOOR) / (1.0 - LOOKUP_CHEBYSHEV_FLOOR), 0.0);
    return tight * tight * tight;
}

/// How far to trust a surfel that was born so many frames ago and has integrated rays, in `(0, 1]`.
fn lookup_trust(age: u32) -> f32 {
    return min((f32(age) + 1.0) / LOOKUP_TRUSTED_AFTER, 1.0);
}

/// Nearness of a point to a surfel's centre: 1 there, 0 at the radius.
fn lookup_nearness(d: vec3<f32>, pose: SurfelPose) -> f32 {
    let across = plane_unpack(pose.mark);
    let h = vector_dot(d, across);
    let whole = vector_dot(across, across);
    let squared = (vector_dot(d, d) * whole + (LOOKUP_SQUASH * LOOKUP_SQUASH - 1.0) * h * h)
        / (whole * (pose.radius * pose.radius));
    return max(1.0 - squared, 0.0);
}

/// Distance factor: `LOOKUP_PEAK` at the centre, 0 at the radius, smooth at both.
fn lookup_falloff(d: vec3<f32>, pose: SurfelPose) -> f32 {
    let k = lookup_nearness(d, pose);
    return LOOKUP_PEAK * k * k;
}

/// Normal factor of a surfel for a cell's average, which takes what there is where nothing fits.
fn lookup_leaning(normal: vec3<f32>, pose: SurfelPose) -> f32 {
    let c = max(vector_dot(normal, pose.normal), 0.0);
    return c * c;
}

/// Normal factor of a surfel for a point.
fn lookup_alignment(normal: vec3<f32>, pose: SurfelPose) -> f32 {
    let c = max(vector_dot(normal, pose.normal), 0.0);
    let squared = c * c;
    let fourth = squared * squared;
    return fourth * fourth;
}
