//! What a surfel's mark says: who it is, and whether lookups need its depth function.

/// Set where the depth function hides nothing within the radius, which is where lookups ask: so it is for nine in ten of the
/// surfels that count at a point of Sponza, and lookups do not load theirs. `positional_update` sets it once a frame.
pub const OPEN: u32 = 1 << 31;

/// Hash of where and when the surfel was born, 31 bits.
#[inline]
pub fn identity(mark: u32) -> u32 {
    mark & !OPEN
}

/// Whether its depth function hides nothing within its radius.
#[inline]
pub fn is_open(mark: u32) -> bool {
    mark & OPEN != 0
}

/// The mark of an identity, whose highest bit does not count.
#[inline]
pub fn of(identity: u32, open: bool) -> u32 {
    (identity & !OPEN) | if open { OPEN } else { 0 }
}
