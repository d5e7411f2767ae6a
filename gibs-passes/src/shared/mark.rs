//! What a surfel's mark says: who it is, in which plane it lies, and whether lookups need its depth function.
use super::plane;

/// Set where the depth function hides nothing within the radius, which is where lookups ask: so it is for nine in ten of the
/// surfels that count at a point of Sponza, and lookups do not load theirs. `positional_update` sets it once a frame.
pub const OPEN: u32 = 1 << 31;

/// A mask of the bits of an identity.
pub const IDENTITY: u32 = (OPEN >> plane::BITS) - 1;

/// Hash of where and when the surfel was born, 15 bits: of a few dozen around a point, it is one time in twenty that two have the
/// same, whose rays then take the same directions about their normals.
#[inline]
pub fn identity(mark: u32) -> u32 {
    mark >> plane::BITS & IDENTITY
}

/// Whether its depth function hides nothing within its radius.
#[inline]
pub fn is_open(mark: u32) -> bool {
    mark & OPEN != 0
}

/// The mark of an identity, of which the low 15 bits count, and a [`plane`], which is read from the mark as it is.
#[inline]
pub fn of(identity: u32, plane: u32, open: bool) -> u32 {
    let plane = plane & ((1 << plane::BITS) - 1);
    plane | (identity & IDENTITY) << plane::BITS | if open { OPEN } else { 0 }
}
