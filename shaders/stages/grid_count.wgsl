// How many surfels each cell lists: every live surfel counts in each cell that the box around it overlaps; or, with claims,
// those that were claimed.
import package::grid::{GRID_PARTS, grid_extents, grid_span};
import package::invocation::invocation_index;
import package::types::{GridShape, NONE, SurfelPose};

@group(0) @binding(0) var<uniform> grid: GridShape;
@group(0) @binding(1) var<storage, read> poses: array<SurfelPose>;
@if(claims) @group(0) @binding(2) var<storage, read> claims: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> counts: array<atomic<u32>>;

@if(claims)
fn surfel(i: u32) -> u32 {
    if i >= arrayLength(&claims) {
        return NONE;
    }
    return claims[i].x;
}
@else
fn surfel(i: u32) -> u32 {
    return select(NONE, i, i < arrayLength(&poses));
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let id = surfel(invocation_index(group, groups, 64u, lane));
    if id == NONE {
        return;
    }
    let pose = poses[id];
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
                    atomicAdd(&counts[cell], 1u);
                }
            }
        }
    }
}
