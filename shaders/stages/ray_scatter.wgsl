// Rays into their bins, in the order in which threads come.
import package::invocation::invocation_index;
import package::types::DispatchArgs;

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<storage, read> bins: array<u32>;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read_write> cursors: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> order: array<u32>;

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
    let ray = batch.first + i;
    let bin = bins[ray];
    order[starts[bin] + atomicAdd(&cursors[bin], 1u)] = ray;
}
