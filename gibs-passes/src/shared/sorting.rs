//! Ray sorting (GIBS, "Ray Sorting"): rays that begin near each other and go the same way, one after the other.
use super::{grid, octahedral};
use crate::data::GridShape;
use glam::Vec3;

/// Bits of a bin that tell where a ray begins.
pub const SPATIAL_BITS: u32 = 12;
/// Bits of a bin that tell where it goes.
pub const DIRECTION_BITS: u32 = 4;
/// Number of bins.
pub const BINS: u32 = 1 << (SPATIAL_BITS + DIRECTION_BITS);

/// The part of a bin that all rays of a surfel share: its cell. Cells that are far apart share one.
#[inline]
pub fn place(position: Vec3, grid: &GridShape) -> u32 {
    let cell = grid::cell(position, grid) & ((1 << SPATIAL_BITS) - 1);
    cell << DIRECTION_BITS
}

/// The bin of a ray from a place: directions are told apart by 4x4 parts of the octahedral map.
#[inline]
pub fn bin(place: u32, direction: Vec3) -> u32 {
    let at = |x: f32| ((x * 0.5 + 0.5) * 4.0).clamp(0.0, 3.0) as u32;
    let p = octahedral::encode(direction);
    place + at(p.y) * 4 + at(p.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::grid::GridLayout;
    use crate::shared::hash::{hash2, unit};

    /// Every ray has a bin of its place, and all bins of a place are met.
    #[test]
    fn bins_hold_a_place_and_a_direction() {
        let grid = GridLayout::new(16, 100.0).at(Vec3::ZERO, 2.0);
        let mut met = [false; 1 << DIRECTION_BITS];
        for i in 0..2000 {
            let random = |k| unit(hash2(i, k)) * 2.0 - 1.0;
            let position = Vec3::new(random(0), random(1), random(2)) * 300.0;
            let direction = Vec3::new(random(3), random(4), random(5));
            let direction = direction.try_normalize().unwrap_or(Vec3::Z);
            let place = place(position, &grid);
            let bin = bin(place, direction);
            assert_eq!(bin >> DIRECTION_BITS, place >> DIRECTION_BITS);
            assert!(bin < BINS);
            met[(bin - place) as usize] = true;
        }
        assert_eq!(met, [true; 1 << DIRECTION_BITS]);
    }
}
