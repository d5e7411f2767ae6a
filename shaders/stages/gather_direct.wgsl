// Sums the light samples of each point that nothing shadows, W/m^2.
import package::invocation::invocation_index;
import package::types::{DispatchArgs, Frame, LightSample};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<storage, read> samples: array<LightSample>;
@group(0) @binding(3) var<storage, read> visible: array<u32>;
@group(0) @binding(4) var<storage, read_write> direct: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(workgroup, groups, 64u, lane);
    if i >= batch.count {
        return;
    }
    let each = frame.lights_per_point;
    var sum = vec3<f32>();
    for (var k = i * each; k < (i + 1u) * each; k++) {
        if visible[k] != 0u {
            sum += samples[k].irradiance;
        }
    }
    direct[i] = vec4<f32>(sum, 0.0);
}
