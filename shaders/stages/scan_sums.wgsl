// Second of three stages of an exclusive prefix sum: the sums of the blocks, by one workgroup.
import package::workgroup_scan::{WORKGROUP_SCAN_BLOCK, WORKGROUP_SCAN_EACH, workgroup_scan_exclusive};

@group(0) @binding(0) var<storage, read> sums: array<u32>;
@group(0) @binding(1) var<storage, read_write> before: array<u32>;
@group(0) @binding(2) var<storage, read_write> total: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) lane: u32) {
    let count = arrayLength(&sums);
    var done = 0u;
    for (var block = 0u; block < count; block += WORKGROUP_SCAN_BLOCK) {
        let first = block + lane * WORKGROUP_SCAN_EACH;
        let last = min(first + WORKGROUP_SCAN_EACH, count);
        var own = 0u;
        for (var i = first; i < last; i++) {
            own += sums[i];
        }
        let scanned = workgroup_scan_exclusive(lane, own);
        var sum = done + scanned.x;
        for (var i = first; i < last; i++) {
            before[i] = sum;
            sum += sums[i];
        }
        done += scanned.y;
    }
    if lane == 0u {
        total[0] = done;
    }
}
