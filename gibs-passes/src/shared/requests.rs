//! How many rays a surfel would like (GIBS, "Global Ray Budget"), in units of what a settled one gets.
use super::estimator::luminance;
use crate::data::SurfelIrradiance;
use glam::UVec2;

/// A surfel's rays, of its first and how many: the first, and the one after the last.
#[inline]
pub fn range(span: UVec2) -> (u32, u32) {
    (span.x, span.x + span.y)
}

/// Rays before which a surfel's own variance is not believed: what is rare may not have come yet.
pub const FRESH: u32 = 128;

/// Rays before which that of its neighbours is not believed.
pub const FRESH_AMONG_NEIGHBOURS: u32 = 24;

/// Rays from which on a surfel's own variance counts where it is larger than its neighbours': by then its luck is thin, and one in
/// a crevice is not left to those in the open.
pub const LEARNED: u32 = 512;

/// Units of a surfel that begins anew after its light has changed. With more, those that have noticed would take the rays of
/// those that have yet to.
pub const ANEW: u32 = 32;

/// Most units. Where one ray in a hundred finds light a surfel needs ten times the rays of one in the open.
pub const MOST: u32 = 128;

/// Units of a surfel that has not settled where nothing steers.
pub const UNSTEERED_FRESH: u32 = 4;

/// Relative standard error of its irradiance at which a surfel asks for the most.
pub const ERROR: f32 = 1.6;

/// Frames unseen after which a surfel asks for a quarter.
pub const UNSEEN: u32 = 4;

/// Units that a surfel asks for, which no pixel has seen for so many frames. With `steered`, the variance of its rays decides:
/// that which its neighbours have found, relative, `said` (see [`Said`](super::sharing::Said)), or that of its own where this is 0, or
/// less and the surfel has learned enough.
#[inline]
pub fn request(state: &SurfelIrradiance, said: f32, unseen: u32, steered: bool) -> u32 {
    if !steered {
        return if state.samples < FRESH {
            UNSTEERED_FRESH
        } else {
            1
        };
    }
    let samples = state.samples as f32;
    let mut relative = (said / samples).sqrt();
    if said == 0.0 || state.samples >= LEARNED {
        let error = (state.variance / samples).sqrt();
        let level = luminance(state.mean).max(luminance(state.short_mean));
        if level > 0.0 {
            relative = relative.max(error / level);
        }
    }
    let fresh = if said > 0.0 {
        FRESH_AMONG_NEIGHBOURS
    } else {
        FRESH
    };
    let units = if state.samples < fresh {
        if state.drawn > state.samples {
            ANEW
        } else {
            MOST
        }
    } else {
        (relative * (MOST as f32 / ERROR)).clamp(1.0, MOST as f32) as u32
    };
    if unseen > UNSEEN {
        (units / 4).max(1)
    } else {
        units
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn state(mean: f32, deviation: f32, samples: u32) -> SurfelIrradiance {
        SurfelIrradiance {
            mean: Vec3::splat(mean),
            short_mean: Vec3::splat(mean),
            variance: deviation * deviation,
            samples,
            ..SurfelIrradiance::default()
        }
    }

    #[test]
    fn new_and_uncertain_surfels_ask_for_more() {
        let ask =
            |mean, deviation, samples| request(&state(mean, deviation, samples), 0.0, 0, true);
        assert_eq!(ask(1.0, 0.5, 100), MOST);
        // A relative error of 1.6, of 0.8, of next to none.
        assert_eq!(ask(1.0, 32.0, 400), MOST);
        assert_eq!(ask(1.0, 16.0, 400), MOST / 2);
        assert_eq!(ask(1.0, 1.0, 100_000), 1);
        assert_eq!(ask(0.0, 0.0, 1000), 1);
    }

    /// With one ray in a hundred that finds light, most of the surfels that have had 24 rays have seen none, and would think
    /// that they know; those around know better.
    #[test]
    fn what_neighbours_have_found_counts_before_own_luck() {
        let unlucky = state(0.0, 0.0, 144);
        assert_eq!(request(&unlucky, 0.0, 0, true), 1);
        // A relative error of a twelfth of ten.
        let units = 10.0 / 12.0 * MOST as f32 / ERROR;
        assert_eq!(request(&unlucky, 100.0, 0, true), units as u32);
        // One that is noisier than they are is left to itself until its luck is thin.
        let noisy = |samples| request(&state(1.0, 16.0, samples), 1.0, 0, true);
        assert_eq!(noisy(400), (1.0 / 20.0 * MOST as f32 / ERROR) as u32);
        assert_eq!(noisy(1024), (0.5 * MOST as f32 / ERROR) as u32);
        let fresh = state(0.0, 0.0, FRESH_AMONG_NEIGHBOURS - 1);
        assert_eq!(request(&fresh, 1e-6, 0, true), MOST);
        let anew = SurfelIrradiance {
            drawn: 1000,
            ..fresh
        };
        assert_eq!(request(&anew, 1e-6, 0, true), ANEW);
        assert_eq!(request(&state(0.0, 0.0, 0), 0.0, 0, true), MOST);
    }

    /// Scaling all lights by a power of two changes nothing, and what nobody sees asks for a quarter.
    #[test]
    fn only_what_is_relative_and_seen_counts() {
        let one = state(0.3, 0.7, 500);
        let many = state(0.3 * 1024.0, 0.7 * 1024.0, 500);
        assert_eq!(request(&one, 0.0, 0, true), request(&many, 0.0, 0, true));
        assert_eq!(
            request(&one, 0.0, 100, true),
            request(&one, 0.0, 0, true) / 4
        );
        assert_eq!(request(&one, 0.0, 100, false), 1);
    }
}
