// Irradiance from the surfels around a point. Reads the stage's globals `cells`, `entries`, `poses`, `depths`,
// `irradiance`, `grid` and `settings`.
import package::depth::depth_visibility;
import package::grid::grid_cell;
import package::lookup::{lookup_alignment, lookup_falloff};
import package::types::Gathered;

/// Irradiance at a point from the surfels in its cell that have integrated any rays.
fn lookup_gather(point: vec3<f32>, normal: vec3<f32>) -> Gathered {
    let cell = cells[grid_cell(point, grid)];
    let count = min(cell.y, settings.lookup);
    var g: Gathered;
    for (var i = 0u; i < count; i++) {
        let id = entries[cell.x + i];
        let pose = poses[id];
        let aligned = lookup_alignment(normal, pose);
        if aligned <= 0.0 || irradiance[id].samples == 0u {
            continue;
        }
        let d = point - pose.position;
        var broad = aligned;
        if settings.use_depth != 0u {
            broad *= depth_visibility(id, pose, d);
        }
        let weight = broad * lookup_falloff(d, pose);
        let mean = irradiance[id].mean;
        g.irradiance += mean * weight;
        g.weight += weight;
        g.average += mean * broad;
        g.average_weight += broad;
    }
    if g.weight > 1.0 {
        g.irradiance /= g.weight;
        g.weight = 1.0;
    }
    if g.average_weight > 0.0 {
        g.average /= g.average_weight;
    }
    return g;
}
