// Surfels on the surfaces that the pixels see, as a debug view shows them.
@if(depths) import package::depth::{depth_moments, depth_visibility};
@if(guides) import package::guide::{guide_texel, guide_texel_of};
import package::debug::{
    DEBUG_VIEW_COVERAGE, DEBUG_VIEW_DEPTH_FUNCTION, DEBUG_VIEW_GUIDE, DEBUG_VIEW_RAY_COUNT, DEBUG_VIEW_SURFELS,
    debug_headlight, debug_nothing
};
import package::grid::grid_cell;
import package::invocation::invocation_index;
import package::lookup::{LOOKUP_LEAST_WEIGHT, lookup_alignment, lookup_falloff};
@if(depths) import package::mark::mark_is_open;
import package::octahedral::octahedral_unpack;
import package::sampling::sampling_to_local;
import package::surface::surface_is_surface;
import package::types::{
    Camera, DebugPixel, DispatchArgs, F32_MAX, GridShape, NONE, SurfacePoint, SurfelPose, SurfelSettings
};
import package::vector::{vector_dot, vector_length};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<uniform> camera: Camera;
@group(0) @binding(2) var<uniform> grid: GridShape;
@group(0) @binding(3) var<uniform> settings: SurfelSettings;
@group(0) @binding(4) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(5) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> entries: array<u32>;
@group(0) @binding(7) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(8) var<storage, read> values: array<f32>;
@if(depths) @group(0) @binding(9) var<storage, read> depths: array<u32>;
@if(guides) @group(0) @binding(10) var<storage, read> guides: array<u32>;
@group(0) @binding(11) var<storage, read_write> debug: array<DebugPixel>;

/// How much a disc darkens to its rim in the view that shows discs as such.
const RIM: f32 = 0.6;
/// Share of a disc's radius that its guide is drawn on: about as much as its neighbours leave of it.
const GUIDE_REACH: f32 = 0.5;

@if(depths)
fn share(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    if mark_is_open(pose.mark) {
        return 1.0;
    }
    return depth_visibility(id, pose, d);
}
@else
fn share(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    return 1.0;
}

/// Mean distance in the direction of a point at `d` from the surfel, as a lookup asks for it; along the normal
/// at the centre, where no lookup asks.
@if(depths)
fn mean_distance(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    let distance = vector_length(d);
    var local = vec3<f32>(0.0, 0.0, 1.0);
    if distance >= 0.02 * pose.radius {
        local = sampling_to_local(d / distance, pose.normal);
    }
    return depth_moments(id, vec3<f32>(local.xy, max(local.z, 0.0))).x;
}
@else
fn mean_distance(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    return -1.0;
}

/// The guide's texel at a point of the disc's middle, which is the hemisphere seen from above; nothing beyond.
@if(guides)
fn guide_at(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    let local = sampling_to_local(d / (GUIDE_REACH * pose.radius), pose.normal);
    let squared = 1.0 - local.x * local.x - local.y * local.y;
    if squared < 0.0 {
        return -1.0;
    }
    let z = sqrt(squared);
    return f32(guide_texel(id, guide_texel_of(vec3<f32>(local.xy, z)))) / 255.0;
}
@else
fn guide_at(id: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    return -1.0;
}

/// Summed weight of the surfels that have a value, in the order of a lookup; or the mean of their values.
fn weighted(point: vec3<f32>, normal: vec3<f32>, mean: bool) -> DebugPixel {
    let cell = cells[grid_cell(point, grid)];
    let count = min(cell.y, settings.lookup);
    var weights = 0.0;
    var sum = 0.0;
    for (var i = 0u; i < count; i++) {
        let id = entries[cell.x + i];
        let pose = poses[id];
        let d = point - pose.position;
        var weight = lookup_falloff(d, pose) * lookup_alignment(normal, pose);
        let value = values[id];
        if weight <= 0.0 || value < 0.0 {
            continue;
        }
        weight *= share(id, pose, d);
        if weight < LOOKUP_LEAST_WEIGHT {
            continue;
        }
        weights += weight;
        sum += value * weight;
    }
    if !mean {
        return DebugPixel(weights, 1.0);
    }
    if weights <= 0.0 {
        return debug_nothing();
    }
    return DebugPixel(sum / weights, 1.0);
}

/// The surfel with the nearest centre, of those that have a value and that overlap the point.
fn nearest(point: SurfacePoint, normal: vec3<f32>) -> DebugPixel {
    let cell = cells[grid_cell(point.position, grid)];
    let count = min(cell.y, settings.lookup);
    var found = NONE;
    var least = F32_MAX;
    for (var i = 0u; i < count; i++) {
        let id = entries[cell.x + i];
        let pose = poses[id];
        let d = point.position - pose.position;
        let squared = vector_dot(d, d);
        if squared < least && values[id] >= 0.0 && lookup_falloff(d, pose) * lookup_alignment(normal, pose) > 0.0 {
            found = id;
            least = squared;
        }
    }
    if found == NONE {
        return debug_nothing();
    }
    let pose = poses[found];
    let d = point.position - pose.position;
    if settings.debug == DEBUG_VIEW_DEPTH_FUNCTION {
        return DebugPixel(mean_distance(found, pose, d), 1.0);
    }
    if settings.debug == DEBUG_VIEW_GUIDE {
        return DebugPixel(guide_at(found, pose, d), 1.0);
    }
    if settings.debug == DEBUG_VIEW_SURFELS {
        let rim = least / (pose.radius * pose.radius);
        let shade = (1.0 - RIM * rim) * debug_headlight(camera.eye - point.position, normal);
        return DebugPixel(values[found], shade);
    }
    return DebugPixel(values[found], 1.0);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= batch.count {
        return;
    }
    let point = points[i];
    if !surface_is_surface(point) {
        debug[i] = debug_nothing();
        return;
    }
    let normal = octahedral_unpack(point.shading_normal);
    if settings.debug == DEBUG_VIEW_COVERAGE || settings.debug == DEBUG_VIEW_RAY_COUNT {
        debug[i] = weighted(point.position, normal, settings.debug == DEBUG_VIEW_RAY_COUNT);
    } else {
        debug[i] = nearest(point, normal);
    }
}
