// Size of surfels.
import package::grid::{GRID_RADIUS_SHARE, grid_cell_side};
import package::types::{Camera, GridShape, SurfelSettings};
import package::vector::vector_length;

/// Radius whose projection is `radius_pixels` at this distance from the eye, within what the grid allows, metres.
fn surfel_radius_at(position: vec3<f32>, camera: Camera, shape: GridShape, settings: SurfelSettings) -> f32 {
    let wanted = settings.radius_pixels * camera.pixel_angle * vector_length(position - camera.eye);
    let most = grid_cell_side(position, shape) * GRID_RADIUS_SHARE;
    // Never zero, which means a free slot, not even where the eye is.
    return clamp(wanted, 1e-4 * most, most);
}
