// Irradiance at the hits of rays from surfels around them: as gather_surfels, up to a weight that is enough, and with the
// cell's average where paths end, filled up with the irradiance of the surfel that each began at.
import package::gather::lookup_gather;
import package::invocation::invocation_index;
import package::lookup::LOOKUP_ENOUGH_AT_HITS;
import package::octahedral::octahedral_unpack;
import package::surface::surface_is_surface;
import package::types::{
    DispatchArgs, Gathered, GridShape, Path, SurfacePoint, SurfelLight, SurfelPose, SurfelSettings
};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<uniform> grid: GridShape;
@group(0) @binding(2) var<uniform> settings: SurfelSettings;
@group(0) @binding(3) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(4) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> entries: array<u32>;
@group(0) @binding(6) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(7) var<storage, read> light: array<SurfelLight>;
@if(depths) @group(0) @binding(8) var<storage, read> depths: array<u32>;
@if(paths) @group(0) @binding(9) var<storage, read> paths: array<Path>;
@group(0) @binding(10) var<storage, read_write> gathered: array<Gathered>;

/// Irradiance of the surfel that a path began at.
@if(paths)
fn irradiance_beyond(i: u32) -> vec3<f32> {
    let known = light[paths[i].surfel];
    return select(vec3<f32>(0.0), known.irradiance, known.trust > 0.0);
}
@else
fn irradiance_beyond(i: u32) -> vec3<f32> {
    return vec3<f32>(0.0);
}

@if(paths)
const ENDS = true;
@else
const ENDS = false;

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
    var found = Gathered();
    if surface_is_surface(point) {
        let normal = octahedral_unpack(point.shading_normal);
        let wants_average = ENDS && settings.fallback != 0u;
        found = lookup_gather(point.position, normal, LOOKUP_ENOUGH_AT_HITS, wants_average, irradiance_beyond(i));
    }
    gathered[i] = found;
}
