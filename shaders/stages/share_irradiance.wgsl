// Asks the neighbours of each uncertain surfel for their irradiance, by how near they are, with the normal and depth
// factors of the lookup.
import package::bounds::{bounds_may_reach, bounds_place, bounds_steps_in};
@if(depths) import package::depth::depth_visibility;
import package::estimator::estimator_luminance;
import package::grid::grid_cell;
import package::invocation::invocation_index;
import package::lookup::{lookup_alignment, lookup_nearness, lookup_trust};
import package::sharing::{
    SHARING_ASKS, SHARING_LEAST_SPREAD, SHARING_LEAST_WEIGHT, SHARING_MOST_RAYS, SHARING_MOST_VARIANCE, SHARING_MOST_WORTH, SHARING_OWN_PART, SHARING_OWN_RAYS, SHARING_REACH, SharingSaid, sharing_asks, sharing_light, sharing_mean_variance, sharing_pack, sharing_unpack
};
import package::types::{
    Frame, GridShape, Neighbours, SurfelIrradiance, SurfelLight, SurfelPose, SurfelSettings
};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> grid: GridShape;
@group(0) @binding(2) var<uniform> settings: SurfelSettings;
@group(0) @binding(3) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> entries: array<u32>;
@group(0) @binding(5) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(6) var<storage, read> irradiance: array<SurfelIrradiance>;
@if(depths) @group(0) @binding(7) var<storage, read> depths: array<u32>;
@group(0) @binding(8) var<storage, read_write> neighbours: array<Neighbours>;
@group(0) @binding(9) var<storage, read_write> light: array<SurfelLight>;

@if(depths)
fn visible_share(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    return depth_visibility(id, pose, d);
}
@else
fn visible_share(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    return 1.0;
}

fn ask(own: u32) -> SharingSaid {
    let own_pose = poses[own];
    let point = own_pose.position;
    let normal = own_pose.normal;
    let at = grid_cell(point, grid);
    let cell = cells[at];
    let count = min(cell.y, settings.lookup);
    let place = bounds_place(point - grid.centre, bounds_steps_in(at, grid));
    var others = 0u;
    var mean = vec3<f32>(0.0);
    var sum = 0.0;
    var squares = 0.0;
    var noise = 0.0;
    var trust = 0.0;
    var ray_variance = 0.0;
    var ray_sum = 0.0;
    // Of the neighbours alone.
    var around_variance = 0.0;
    var around_ray_sum = 0.0;
    var around_level = 0.0;
    var around_sum = 0.0;
    for (var i = 0u; i < count; i++) {
        if !bounds_may_reach(entries[cell.x + cell.y + i], place, SHARING_REACH) {
            continue;
        }
        let id = entries[cell.x + i];
        let state = irradiance[id];
        if state.samples == 0u {
            continue;
        }
        let pose = poses[id];
        var wide = pose;
        wide.radius = f32(SHARING_REACH) * pose.radius;
        let d = point - pose.position;
        var weight = lookup_nearness(d, wide) * lookup_alignment(normal, pose);
        if weight <= 0.0 {
            continue;
        }
        weight *= visible_share(id, pose, d);
        // A wall between the two may be known to only one of them.
        weight *= visible_share(own, own_pose, pose.position - point);
        if weight < SHARING_LEAST_WEIGHT {
            continue;
        }
        let age = frame.number - state.since;
        let samples = f32(state.samples);
        let is_own = id == own;
        let of_rays = select(weight, weight * max(samples / SHARING_OWN_RAYS, 1.0), is_own);
        ray_variance += of_rays * state.variance;
        ray_sum += of_rays;
        others += select(1u, 0u, is_own);
        let counts = select(1.0, SHARING_OWN_PART, is_own) * weight * min(samples, SHARING_MOST_RAYS);
        let level = estimator_luminance(state.mean);
        if !is_own {
            around_variance += of_rays * state.variance;
            around_ray_sum += of_rays;
            around_level += counts * max(level, estimator_luminance(state.short_mean));
            around_sum += counts;
        }
        mean += state.mean * counts;
        sum += counts;
        squares += counts * (level * level);
        noise += counts * sharing_mean_variance(state);
        trust += counts * lookup_trust(age);
    }
    var said = SharingSaid();
    if others == 0u || sum <= 0.0 {
        return said;
    }
    said.mean = mean / sum;
    said.trust = trust / sum;
    let level = estimator_luminance(said.mean);
    let average_noise = noise / sum;
    // What they differ by, beyond their noise.
    let apart = max(squares / sum - level * level - average_noise, 0.0);
    let least = SHARING_LEAST_SPREAD * level;
    let spread = apart + least * least;
    let average_ray = ray_variance / ray_sum;
    if around_variance > 0.0 {
        let around = around_level / around_sum;
        said.ray_variance = min(around_variance / around_ray_sum / max(around * around, 1.17549435e-38), SHARING_MOST_VARIANCE);
    }
    // Where nothing tells that they differ, they are as good as any number of rays.
    if average_ray > 0.0 {
        said.rays = min(average_ray / max(spread, 1.17549435e-38), SHARING_MOST_WORTH);
    }
    return said;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= arrayLength(&poses) || neighbours[i].packed != SHARING_ASKS {
        return;
    }
    let state = irradiance[i];
    var told = Neighbours();
    if sharing_asks(state) {
        told = sharing_pack(ask(i));
    }
    neighbours[i] = told;
    light[i] = sharing_light(state, frame.number - state.since, sharing_unpack(told));
}
