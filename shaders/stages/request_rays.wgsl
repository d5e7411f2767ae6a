// How many rays each surfel would like: newly spawned ones ask for more.
import package::invocation::invocation_index;
import package::types::{SurfelIrradiance, SurfelPose};

@group(0) @binding(0) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(1) var<storage, read> irradiance: array<SurfelIrradiance>;
@group(0) @binding(2) var<storage, read_write> requests: array<u32>;

/// Rays that a surfel integrates before it counts as settled.
const FRESH: u32 = 128u;
/// Request of a fresh surfel, in units of a settled one's.
const FRESH_REQUEST: u32 = 4u;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= arrayLength(&poses) {
        return;
    }
    var request = 1u;
    if poses[i].radius <= 0.0 {
        request = 0u;
    } else if irradiance[i].samples < FRESH {
        request = FRESH_REQUEST;
    }
    requests[i] = request;
}
