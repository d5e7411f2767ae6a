// Last of three stages of an exclusive prefix sum: the sum before each number. One workgroup per block.
import package::invocation::invocation_group;
import package::workgroup_scan::{WORKGROUP_SCAN_BLOCK, WORKGROUP_SCAN_EACH, workgroup_scan_exclusive};

@group(0) @binding(0) var<storage, read> values: array<u32>;
@group(0) @binding(1) var<storage, read> before: array<u32>;
@group(0) @binding(2) var<storage, read_write> scanned: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = invocation_group(group, groups);
    if block >= arrayLength(&before) {
        return;
    }
    let first = block * WORKGROUP_SCAN_BLOCK + lane * WORKGROUP_SCAN_EACH;
    let last = min(first + WORKGROUP_SCAN_EACH, arrayLength(&values));
    var own = 0u;
    for (var i = first; i < last; i++) {
        own += values[i];
    }
    var sum = before[block] + workgroup_scan_exclusive(lane, own).x;
    for (var i = first; i < last; i++) {
        scanned[i] = sum;
        sum += values[i];
    }
}
