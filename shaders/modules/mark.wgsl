// What a surfel's mark says: who it is, in which plane it lies, and whether lookups need its depth function.

/// Set where the depth function hides nothing within the radius.
const MARK_OPEN: u32 = 0x80000000u;

/// Bits of a plane, below the identity.
const MARK_PLANE_BITS: u32 = 16u;

/// A mask of the bits of an identity.
const MARK_IDENTITY: u32 = 0x7fffu;

/// Hash of where and when the surfel was born, 15 bits.
fn mark_identity(mark: u32) -> u32 {
    return (mark >> MARK_PLANE_BITS) & MARK_IDENTITY;
}

/// Whether its depth function hides nothing within its radius.
fn mark_is_open(mark: u32) -> bool {
    return (mark & MARK_OPEN) != 0u;
}

/// The mark of an identity, of which the low 15 bits count, and a plane, which is read from the mark as it is.
fn mark_of(identity: u32, plane: u32, open: bool) -> u32 {
    return select(0u, MARK_OPEN, open) | ((identity & MARK_IDENTITY) << MARK_PLANE_BITS) | (plane & 0xffffu);
}
