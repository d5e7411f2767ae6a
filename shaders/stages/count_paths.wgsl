// The place of each path that goes on, and how many there are. One workgroup.
import package::batch::{batch_args, batch_div_ceil};
import package::types::DispatchArgs;
import package::workgroup_scan::{WORKGROUP_SCAN_BLOCK, WORKGROUP_SCAN_EACH, workgroup_scan_exclusive};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<storage, read> goes_on: array<u32>;
@group(0) @binding(2) var<storage, read_write> before: array<u32>;
@group(0) @binding(3) var<storage, read_write> next: array<DispatchArgs>;

const PATHS_PER_WORD: u32 = 32u;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) lane: u32) {
    let words = batch_div_ceil(batch.count, PATHS_PER_WORD);
    var done = 0u;
    for (var block = 0u; block < words; block += WORKGROUP_SCAN_BLOCK) {
        let first = block + lane * WORKGROUP_SCAN_EACH;
        let last = min(first + WORKGROUP_SCAN_EACH, words);
        var own = 0u;
        for (var i = first; i < last; i++) {
            own += countOneBits(goes_on[i]);
        }
        let scanned = workgroup_scan_exclusive(lane, own);
        var sum = done + scanned.x;
        for (var i = first; i < last; i++) {
            before[i] = sum;
            sum += countOneBits(goes_on[i]);
        }
        done += scanned.y;
    }
    if lane == 0u {
        next[0] = batch_args(done);
    }
}
