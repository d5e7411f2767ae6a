// The indices of the pixels between which light differs much, one after the other, block by block.
import package::between::between_is_open;
import package::invocation::invocation_index;
import package::types::{Camera, SurfacePoint};
import package::upsample::upsample_pixel_in;

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(2) var<storage, read> selected: array<u32>;
@group(0) @binding(3) var<storage, read> contrasts: array<u32>;
@group(0) @binding(4) var<storage, read> scanned: array<u32>;
@group(0) @binding(5) var<storage, read_write> pixels: array<u32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = invocation_index(group, groups, 64u, lane);
    if block >= arrayLength(&contrasts) || contrasts[block] == 0u {
        return;
    }
    var slot = scanned[block];
    for (var number = 0u; number < 4u; number++) {
        let at = upsample_pixel_in(block, number, camera.width);
        if between_is_open(at) {
            pixels[slot] = at.y * camera.width + at.x;
            slot += 1u;
        }
    }
}
