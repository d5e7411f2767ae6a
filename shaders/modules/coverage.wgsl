// Summed weight of surfels. Reads the stage's globals `cells`, `entries`, `poses`, `depths`, `grid` and `settings`, and
// calls the stage's function `coverage_seen` with each surfel that has any weight.
import package::depth::depth_visibility;
import package::grid::grid_cell;
import package::lookup::{lookup_alignment, lookup_falloff};

/// Summed weight of the surfels at a point: the same weights as `lookup_gather`.
fn lookup_coverage(point: vec3<f32>, normal: vec3<f32>) -> f32 {
    let cell = cells[grid_cell(point, grid)];
    let count = min(cell.y, settings.lookup);
    var sum = 0.0;
    for (var i = 0u; i < count; i++) {
        let id = entries[cell.x + i];
        let pose = poses[id];
        let d = point - pose.position;
        var weight = lookup_falloff(d, pose) * lookup_alignment(normal, pose);
        if weight > 0.0 && settings.use_depth != 0u {
            weight *= depth_visibility(id, pose, d);
        }
        sum += weight;
        if weight > 0.0 {
            coverage_seen(id);
        }
    }
    return sum;
}
