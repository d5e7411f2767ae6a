// The order of the grid's lists. Reads the stage's global `poses`.
import package::hash::hash_pcg;

/// Whether a surfel stands before another one in a list: by a hash of identity, then by slot.
fn list_is_before(id: u32, other: u32) -> bool {
    let own = hash_pcg(poses[id].identity);
    let others = hash_pcg(poses[other].identity);
    return own < others || (own == others && id < other);
}
