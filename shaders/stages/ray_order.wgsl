// The rays of each bin, in their own order, so that threads do not decide.
import package::invocation::invocation_index;
import package::sorting::SORTING_BINS;

@group(0) @binding(0) var<storage, read> starts: array<u32>;
@group(0) @binding(1) var<storage, read> counts: array<u32>;
@group(0) @binding(2) var<storage, read_write> order: array<u32>;

/// Shell sort: in place, and fast enough for bins of tens to hundreds.
fn sort(start: u32, count: u32) {
    for (var gap = count / 2u; gap > 0u; gap /= 2u) {
        for (var i = gap; i < count; i++) {
            let moving = order[start + i];
            var j = i;
            while j >= gap {
                let other = order[start + j - gap];
                if other <= moving {
                    break;
                }
                order[start + j] = other;
                j -= gap;
            }
            order[start + j] = moving;
        }
    }
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let bin = invocation_index(group, groups, 64u, lane);
    if bin >= SORTING_BINS {
        return;
    }
    sort(starts[bin], counts[bin]);
}
