// Irradiance from the surfels around a point. Reads the stage's globals `cells`, `entries`, `poses`, `light`, `grid`
// and `settings`; `depths` only where the stage binds it.
import package::bounds::{bounds_may_reach, bounds_place, bounds_steps_in};
@if(depths) import package::depth::{depth_openness, depth_visibility};
import package::grid::grid_cell;
import package::lookup::{LOOKUP_AVERAGE_LEAST, LOOKUP_AVERAGE_OF, LOOKUP_LEAST_WEIGHT, lookup_alignment, lookup_falloff, lookup_leaning};
@if(depths) import package::mark::mark_is_open;
import package::types::{Gathered, SurfelPose};

@if(depths)
fn gather_share(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    if mark_is_open(pose.mark) {
        return 1.0;
    }
    return depth_visibility(id, pose, d);
}
@else
fn gather_share(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    return 1.0;
}

@if(depths)
fn gather_openness(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    return depth_openness(id, pose, d);
}
@else
fn gather_openness(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    return 1.0;
}

/// Irradiance at a point from the surfels in its cell that have integrated any rays, up to the one with which the summed
/// weight is `enough`, at least one. The cell's average, with normal and depth weights only, is found where the summed
/// weight is below one and it is wanted; what little of it is visible is filled up with `beyond`.
fn lookup_gather(point: vec3<f32>, normal: vec3<f32>, enough: f32, wants_average: bool, beyond: vec3<f32>) -> Gathered {
    let at = grid_cell(point, grid);
    let cell = cells[at];
    let count = min(cell.y, settings.lookup);
    let place = bounds_place(point - grid.centre, bounds_steps_in(at, grid));
    var g: Gathered;
    var total = 0.0;
    var first = 0.0;
    for (var i = 0u; i < count; i++) {
        if !bounds_may_reach(entries[cell.x + cell.y + i], place, 1u) {
            continue;
        }
        let id = entries[cell.x + i];
        let pose = poses[id];
        let d = point - pose.position;
        var weight = lookup_falloff(d, pose) * lookup_alignment(normal, pose);
        if weight <= 0.0 || light[id].trust == 0.0 {
            continue;
        }
        weight *= gather_share(id, pose, d);
        if weight < LOOKUP_LEAST_WEIGHT {
            continue;
        }
        if total == 0.0 {
            first = pose.radius;
        }
        let shrinks = first / pose.radius;
        let dense = weight * (shrinks * shrinks);
        g.irradiance += light[id].irradiance * dense;
        g.weight += weight;
        total += dense;
        g.confidence += dense * light[id].trust;
        if g.weight >= enough {
            break;
        }
    }
    if g.weight > 0.0 {
        g.weight = min(g.weight, 1.0);
        g.irradiance *= g.weight / total;
        g.confidence /= total;
    }
    if g.weight >= 1.0 || !wants_average {
        return g;
    }
    var average_weight = 0.0;
    for (var i = 0u; i < min(count, LOOKUP_AVERAGE_OF); i++) {
        let id = entries[cell.x + i];
        let pose = poses[id];
        var weight = lookup_leaning(normal, pose);
        if weight <= 0.0 || light[id].trust == 0.0 {
            continue;
        }
        weight *= gather_openness(id, pose, point - pose.position);
        if weight < LOOKUP_LEAST_WEIGHT {
            continue;
        }
        g.average += light[id].irradiance * weight;
        average_weight += weight;
    }
    let lacking = max(LOOKUP_AVERAGE_LEAST - average_weight, 0.0);
    g.average = (g.average + beyond * lacking) / max(average_weight, LOOKUP_AVERAGE_LEAST);
    return g;
}
