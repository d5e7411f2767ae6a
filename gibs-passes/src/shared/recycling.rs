//! When surfels give up their slots (GIBS, "Recycling").

/// Share of slots in use up to which nothing presses.
pub const EASE: f32 = 0.5;

/// Frames unseen before a surfel may go while nothing presses: what is seen again at once stays.
pub const PATIENCE: u32 = 16;

/// The same when all slots are in use: at half resolution, a pixel's surfels are known to be seen only every fourth frame.
pub const LEAST_PATIENCE: u32 = 5;

/// In place of the frames unseen of a surfel that goes before the next frame.
pub const CHOSEN: u32 = u32::MAX;

/// Frames unseen, one later.
#[inline]
pub fn one_more(unseen: u32) -> u32 {
    unseen.wrapping_add(1).min(CHOSEN - 1)
}

/// Chance per frame of an unseen surfel, while nothing presses: one in twenty seconds goes, at sixty frames a second.
pub const CALM: f32 = 1.0 / 1200.0;

/// Chance per frame of an unseen surfel when all slots are in use.
pub const PRESSED: f32 = 1.0 / 4.0;

/// Distance, over the half size of the grid's centre cube, at which an unseen surfel goes twice as soon as one close by.
pub const FAR: f32 = 32.0;

/// Coverage by others, over the coverage at which spawning stops, from which on a surfel is one too many, while nothing
/// presses.
pub const CROWDED: f32 = 4.0;

/// The same when all slots are in use: there are gaps then that no surfel is left for.
pub const CROWDED_PRESSED: f32 = 1.0;

/// Frames in one of which a surfel looks around for a crowd, since looking costs a lookup.
pub const LOOKS_EVERY: u32 = 8;

/// Chance of a surfel that looks and sees a crowd of twice that, or more. All of a crowd do not look in the same frame, so
/// that it thins out over some and does not vanish at once.
pub const THINNING: f32 = 0.5;

/// Whether a surfel looks around for a crowd in a frame.
#[inline]
pub fn looks(identity: u32, frame: u32) -> bool {
    identity.wrapping_add(frame).is_multiple_of(LOOKS_EVERY)
}

/// Chance that a surfel goes before the next frame: `used` is the share of slots in use, `unseen` the frames since a pixel saw it,
/// `distance` that to the eye over the half size of the centre cube, `others` what other surfels cover its place, over
/// the coverage at which spawning stops, 0 where it does not look.
#[inline]
pub fn chance(used: f32, unseen: u32, distance: f32, others: f32) -> f32 {
    let pressure = ((used - EASE) / (1.0 - EASE)).clamp(0.0, 1.0);
    let squared = pressure * pressure;
    let fourth = squared * squared;
    let limit = CROWDED + (CROWDED_PRESSED - CROWDED) * fourth;
    let crowd = ((others - limit) / limit).clamp(0.0, 1.0) * THINNING;
    let patience = PATIENCE as f32 - (PATIENCE - LEAST_PATIENCE) as f32 * pressure;
    if (unseen as f32) < patience {
        return crowd;
    }
    let away = CALM + (PRESSED - CALM) * fourth;
    let farther = 1.0 + distance / (distance + FAR);
    (away * farther).max(crowd)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_seen_and_not_crowded_stays() {
        for (used, least, crowded) in [
            (0.0, PATIENCE, CROWDED),
            (0.5, PATIENCE, CROWDED),
            (1.0, LEAST_PATIENCE, CROWDED_PRESSED),
        ] {
            for distance in [0.0, 1.0, 1e6] {
                assert_eq!(chance(used, least - 1, distance, crowded), 0.0);
                assert!(chance(used, least, distance, 0.0) > 0.0);
            }
        }
    }

    #[test]
    fn no_surfel_is_chosen_by_being_unseen_for_long() {
        assert_eq!(one_more(0), 1);
        assert_eq!(one_more(CHOSEN - 2), CHOSEN - 1);
        assert_eq!(one_more(CHOSEN - 1), CHOSEN - 1);
    }

    #[test]
    fn the_chance_grows_with_each_cause() {
        let base = chance(0.6, 100, 10.0, 0.0);
        assert!(chance(0.9, 100, 10.0, 0.0) > base, "fewer free slots");
        assert!(chance(0.6, 100, 20.0, 0.0) > base, "farther away");
        assert!(chance(0.6, 100, 10.0, 100.0) > base, "crowded");
        assert_eq!(
            chance(0.0, 0, 0.0, 3.0),
            0.0,
            "not crowded while there is room"
        );
        assert!(
            chance(1.0, 0, 0.0, 1.5) > 0.0,
            "crowded where there is none"
        );
        assert!(chance(0.6, LEAST_PATIENCE, 10.0, 0.0) < base, "just seen");
    }

    #[test]
    fn the_chance_is_one_at_every_extreme() {
        for used in [0.0, 1.0] {
            for unseen in [0, PATIENCE, u32::MAX] {
                for distance in [0.0, 1e30] {
                    for others in [-2.0, 0.0, 1e30] {
                        assert!((0.0..=1.0).contains(&chance(used, unseen, distance, others)));
                    }
                }
            }
        }
    }
}
