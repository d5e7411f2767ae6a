// Size of surfels.
import package::grid::{GRID_RADIUS_SHARE, grid_cell_side};
import package::types::{Camera, GridShape, SurfelSettings};
import package::vector::vector_length;

/// Marks a place among the hits of rays, where others are pixels.
const SURFEL_AT_HIT: u32 = 0x80000000u;
/// Least radius of a surfel beside a wall, over what it would be in the open.
const SURFEL_LEAST_SHARE: f32 = 0.25;
/// Age, in frames, up to which a surfel shrinks where surfaces are close.
const SURFEL_LEARNS_FOR: u32 = 32u;
/// Growth in a frame beyond which a surfel learns no more.
const SURFEL_LEARNS_UP_TO: f32 = 1.03125;
/// What is left of the radius of a surfel that is too large for where it is, in a frame.
const SURFEL_SHRINKS_TO: f32 = 0.5;

/// Radius whose projection is `radius_pixels` at this distance from the eye, within what the grid allows and the surfel's
/// surroundings ask for, metres.
fn surfel_radius_at(
    position: vec3<f32>,
    clearance: f32,
    camera: Camera,
    shape: GridShape,
    settings: SurfelSettings,
) -> f32 {
    let projected = settings.radius_pixels * camera.pixel_angle * vector_length(position - camera.eye);
    let most = grid_cell_side(position, shape) * GRID_RADIUS_SHARE;
    // Never zero, which means a free slot, not even where the eye is.
    let wanted = clamp(projected, 1e-4 * most, most);
    return min(wanted, max(clearance, SURFEL_LEAST_SHARE * wanted));
}
