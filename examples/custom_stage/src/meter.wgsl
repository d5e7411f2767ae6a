// How bright the picture is. One workgroup.
import package::estimator::estimator_luminance;
import package::types::DispatchArgs;

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<storage, read> color: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> exposure: array<f32>;

const LANES: u32 = 64u;
const GREY: f32 = 0.18;
const SPEED: f32 = 0.25;

var<workgroup> sums: array<f32, LANES>;

@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) lane: u32) {
    var sum = 0.0;
    for (var i = lane; i < batch.count; i += LANES) {
        sum += estimator_luminance(color[i].xyz);
    }
    sums[lane] = sum;
    workgroupBarrier();
    if lane != 0u {
        return;
    }
    var all = 0.0;
    for (var i = 0u; i < LANES; i++) {
        all += sums[i];
    }
    let target_ = GREY / max(all / f32(batch.count), 1e-4);
    exposure[0] += (target_ - exposure[0]) * SPEED;
}
