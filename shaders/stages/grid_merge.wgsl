// New surfels at the end of each cell's list to where they belong, and the bounds.
import package::bounds::{bounds_pack, bounds_steps_in};
import package::invocation::invocation_index;
import package::list_order::{list_is_before, list_key, list_sort};
import package::types::{GridShape, SurfelPose};

@group(0) @binding(0) var<uniform> grid: GridShape;
@group(0) @binding(1) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(2) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> born: array<u32>;
@group(0) @binding(4) var<storage, read_write> entries: array<u32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let cell = invocation_index(group, groups, 64u, lane);
    if cell >= arrayLength(&cells) || born[cell] == 0u {
        return;
    }
    let start = cells[cell].x;
    let count = cells[cell].y;
    var new_ones = min(born[cell], count);
    var old_ones = count - new_ones;
    list_sort(start + old_ones, new_ones);
    // Out of the way, to where their bounds will be; then the longer part moves up, and they come in from behind.
    let aside = start + count;
    for (var i = 0u; i < new_ones; i++) {
        entries[aside + i] = entries[start + old_ones + i];
    }
    while new_ones > 0u {
        let moving = entries[aside + new_ones - 1u];
        let next = start + old_ones + new_ones - 1u;
        var is_last = old_ones == 0u;
        if !is_last {
            is_last = !list_is_before(list_key(moving), moving, entries[start + old_ones - 1u]);
        }
        if is_last {
            entries[next] = moving;
            new_ones -= 1u;
        } else {
            entries[next] = entries[start + old_ones - 1u];
            old_ones -= 1u;
        }
    }
    let steps = bounds_steps_in(cell, grid);
    for (var i = 0u; i < count; i++) {
        let pose = poses[entries[start + i]];
        entries[start + count + i] = bounds_pack(pose.position - grid.centre, pose.radius, steps);
    }
}
