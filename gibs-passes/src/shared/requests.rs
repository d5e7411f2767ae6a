//! How many rays a surfel would like (GIBS, "Global Ray Budget"), in units of what a settled one gets.
use super::estimator::luminance;
use crate::data::SurfelIrradiance;

/// Rays that a surfel integrates before it counts as settled.
pub const FRESH: u32 = 128;

/// Most units.
pub const MOST: u32 = 32;

/// Units of a surfel that has not settled where nothing steers.
pub const UNSTEERED_FRESH: u32 = 4;

/// Relative standard error of its irradiance at which a surfel asks for the most.
pub const ERROR: f32 = 0.4;

/// Frames unseen after which a surfel asks for a quarter.
pub const UNSEEN: u32 = 4;

/// Units that a surfel asks for, which no pixel has seen for so many frames. With `steered`, its variance decides.
#[inline]
pub fn request(state: &SurfelIrradiance, unseen: u32, steered: bool) -> u32 {
    let fresh = state.samples < FRESH;
    if !steered {
        return if fresh { UNSTEERED_FRESH } else { 1 };
    }
    let units = if fresh {
        MOST
    } else {
        let error = (state.variance / state.samples as f32).sqrt();
        let level = luminance(state.mean).max(luminance(state.short_mean));
        let relative = if level > 0.0 { error / level } else { 0.0 };
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
        let ask = |mean, deviation, samples| request(&state(mean, deviation, samples), 0, true);
        assert_eq!(ask(1.0, 0.5, 10), MOST);
        // A relative error of 0.4, of 0.2, of next to none.
        assert_eq!(ask(1.0, 4.0, 100), MOST);
        assert_eq!(ask(1.0, 4.0, 400), MOST / 2);
        assert_eq!(ask(1.0, 1.0, 100_000), 1);
        assert_eq!(ask(0.0, 0.0, 1000), 1);
    }

    /// Scaling all lights by a power of two changes nothing, and what nobody sees asks for a quarter.
    #[test]
    fn only_what_is_relative_and_seen_counts() {
        let one = state(0.3, 0.7, 500);
        let many = state(0.3 * 1024.0, 0.7 * 1024.0, 500);
        assert_eq!(request(&one, 0, true), request(&many, 0, true));
        assert_eq!(request(&one, 100, true), request(&one, 0, true) / 4);
        assert_eq!(request(&one, 100, false), 1);
    }
}
