// What a surfel's mark says: who it is, in which plane it lies, and whether lookups need its depth function.

/// Set where the depth function hides nothing within the radius.
const MARK_OPEN: u32 = 0x80000000u;

/// Hash of where and when the surfel was born, 15 bits.
fn mark_identity(mark: u32) -> u32 {
    return (mark >> 16u) & 0x7fffu;
}

/// Whether its depth function hides nothing within its radius.
fn mark_is_open(mark: u32) -> bool {
    return (mark & MARK_OPEN) != 0u;
}

/// The mark of an identity, of which the low 15 bits count, and a plane, which is read from the mark as it is.
fn mark_of(identity: u32, plane: u32, open: bool) -> u32 {
    return select(0u, MARK_OPEN, open) | ((identity & 0x7fffu) << 16u) | (plane & 0xffffu);
}
