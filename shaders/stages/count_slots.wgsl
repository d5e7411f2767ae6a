// Slots that are marked other than once.
import package::invocation::invocation_index;
import package::types::SurfelSettings;

@group(0) @binding(0) var<uniform> settings: SurfelSettings;
@group(0) @binding(1) var<storage, read> marks: array<u32>;
@group(0) @binding(2) var<storage, read_write> errors: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i < settings.capacity && marks[i] != 1u {
        atomicAdd(&errors[0], 1u);
    }
}
