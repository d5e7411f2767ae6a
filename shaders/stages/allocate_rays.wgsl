// Each surfel's share of the global budget: differences of floored cumulative shares.
import package::batch::batch_args;
import package::invocation::invocation_index;
import package::types::{DispatchArgs, SurfelSettings};
import package::wide_integer::wide_integer_share;

@group(0) @binding(0) var<uniform> settings: SurfelSettings;
@group(0) @binding(1) var<storage, read> scanned: array<u32>;
@group(0) @binding(2) var<storage, read> total: array<u32>;
@group(0) @binding(3) var<storage, read_write> offsets: array<u32>;
@group(0) @binding(4) var<storage, read_write> batch: array<DispatchArgs>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    let capacity = settings.capacity;
    if i > capacity {
        return;
    }
    let all = total[0];
    var before = all;
    if i < capacity {
        before = scanned[i];
    }
    let offset = wide_integer_share(before, settings.ray_budget, all);
    offsets[i] = offset;
    if i == capacity {
        batch[0] = batch_args(offset);
    }
}
