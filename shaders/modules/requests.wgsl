// How many rays a surfel would like, in units of what a settled one gets.
import package::estimator::estimator_luminance;
import package::types::SurfelIrradiance;

/// Rays that a surfel integrates before it counts as settled.
const REQUESTS_FRESH: u32 = 128u;
/// Most units.
const REQUESTS_MOST: u32 = 32u;
/// Units of a surfel that has not settled where nothing steers.
const REQUESTS_UNSTEERED_FRESH: u32 = 4u;
/// Relative standard error of its irradiance at which a surfel asks for the most.
const REQUESTS_ERROR: f32 = 0.4;
/// Frames unseen from which on a surfel asks for a quarter.
const REQUESTS_UNSEEN: u32 = 4u;

/// Units that a surfel asks for, which no pixel has seen for so many frames. With `steered`, its variance decides.
fn requests_request(state: SurfelIrradiance, unseen: u32, steered: bool) -> u32 {
    let fresh = state.samples < REQUESTS_FRESH;
    if !steered {
        return select(1u, REQUESTS_UNSTEERED_FRESH, fresh);
    }
    var units = REQUESTS_MOST;
    if !fresh {
        let error = sqrt(state.variance / f32(state.samples));
        let level = max(estimator_luminance(state.mean), estimator_luminance(state.short_mean));
        var relative = 0.0;
        if level > 0.0 {
            relative = error / level;
        }
        units = u32(clamp(relative * (f32(REQUESTS_MOST) / REQUESTS_ERROR), 1.0, f32(REQUESTS_MOST)));
    }
    if unseen > REQUESTS_UNSEEN {
        return max(units / 4u, 1u);
    }
    return units;
}
