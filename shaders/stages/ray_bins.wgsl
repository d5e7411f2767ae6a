// A bin for each ray of a batch, from the cell of its surfel and from its direction; and how many rays each bin has.
import package::invocation::invocation_index;
import package::sorting::{sorting_bin, sorting_place};
import package::types::{DispatchArgs, GridShape, Ray, SurfelPose};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<uniform> grid: GridShape;
@group(0) @binding(2) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(3) var<storage, read> spans: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> rays: array<Ray>;
@group(0) @binding(5) var<storage, read_write> bins: array<u32>;
@group(0) @binding(6) var<storage, read_write> counts: array<atomic<u32>>;

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
    let span = spans[i];
    if span.x - batch.first >= batch.count {
        return;
    }
    let place = sorting_place(poses[i].position, grid);
    for (var ray = span.x; ray < span.x + span.y; ray++) {
        let bin = sorting_bin(place, rays[ray].direction);
        bins[ray] = bin;
        atomicAdd(&counts[bin], 1u);
    }
}
