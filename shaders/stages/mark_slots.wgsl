// One mark for the live surfel in a slot, and one for each place on the free stack that names it.
import package::invocation::invocation_index;
import package::types::{SurfelCounters, SurfelPose, SurfelSettings};

@group(0) @binding(0) var<uniform> settings: SurfelSettings;
@group(0) @binding(1) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(2) var<storage, read> counters: array<SurfelCounters>;
@group(0) @binding(3) var<storage, read> free_slots: array<u32>;
@group(0) @binding(4) var<storage, read_write> marks: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= settings.capacity {
        return;
    }
    if poses[i].radius > 0.0 {
        atomicAdd(&marks[i], select(2u, 1u, i < counters[0].used));
    }
    if i >= counters[0].live && free_slots[i] < settings.capacity {
        atomicAdd(&marks[free_slots[i]], 1u);
    }
}
