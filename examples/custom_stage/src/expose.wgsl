// The picture as a screen shows it.
import package::invocation::invocation_index;
import package::types::DispatchArgs;

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<storage, read> color: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> exposure: array<f32>;
@group(0) @binding(3) var<storage, read_write> shown: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= batch.count {
        return;
    }
    let x = color[i].xyz * exposure[0];
    shown[i] = vec4<f32>(x / (1.0 + x), color[i].w);
}
