// What the firefly clamp has taken from all surfels in all frames, summed in a fixed order.
import package::types::ClampedLight;

@group(0) @binding(0) var<storage, read> clamped: array<ClampedLight>;
@group(0) @binding(1) var<storage, read_write> total: array<ClampedLight>;

const LANES: u32 = 256u;

var<workgroup> sums: array<ClampedLight, 256>;

fn plus(a: ClampedLight, b: ClampedLight) -> ClampedLight {
    return ClampedLight(a.taken + b.taken, a.brought + b.brought, a.samples + b.samples, 0u);
}

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) lane: u32) {
    var sum = ClampedLight();
    for (var i = lane; i < arrayLength(&clamped); i += LANES) {
        sum = plus(sum, clamped[i]);
    }
    sums[lane] = sum;
    workgroupBarrier();
    for (var half = LANES / 2u; half > 0u; half /= 2u) {
        if lane < half {
            sums[lane] = plus(sums[lane], sums[lane + half]);
        }
        workgroupBarrier();
    }
    if lane == 0u {
        total[0] = plus(total[0], sums[0]);
    }
}
