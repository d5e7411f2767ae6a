// The lists of the cells, ordered by a hash of surfel identity, with the surfels' bounds behind them; one that does not fit
// is emptied.
import package::bounds::{bounds_pack, bounds_steps_in};
import package::invocation::invocation_index;
import package::list_order::list_sort;
import package::lookup::LOOKUP_DROPPED;
import package::types::{GridShape, SurfelPose};

@group(0) @binding(0) var<uniform> grid: GridShape;
@group(0) @binding(1) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> entries: array<u32>;
@group(0) @binding(5) var<storage, read_write> cells: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read_write> overflow: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let cell = invocation_index(group, groups, 64u, lane);
    if cell >= arrayLength(&cells) {
        return;
    }
    let start = 2u * starts[cell];
    let count = counts[cell];
    let room = arrayLength(&entries) / 2u;
    if 2u * count > room || start > room - 2u * count {
        atomicAdd(&overflow[0], count);
        cells[cell] = vec2<u32>(LOOKUP_DROPPED, 0u);
        return;
    }
    cells[cell] = vec2<u32>(start, count);
    list_sort(start, count);
    let steps = bounds_steps_in(cell, grid);
    for (var i = 0u; i < count; i++) {
        let pose = poses[entries[start + i]];
        entries[start + count + i] = bounds_pack(pose.position - grid.centre, pose.radius, steps);
    }
}
