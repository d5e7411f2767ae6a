// The points of the selected pixels, one after the other.
import package::invocation::invocation_index;
import package::types::SurfacePoint;

@group(0) @binding(0) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(1) var<storage, read> selected: array<u32>;
@group(0) @binding(2) var<storage, read> scanned: array<u32>;
@group(0) @binding(3) var<storage, read_write> packed: array<SurfacePoint>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i < arrayLength(&points) && selected[i] != 0u {
        packed[scanned[i]] = points[i];
    }
}
