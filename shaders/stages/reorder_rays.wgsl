// Rays and paths in the order of their bins.
import package::invocation::invocation_index;
import package::types::{DispatchArgs, Path, Ray};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<storage, read> order: array<u32>;
@group(0) @binding(2) var<storage, read> rays: array<Ray>;
@group(0) @binding(3) var<storage, read> paths: array<Path>;
@group(0) @binding(4) var<storage, read_write> sorted_rays: array<Ray>;
@group(0) @binding(5) var<storage, read_write> sorted_paths: array<Path>;
@group(0) @binding(6) var<storage, read_write> places: array<u32>;

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
    let ray = order[i];
    let place = batch.first + i;
    sorted_rays[place] = rays[ray];
    sorted_paths[place] = paths[ray];
    places[ray] = place;
}
