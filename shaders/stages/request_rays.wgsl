// How many rays each surfel would like.
import package::invocation::invocation_index;
import package::requests::requests_request;
@if(neighbours) import package::sharing::sharing_unpack;
@if(neighbours) import package::types::Neighbours;
import package::types::{Frame, SurfelBirth, SurfelIrradiance, SurfelPose, SurfelSettings};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> settings: SurfelSettings;
@group(0) @binding(2) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(3) var<storage, read> births: array<SurfelBirth>;
@group(0) @binding(4) var<storage, read> irradiance: array<SurfelIrradiance>;
@group(0) @binding(5) var<storage, read> unseen: array<u32>;
@if(neighbours) @group(0) @binding(6) var<storage, read> neighbours: array<Neighbours>;
@group(0) @binding(7) var<storage, read_write> requests: array<u32>;

// Relative variance of a ray, as a surfel's neighbours have found it.
@if(neighbours)
fn variance_of(i: u32) -> f32 {
    return sharing_unpack(neighbours[i]).ray_variance;
}
@else
fn variance_of(i: u32) -> f32 {
    return 0.0;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    let surfels = arrayLength(&poses);
    if i >= surfels {
        return;
    }
    var request = 0u;
    if poses[i].radius > 0.0 {
        request = requests_request(irradiance[i], variance_of(i), unseen[i], settings.steered != 0u);
    }
    let is_new = births[i].frame == frame.number;
    requests[i] = select(request, 0u, is_new);
    requests[surfels + i] = select(0u, request, is_new);
}
