// First of three stages of an exclusive prefix sum: the sum of each block, wrapping. One workgroup per block.
import package::invocation::invocation_group;
import package::workgroup_scan::{WORKGROUP_SCAN_BLOCK, WORKGROUP_SCAN_LANES};

@group(0) @binding(0) var<storage, read> values: array<u32>;
@group(0) @binding(1) var<storage, read_write> sums: array<u32>;

/// Zero when a workgroup starts.
var<workgroup> sum: atomic<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = invocation_group(group, groups);
    if block >= arrayLength(&sums) {
        return;
    }
    let first = block * WORKGROUP_SCAN_BLOCK;
    let last = min(first + WORKGROUP_SCAN_BLOCK, arrayLength(&values));
    var own = 0u;
    for (var i = first + lane; i < last; i += WORKGROUP_SCAN_LANES) {
        own += values[i];
    }
    // The order of integer additions does not matter.
    atomicAdd(&sum, own);
    workgroupBarrier();
    if lane == 0u {
        sums[block] = atomicLoad(&sum);
    }
}
