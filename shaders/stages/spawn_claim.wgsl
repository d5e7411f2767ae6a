// A free slot for each birth, from the stack, by rank. Where there are too few slots, the rank that is
// served first is drawn anew each frame. Counts the holes in crowded cells, which get none.
import package::hash::hash_hash2;
import package::invocation::invocation_index;
import package::types::{CROWDED, Frame, NONE, SurfelCounters, SurfelSettings};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> settings: SurfelSettings;
@group(0) @binding(2) var<storage, read> candidates: array<u32>;
@group(0) @binding(3) var<storage, read> ranks: array<u32>;
@group(0) @binding(4) var<storage, read> total: array<u32>;
@group(0) @binding(5) var<storage, read> counters: array<SurfelCounters>;
@group(0) @binding(6) var<storage, read> free_slots: array<u32>;
@group(0) @binding(7) var<storage, read_write> claims: array<vec2<u32>>;
@group(0) @binding(8) var<storage, read_write> crowded: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile = invocation_index(group, groups, 64u, lane);
    if tile >= arrayLength(&candidates) {
        return;
    }
    let candidate = candidates[tile];
    let wanted = max(total[0], 1u);
    let first = hash_hash2(frame.number, frame.seed) % wanted;
    let rank = (ranks[tile] + first) % wanted;
    var claim = vec2<u32>(NONE, NONE);
    let slot = counters[0].live + rank;
    if candidate == CROWDED {
        atomicAdd(&crowded[0], 1u);
    } else if candidate != NONE && slot < settings.capacity {
        claim = vec2<u32>(free_slots[slot], candidate);
    }
    claims[tile] = claim;
}
