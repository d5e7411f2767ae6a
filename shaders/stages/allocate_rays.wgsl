// Each surfel's share of the global budget: differences of floored cumulative shares. Where they are
// floored moves along from frame to frame.
import package::batch::batch_args;
import package::hash::hash_pcg;
import package::invocation::invocation_index;
import package::types::{DispatchArgs, Frame, SurfelSettings};
import package::wide_integer::{wide_integer_multiply, wide_integer_share};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> settings: SurfelSettings;
@group(0) @binding(2) var<storage, read> scanned: array<u32>;
@group(0) @binding(3) var<storage, read> total: array<u32>;
@group(0) @binding(4) var<storage, read_write> offsets: array<u32>;
@group(0) @binding(5) var<storage, read_write> batch: array<DispatchArgs>;

/// 2^32 over the golden ratio.
const GOLDEN: u32 = 0x9e3779b9u;

/// Where in `[0, total)` this frame floors the shares from.
fn phase_of(total_: u32) -> u32 {
    return wide_integer_multiply(total_, frame.number * GOLDEN + hash_pcg(frame.seed)).x;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    let surfels = arrayLength(&scanned);
    if i > surfels {
        return;
    }
    let all = total[0];
    var before = all;
    if i < surfels {
        before = scanned[i];
    }
    let offset = wide_integer_share(before, settings.ray_budget, phase_of(all), all);
    offsets[i] = offset;
    if i == surfels {
        batch[0] = batch_args(offset);
    }
}
