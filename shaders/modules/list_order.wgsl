// The order of the grid's lists. Reads the stage's global `poses`; `list_sort` writes its `entries`.
import package::hash::hash_pcg;
import package::mark::mark_identity;

/// What a surfel's place in a list goes by; equal ones stand in the order of their slots.
fn list_key(id: u32) -> u32 {
    return hash_pcg(mark_identity(poses[id].mark));
}

/// Whether a surfel with this key stands before another one in a list.
fn list_is_before(key: u32, id: u32, other: u32) -> bool {
    let others = list_key(other);
    return key < others || (key == others && id < other);
}

/// Puts `count` entries from `start` on in order. Shell sort: in place, and fast enough for lists of tens to hundreds.
fn list_sort(start: u32, count: u32) {
    for (var gap = count / 2u; gap > 0u; gap = gap / 2u) {
        for (var i = gap; i < count; i++) {
            let moving = entries[start + i];
            let key = list_key(moving);
            var j = i;
            while j >= gap {
                let other = entries[start + j - gap];
                if !list_is_before(key, moving, other) {
                    break;
                }
                entries[start + j] = other;
                j -= gap;
            }
            entries[start + j] = moving;
        }
    }
}
