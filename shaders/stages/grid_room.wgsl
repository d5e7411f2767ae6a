// How much room the lists need that new surfels join: that of those and of the ones that the list has.
import package::invocation::invocation_index;

@group(0) @binding(0) var<storage, read> born: array<u32>;
@group(0) @binding(1) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read_write> counts: array<u32>;

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
    var count = born[cell];
    if count != 0u {
        count += cells[cell].y;
    }
    counts[cell] = count;
}
