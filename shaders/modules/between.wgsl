// Pixels between the selected ones. Reads the stage's globals `camera`, `points` and `selected`.
import package::surface::surface_is_surface;

/// A pixel lies in the picture, sees a surface and was not selected.
fn between_is_open(at: vec2<u32>) -> bool {
    let i = at.y * camera.width + at.x;
    return at.x < camera.width && at.y < camera.height && selected[i] == 0u && surface_is_surface(points[i]);
}
