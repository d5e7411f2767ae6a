// Irradiance shared between neighbouring surfels (GIBS, "Irradiance Sharing"): a guess that has less noise, and counts by
// the inverse of its variance.
import package::estimator::estimator_luminance;
import package::lookup::lookup_trust;
import package::types::{Neighbours, SurfelIrradiance, SurfelLight};

/// Reach of a neighbour, in radii: as far as depth functions know what stands between.
const SHARING_REACH: f32 = 2.0;
/// Neighbours count by their rays, up to so many.
const SHARING_MOST_RAYS: f32 = 4096.0;
/// Relative standard deviation of irradiance between neighbours that is assumed even where none shows.
const SHARING_LEAST_SPREAD: f32 = 0.03;
/// Relative standard error of its mean below which a surfel does not ask its neighbours.
const SHARING_CERTAIN: f32 = 0.015;
/// Rays before which no standard error is believed.
const SHARING_UNCERTAIN_BEFORE: u32 = 256u;

/// Variance of the luminance of a surfel's long mean, W^2/m^4.
fn sharing_mean_variance(state: SurfelIrradiance) -> f32 {
    return state.variance / f32(max(state.samples, 1u));
}

/// Whether a surfel is uncertain enough to ask its neighbours.
fn sharing_asks(state: SurfelIrradiance) -> bool {
    let level = estimator_luminance(state.mean);
    return state.samples < SHARING_UNCERTAIN_BEFORE
        || sharing_mean_variance(state) > SHARING_CERTAIN * SHARING_CERTAIN * level * level;
}

/// What a surfel says, from its own irradiance and what its neighbours say.
fn sharing_light(state: SurfelIrradiance, age: u32, neighbours: Neighbours) -> SurfelLight {
    let own = lookup_trust(age);
    if neighbours.trust == 0.0 {
        return SurfelLight(state.mean, select(0.0, own, state.samples > 0u));
    }
    if state.samples == 0u {
        return SurfelLight(neighbours.mean, neighbours.trust);
    }
    let noise = neighbours.ray_variance / f32(state.samples);
    let level = SHARING_LEAST_SPREAD * estimator_luminance(neighbours.mean);
    let total = noise + neighbours.spread + level * level;
    var share = 0.0;
    if total > 0.0 {
        share = noise / total;
    }
    return SurfelLight(
        state.mean + (neighbours.mean - state.mean) * share,
        own + (neighbours.trust - own) * share,
    );
}
