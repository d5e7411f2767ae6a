//! Bounds of surfels in the grid's lists: one word each, from which a lookup tells, without loading the surfel, that it
//! is too far from a point. Most surfels of a cell are.
//!
//! A word holds where the surfel's centre is, in steps of a 128th of the cells' width, modulo 256 along each axis, and
//! its radius in steps: a byte each, so that a processor compares eight words with a dozen instructions for bytes. A
//! difference modulo 256 is the true one wherever that is short enough for the surfel to reach; surfels farther off may
//! pass for near ones, never the other way round.
use crate::data::GridShape;
use glam::Vec3;

/// Steps across a cell.
const STEPS: f32 = 128.0;

/// Bits of a coordinate.
pub const BITS: u32 = 8;

/// Where the radius begins.
pub const RADIUS_AT: u32 = 3 * BITS;

/// Steps that are as good as any more: surfels that reach so far always pass, and so do those so far out that steps are
/// lost in rounding.
pub const FAR: u32 = 127;

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

/// `x` rounded down, modulo 256.
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
    let within = (radius * steps).min(FAR as f32 - 1.0) as u32 + 1;
    let far = from_centre.abs().max_element() * steps > FARTHEST;
    let radius = if far { FAR } else { within };
    place(from_centre, steps) | radius << RADIUS_AT
}

/// Whether a surfel may reach a point with `reach` times its radius. False only where it does not.
#[inline]
pub fn may_reach(bounds: u32, place: u32, reach: u32) -> bool {
    let apart = |axis: u32| {
        let byte = |word: u32| (word >> (axis * BITS)) as u8;
        let d = byte(bounds).wrapping_sub(byte(place)).cast_signed();
        u32::from(d.unsigned_abs()).min(FAR)
    };
    let [x, y, z] = [apart(0), apart(1), apart(2)];
    let most = ((bounds >> RADIUS_AT) * reach + MARGIN).min(FAR);
    most == FAR || x * x + y * y + z * z <= most * most
}

#[cfg(test)]
mod tests;
