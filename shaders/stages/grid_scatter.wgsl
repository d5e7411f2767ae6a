// Surfels into the lists of their cells, in the order of arrival; `grid_order` makes one that does not depend on it.
import package::grid::{GRID_PARTS, grid_extents, grid_span};
import package::invocation::invocation_index;
import package::types::{GridShape, SurfelPose};

@group(0) @binding(0) var<uniform> grid: GridShape;
@group(0) @binding(1) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read_write> cursors: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> entries: array<u32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= arrayLength(&poses) {
        return;
    }
    let pose = poses[i];
    if pose.radius <= 0.0 {
        return;
    }
    let reach = grid_extents(pose);
    for (var part = 0u; part < GRID_PARTS; part++) {
        let span = grid_span(pose.position, reach, grid, part);
        if !span.found {
            continue;
        }
        for (var z = span.low.z; z <= span.high.z; z++) {
            for (var y = span.low.y; y <= span.high.y; y++) {
                for (var x = span.low.x; x <= span.high.x; x++) {
                    let cell = span.base + (z * grid.side + y) * grid.side + x;
                    let slot = 2u * starts[cell] + atomicAdd(&cursors[cell], 1u);
                    if slot < arrayLength(&entries) / 2u {
                        entries[slot] = i;
                    }
                }
            }
        }
    }
}
