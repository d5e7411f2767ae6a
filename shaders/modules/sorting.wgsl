// Ray sorting (GIBS, "Ray Sorting"): rays that begin near each other and go the same way, one after the other.
import package::grid::grid_cell;
import package::octahedral::octahedral_encode;
import package::types::GridShape;

/// Bits of a bin that tell where a ray begins.
const SORTING_SPATIAL_BITS: u32 = 12u;
/// Bits of a bin that tell where it goes.
const SORTING_DIRECTION_BITS: u32 = 4u;
/// Number of bins.
const SORTING_BINS: u32 = 65536u;

/// The part of a bin that all rays of a surfel share: its cell.
fn sorting_place(position: vec3<f32>, grid: GridShape) -> u32 {
    let cell = grid_cell(position, grid) & ((1u << SORTING_SPATIAL_BITS) - 1u);
    return cell << SORTING_DIRECTION_BITS;
}

/// The bin of a ray from a place: directions are told apart by 4x4 parts of the octahedral map.
fn sorting_bin(place: u32, direction: vec3<f32>) -> u32 {
    let p = octahedral_encode(direction);
    let at = vec2<u32>(clamp((p * 0.5 + 0.5) * 4.0, vec2<f32>(0.0), vec2<f32>(3.0)));
    return place + at.y * 4u + at.x;
}
