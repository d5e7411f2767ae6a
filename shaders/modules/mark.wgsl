// What a surfel's mark says: who it is, and whether lookups need its depth function.

/// Set where the depth function hides nothing within the radius.
const MARK_OPEN: u32 = 0x80000000u;

/// Hash of where and when the surfel was born, 31 bits.
fn mark_identity(mark: u32) -> u32 {
    return mark & ~MARK_OPEN;
}

/// Whether its depth function hides nothing within its radius.
fn mark_is_open(mark: u32) -> bool {
    return (mark & MARK_OPEN) != 0u;
}

/// The mark of an identity, whose highest bit does not count.
fn mark_of(identity: u32, open: bool) -> u32 {
    return select(0u, MARK_OPEN, open) | (identity & ~MARK_OPEN);
}
