// How many of each cell's list stay when those that are gone have left.
import package::invocation::invocation_index;
import package::lookup::LOOKUP_DROPPED;

@group(0) @binding(0) var<storage, read> gone: array<u32>;
@group(0) @binding(1) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> entries: array<u32>;
@group(0) @binding(3) var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let cell = invocation_index(group, groups, 64u, lane);
    if cell >= arrayLength(&counts) {
        return;
    }
    let list = cells[cell];
    var staying = 0u;
    if list.x != LOOKUP_DROPPED {
        for (var i = list.x; i < list.x + list.y; i++) {
            if gone[entries[i]] == 0u {
                staying += 1u;
            }
        }
    }
    counts[cell] = staying;
}
