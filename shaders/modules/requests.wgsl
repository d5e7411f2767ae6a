// How many rays a surfel would like, in units of what a settled one gets.
import package::estimator::estimator_luminance;
import package::types::SurfelIrradiance;

/// Rays before which a surfel's own variance is not believed.
const REQUESTS_FRESH: u32 = 128u;
/// Rays before which that of its neighbours is not believed.
const REQUESTS_FRESH_AMONG_NEIGHBOURS: u32 = 24u;
/// Rays from which on a surfel's own variance counts where it is larger than its neighbours'.
const REQUESTS_LEARNED: u32 = 512u;
/// Units of a surfel that begins anew after its light has changed.
const REQUESTS_ANEW: u32 = 32u;
/// Most units.
const REQUESTS_MOST: u32 = 128u;
/// Units of a surfel that has not settled where nothing steers.
const REQUESTS_UNSTEERED_FRESH: u32 = 4u;
/// Relative standard error of its irradiance at which a surfel asks for the most.
const REQUESTS_ERROR: f32 = 1.6;
/// Frames unseen from which on a surfel asks for a quarter.
const REQUESTS_UNSEEN: u32 = 4u;

/// Units that a surfel asks for, which no pixel has seen for so many frames. With `steered`, the variance of its rays decides: that
/// which its neighbours have found, `said`, or that of its own where this is 0, or less and the surfel has learned
/// enough.
fn requests_request(state: SurfelIrradiance, said: f32, unseen: u32, steered: bool) -> u32 {
    if !steered {
        return select(1u, REQUESTS_UNSTEERED_FRESH, state.samples < REQUESTS_FRESH);
    }
    let samples = f32(state.samples);
    var relative = sqrt(said / samples);
    if said == 0.0 || state.samples >= REQUESTS_LEARNED {
        let error = sqrt(state.variance / samples);
        let level = max(estimator_luminance(state.mean), estimator_luminance(state.short_mean));
        if level > 0.0 {
            relative = max(relative, error / level);
        }
    }
    let fresh = select(REQUESTS_FRESH, REQUESTS_FRESH_AMONG_NEIGHBOURS, said > 0.0);
    var units = select(REQUESTS_MOST, REQUESTS_ANEW, state.drawn > state.samples);
    if state.samples >= fresh {
        units = u32(clamp(relative * (f32(REQUESTS_MOST) / REQUESTS_ERROR), 1.0, f32(REQUESTS_MOST)));
    }
    if unseen > REQUESTS_UNSEEN {
        return max(units / 4u, 1u);
    }
    return units;
}
