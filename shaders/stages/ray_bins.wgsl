// A bin for each ray, from the cell of its surfel and from its direction; and how many rays each bin has.
import package::invocation::invocation_index;
import package::sorting::{sorting_bin, sorting_place};
import package::types::{Frame, GridShape, Ray, SurfelBirth, SurfelPose};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> grid: GridShape;
@group(0) @binding(2) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(3) var<storage, read> births: array<SurfelBirth>;
@group(0) @binding(4) var<storage, read> offsets: array<u32>;
@group(0) @binding(5) var<storage, read> rays: array<Ray>;
@group(0) @binding(6) var<storage, read_write> bins: array<u32>;
@group(0) @binding(7) var<storage, read_write> counts: array<atomic<u32>>;

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
    let place = sorting_place(poses[i].position, grid, births[i].frame == frame.number);
    for (var ray = offsets[i]; ray < offsets[i + 1u]; ray++) {
        let bin = sorting_bin(place, rays[ray].direction);
        bins[ray] = bin;
        atomicAdd(&counts[bin], 1u);
    }
}
