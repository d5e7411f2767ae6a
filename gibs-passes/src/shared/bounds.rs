//! Bounds of surfels in the grid's lists: one word each, from which a lookup tells, without loading the surfel, that it
//! is too far from a point. Most surfels of a cell are.
//!
//! A word holds where the surfel's centre is, in steps of a 128th of the cells' width, modulo 512 along each axis, and
//! its radius in pairs of steps. A difference modulo 512 is the true one wherever that is short enough for the surfel to
//! reach; surfels farther off may pass for near ones, never the other way round.
use crate::data::GridShape;
use glam::Vec3;

/// Steps across a cell.
const STEPS: f32 = 128.0;

/// Bits of a coordinate.
pub const BITS: u32 = 9;

/// Where the radius begins.
pub const RADIUS_AT: u32 = 3 * BITS;

/// Radius of surfels that always pass: those of more than 60 steps, and those so far out that steps are lost in rounding.
pub const ALWAYS: u32 = 31;

/// Steps that rounding can add to a distance: up to one along each axis, a little more in the farthest cells.
pub const MARGIN: u32 = 2;

/// Farthest coordinate that is told apart from its neighbours, steps.
const FARTHEST: f32 = 262_144.0;

/// Steps in a metre, for cells of the centre cube.
#[inline]
pub fn steps_in_cube(grid: &GridShape) -> f32 {
    STEPS * 0.5 * grid.side as f32 / grid.half
}

/// Steps in a metre, for cells of a slice: at least as many as fit its outer face. The power of two is linear between
/// whole exponents, which every backend computes to the same bits.
#[inline]
pub fn steps_in_slice(slice: u32, grid: &GridShape) -> f32 {
    let octaves = (slice + 1) as f32 / grid.per_octave;
    steps_in_cube(grid) * f32::from_bits(((127.0 - octaves) * 8_388_608.0) as u32)
}

/// Steps in a metre, for a cell. No grid that somebody has written is without cells.
#[inline]
pub fn steps_in(cell: u32, grid: &GridShape) -> f32 {
    let slice = (grid.side * grid.side).max(1);
    match cell.checked_sub(slice * grid.side) {
        None => steps_in_cube(grid),
        Some(beyond) => steps_in_slice(beyond / slice % grid.slices.max(1), grid),
    }
}

/// `x` rounded down, modulo 512.
#[inline]
fn step(x: f32) -> u32 {
    let towards_zero = x as i32;
    let below = towards_zero.wrapping_sub(i32::from(x < towards_zero as f32));
    below as u32 & ((1 << BITS) - 1)
}

/// Where a point is, relative to the grid's centre, as a lookup compares it with bounds.
#[inline]
pub fn place(from_centre: Vec3, steps: f32) -> u32 {
    let at = from_centre * steps;
    step(at.x) | step(at.y) << BITS | step(at.z) << (2 * BITS)
}

/// The bounds of a surfel in the list of a cell.
#[inline]
pub fn pack(from_centre: Vec3, radius: f32, steps: f32) -> u32 {
    let pairs = (radius * steps * 0.5).min(ALWAYS as f32 - 1.0) as u32 + 1;
    let far = from_centre.abs().max_element() * steps > FARTHEST;
    let radius = if far { ALWAYS } else { pairs };
    place(from_centre, steps) | radius << RADIUS_AT
}

/// Whether a surfel may reach a point with `reach` times its radius. False only where it does not.
#[inline]
pub fn may_reach(bounds: u32, place: u32, reach: u32) -> bool {
    let apart = |shift: u32| {
        let d = (bounds << shift).wrapping_sub((place << shift) & !((1 << (32 - BITS)) - 1));
        d as i32 >> (32 - BITS)
    };
    let d = [apart(23), apart(14), apart(5)];
    let pairs = bounds >> RADIUS_AT;
    let most = (pairs * 2 * reach + MARGIN) as i32;
    pairs == ALWAYS || d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= most * most
}

#[cfg(test)]
mod tests;
