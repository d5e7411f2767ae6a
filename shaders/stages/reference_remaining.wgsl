// How many pixels have not finished their samples.
import package::invocation::invocation_index;
import package::types::{Frame, NONE, ReferencePath, SurfacePoint};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> primary: array<SurfacePoint>;
@group(0) @binding(2) var<storage, read> paths: array<ReferencePath>;
@group(0) @binding(3) var<storage, read_write> remaining: array<atomic<u32>>;

/// Unfinished pixels of the workgroup.
var<workgroup> unfinished: atomic<u32>;

// A pixel whose path has nothing left to do.
fn finished(i: u32) -> bool {
    return primary[i].transform_id == NONE || (paths[i].segment == 0u && paths[i].done >= frame.samples);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if lane == 0u {
        atomicStore(&unfinished, 0u);
    }
    workgroupBarrier();
    if i < arrayLength(&paths) && !finished(i) {
        atomicAdd(&unfinished, 1u);
    }
    workgroupBarrier();
    if lane == 0u {
        atomicAdd(&remaining[0], atomicLoad(&unfinished));
    }
}
