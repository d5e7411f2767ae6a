// New surfels at the end of each cell's list to where they belong, and the bounds.
import package::bounds::{bounds_pack, bounds_steps_in};
import package::invocation::invocation_index;
import package::list_order::list_is_before;
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
    for (var i = count - min(born[cell], count); i < count; i++) {
        let moving = entries[start + i];
        var j = i;
        while j > 0u {
            let other = entries[start + j - 1u];
            if !list_is_before(moving, other) {
                break;
            }
            entries[start + j] = other;
            j -= 1u;
        }
        entries[start + j] = moving;
    }
    let steps = bounds_steps_in(cell, grid);
    for (var i = 0u; i < count; i++) {
        let pose = poses[entries[start + i]];
        entries[start + count + i] = bounds_pack(pose.position - grid.centre, pose.radius, steps);
    }
}
