// Bounds of surfels in the grid's lists: one word each, from which a lookup tells, without loading the surfel, that it is
// too far from a point. Where the centre is in steps of a 128th of the cells' width, modulo 256 along each axis, and the
// radius in steps, a byte each. Surfels far off may pass for near ones, never the other way round.
import package::types::GridShape;

/// Steps across a cell.
const BOUNDS_STEPS: f32 = 128.0;
/// Bits of a coordinate.
const BOUNDS_BITS: u32 = 8u;
/// Steps that are as good as any more: surfels that reach so far always pass.
const BOUNDS_FAR: u32 = 127u;
/// Steps that rounding can add to a distance.
const BOUNDS_MARGIN: u32 = 2u;
/// Farthest coordinate that is told apart from its neighbours, steps.
const BOUNDS_FARTHEST: f32 = 262144.0;

/// Steps in a metre, for a cell.
fn bounds_steps_in(cell: u32, shape: GridShape) -> f32 {
    let in_cube = BOUNDS_STEPS * 0.5 * f32(shape.side) / shape.half;
    let slice = max(shape.side * shape.side, 1u);
    if cell < slice * shape.side {
        return in_cube;
    }
    let octaves = f32((cell - slice * shape.side) / slice % max(shape.slices, 1u) + 1u) / shape.per_octave;
    return in_cube * bitcast<f32>(u32((127.0 - octaves) * 8388608.0));
}

fn bounds_step(x: f32) -> u32 {
    return u32(i32(floor(x))) & ((1u << BOUNDS_BITS) - 1u);
}

/// Where a point is, relative to the grid's centre, as a lookup compares it with bounds.
fn bounds_place(from_centre: vec3<f32>, steps: f32) -> u32 {
    let at = from_centre * steps;
    return bounds_step(at.x) | (bounds_step(at.y) << BOUNDS_BITS) | (bounds_step(at.z) << (2u * BOUNDS_BITS));
}

/// The bounds of a surfel in the list of a cell.
fn bounds_pack(from_centre: vec3<f32>, radius: f32, steps: f32) -> u32 {
    let within = u32(min(radius * steps, f32(BOUNDS_FAR) - 1.0)) + 1u;
    let a = abs(from_centre);
    let far = max(max(a.x, a.y), a.z) * steps > BOUNDS_FARTHEST;
    return bounds_place(from_centre, steps) | (select(within, BOUNDS_FAR, far) << (3u * BOUNDS_BITS));
}

/// Whether a surfel may reach a point with `reach` times its radius. False only where it does not.
fn bounds_may_reach(bounds: u32, place: u32, reach: u32) -> bool {
    let above = 32u - BOUNDS_BITS;
    let shifts = vec3<u32>(above, above - BOUNDS_BITS, above - 2u * BOUNDS_BITS);
    // What lies below a coordinate is cut off from both, so that the shift to the right is exact.
    let highest = vec3<u32>(~((1u << above) - 1u));
    let lower = (vec3<u32>(place) << shifts) & highest;
    let upper = (vec3<u32>(bounds) << shifts) & highest;
    let apart = abs(bitcast<vec3<i32>>(upper - lower) >> vec3<u32>(above));
    let d = min(vec3<u32>(apart), vec3<u32>(BOUNDS_FAR));
    let most = min((bounds >> (3u * BOUNDS_BITS)) * reach + BOUNDS_MARGIN, BOUNDS_FAR);
    return most == BOUNDS_FAR || d.x * d.x + d.y * d.y + d.z * d.z <= most * most;
}
