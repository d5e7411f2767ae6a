// Summed weight of surfels. Reads the stage's globals `cells`, `entries`, `poses`, `grid` and `settings`, `depths` only
// where the stage binds it, and calls the stage's function `coverage_seen` with each surfel that has any weight.
import package::bounds::{bounds_may_reach, bounds_place, bounds_steps_in};
@if(depths) import package::depth::depth_visibility;
import package::grid::grid_cell;
import package::lookup::{lookup_alignment, lookup_falloff};
@if(depths) import package::mark::mark_is_open;
import package::types::SurfelPose;

@if(depths)
fn coverage_share(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    if mark_is_open(pose.mark) {
        return 1.0;
    }
    return depth_visibility(id, pose, d);
}
@else
fn coverage_share(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    return 1.0;
}

/// Summed weight of the surfels at a point: the same weights as `lookup_gather`.
fn lookup_coverage(point: vec3<f32>, normal: vec3<f32>) -> f32 {
    let at = grid_cell(point, grid);
    let cell = cells[at];
    let count = min(cell.y, settings.lookup);
    let place = bounds_place(point - grid.centre, bounds_steps_in(at, grid));
    var sum = 0.0;
    for (var i = 0u; i < count; i++) {
        if !bounds_may_reach(entries[cell.x + cell.y + i], place, 1u) {
            continue;
        }
        let id = entries[cell.x + i];
        let pose = poses[id];
        let d = point - pose.position;
        var weight = lookup_falloff(d, pose) * lookup_alignment(normal, pose);
        if weight > 0.0 {
            weight *= coverage_share(id, pose, d);
        }
        sum += weight;
        if weight > 0.0 {
            coverage_seen(id);
        }
    }
    return sum;
}
