// Each surfel's share of the global budget: differences of floored cumulative shares. Where they are
// floored moves along from frame to frame. The rays of new surfels come after all others.
import package::batch::batch_args;
import package::hash::hash_pcg;
import package::invocation::invocation_index;
import package::types::{DispatchArgs, Frame, SurfelSettings};
import package::wide_integer::{wide_integer_multiply, wide_integer_share};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> settings: SurfelSettings;
@group(0) @binding(2) var<storage, read> requests: array<u32>;
@group(0) @binding(3) var<storage, read> scanned: array<u32>;
@group(0) @binding(4) var<storage, read> total: array<u32>;
@group(0) @binding(5) var<storage, read_write> spans: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read_write> batch: array<DispatchArgs>;
@group(0) @binding(7) var<storage, read_write> persistent: array<DispatchArgs>;
@group(0) @binding(8) var<storage, read_write> spawned: array<DispatchArgs>;

/// 2^32 over the golden ratio.
const GOLDEN: u32 = 0x9e3779b9u;

/// Where in `[0, total)` this frame floors the shares from.
fn phase_of(total_: u32) -> u32 {
    return wide_integer_multiply(total_, frame.number * GOLDEN + hash_pcg(frame.seed)).x;
}

/// Rays that come before those of the next request.
fn rays_before(requested: u32) -> u32 {
    let all = total[0];
    return wide_integer_share(requested, settings.ray_budget, phase_of(all), all);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    let surfels = arrayLength(&spans);
    if i >= surfels {
        return;
    }
    let is_new = requests[surfels + i] > 0u;
    let at = select(i, surfels + i, is_new);
    let first = rays_before(scanned[at]);
    let last = rays_before(scanned[at] + requests[at]);
    spans[i] = vec2<u32>(first, last - first);
    if i == 0u {
        let all = rays_before(total[0]);
        let new_ones = rays_before(scanned[surfels]);
        batch[0] = batch_args(all);
        persistent[0] = batch_args(new_ones);
        var args = batch_args(all - new_ones);
        args.first = new_ones;
        spawned[0] = args;
    }
}
