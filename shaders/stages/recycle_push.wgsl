// Slots of surfels that go, back onto the free stack.
import package::invocation::invocation_index;
import package::types::{SurfelCounters, SurfelLight, SurfelPose};

@group(0) @binding(0) var<storage, read> gone: array<u32>;
@group(0) @binding(1) var<storage, read> ranks: array<u32>;
@group(0) @binding(2) var<storage, read> counters: array<SurfelCounters>;
@group(0) @binding(3) var<storage, read_write> free_slots: array<u32>;
@group(0) @binding(4) var<storage, read_write> poses: array<SurfelPose>;
@group(0) @binding(5) var<storage, read_write> light: array<SurfelLight>;
@group(0) @binding(6) var<storage, read_write> unseen: array<u32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i < arrayLength(&gone) && gone[i] != 0u {
        free_slots[counters[0].live - 1u - ranks[i]] = i;
        poses[i] = SurfelPose();
        light[i] = SurfelLight();
        unseen[i] = 0u;
    }
}
