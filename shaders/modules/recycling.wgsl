// When surfels give up their slots (GIBS, "Recycling").

/// Share of slots in use up to which nothing presses.
const RECYCLING_EASE: f32 = 0.5;
/// Frames unseen before a surfel may go while nothing presses.
const RECYCLING_PATIENCE: u32 = 16u;
/// The same when all slots are in use.
const RECYCLING_LEAST_PATIENCE: u32 = 5u;
/// In place of the frames unseen of a surfel that goes before the next frame.
const RECYCLING_CHOSEN: u32 = 0xffffffffu;
/// Chance per frame of an unseen surfel, while nothing presses.
const RECYCLING_CALM: f32 = 1.0 / 1200.0;
/// Chance per frame of an unseen surfel when all slots are in use.
const RECYCLING_PRESSED: f32 = 1.0 / 4.0;
/// Distance, over the half size of the grid's centre cube, at which an unseen surfel goes twice as soon as one close by.
const RECYCLING_FAR: f32 = 32.0;
/// Coverage by others, over the coverage at which spawning stops, from which on a surfel is one too many.
const RECYCLING_CROWDED: f32 = 4.0;
/// The same when all slots are in use.
const RECYCLING_CROWDED_PRESSED: f32 = 1.0;
/// Chance per frame of a surfel in a crowd of twice that, or more.
const RECYCLING_THINNING: f32 = 0.5;
/// Frames in one of which a surfel looks around for a crowd.
const RECYCLING_LOOKS_EVERY: u32 = 8u;

/// Frames unseen, one later.
fn recycling_one_more(unseen: u32) -> u32 {
    return min(unseen + 1u, RECYCLING_CHOSEN - 1u);
}

/// Whether a surfel looks around for a crowd in a frame.
fn recycling_looks(identity: u32, frame: u32) -> bool {
    return (identity + frame) % RECYCLING_LOOKS_EVERY == 0u;
}

/// Chance that a surfel goes before the next frame.
fn recycling_chance(used: f32, unseen: u32, distance: f32, others: f32) -> f32 {
    let pressure = clamp((used - RECYCLING_EASE) / (1.0 - RECYCLING_EASE), 0.0, 1.0);
    let squared = pressure * pressure;
    let fourth = squared * squared;
    let limit = RECYCLING_CROWDED + (RECYCLING_CROWDED_PRESSED - RECYCLING_CROWDED) * fourth;
    let crowd = clamp((others - limit) / limit, 0.0, 1.0) * RECYCLING_THINNING;
    let patience = f32(RECYCLING_PATIENCE) - f32(RECYCLING_PATIENCE - RECYCLING_LEAST_PATIENCE) * pressure;
    if f32(unseen) < patience {
        return crowd;
    }
    let away = RECYCLING_CALM + (RECYCLING_PRESSED - RECYCLING_CALM) * fourth;
    let farther = 1.0 + distance / (distance + RECYCLING_FAR);
    return max(away * farther, crowd);
}
