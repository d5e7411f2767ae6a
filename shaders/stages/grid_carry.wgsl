// Lists that new surfels join, to the second half of the entries, where there is room behind them for those.
import package::invocation::invocation_index;
import package::lookup::LOOKUP_DROPPED;

@group(0) @binding(0) var<storage, read> starts: array<u32>;
@group(0) @binding(1) var<storage, read> counts: array<u32>;
@group(0) @binding(2) var<storage, read_write> entries: array<u32>;
@group(0) @binding(3) var<storage, read_write> cells: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> overflow: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let cell = invocation_index(group, groups, 64u, lane);
    if cell >= arrayLength(&counts) || counts[cell] == 0u {
        return;
    }
    let count = counts[cell];
    let room = arrayLength(&entries);
    let start = room / 2u + 2u * starts[cell];
    let old = cells[cell];
    if old.x == LOOKUP_DROPPED || 2u * count > room || start > room - 2u * count {
        atomicAdd(&overflow[0], count);
        cells[cell] = vec2<u32>(LOOKUP_DROPPED, 0u);
        return;
    }
    for (var i = 0u; i < old.y; i++) {
        entries[start + i] = entries[old.x + i];
        entries[start + count + i] = entries[old.x + old.y + i];
    }
    cells[cell] = vec2<u32>(start, count);
}
