// Prefix sum over one workgroup of 256 invocations, each of which owns 4 consecutive numbers of a block of 1024.

/// Numbers per block.
const WORKGROUP_SCAN_BLOCK: u32 = 1024u;
/// Invocations per workgroup.
const WORKGROUP_SCAN_LANES: u32 = 256u;
/// Numbers per invocation.
const WORKGROUP_SCAN_EACH: u32 = WORKGROUP_SCAN_BLOCK / WORKGROUP_SCAN_LANES;

var<workgroup> workgroup_scan_sums: array<u32, WORKGROUP_SCAN_LANES>;

/// The sum of `value` over the lanes before (`x`) and over all lanes (`y`), wrapping (Hillis and Steele 1986). All
/// invocations of the workgroup must call it.
fn workgroup_scan_exclusive(lane: u32, value: u32) -> vec2<u32> {
    var sum = value;
    workgroup_scan_sums[lane] = sum;
    workgroupBarrier();
    for (var step = 1u; step < WORKGROUP_SCAN_LANES; step = step << 1u) {
        if lane >= step {
            sum += workgroup_scan_sums[lane - step];
        }
        workgroupBarrier();
        workgroup_scan_sums[lane] = sum;
        workgroupBarrier();
    }
    let total = workgroup_scan_sums[WORKGROUP_SCAN_LANES - 1u];
    // The sums may be overwritten by the next call.
    workgroupBarrier();
    return vec2<u32>(sum - value, total);
}
