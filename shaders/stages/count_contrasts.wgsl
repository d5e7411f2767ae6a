// Blocks of 2x2 pixels across which light differs much: how many of their pixels are still to be lit.
import package::between::between_is_open;
import package::invocation::invocation_index;
import package::types::{Camera, F32_MAX, Gathered, SurfacePoint};
import package::upsample::{UPSAMPLE_CONTRAST, upsample_light, upsample_pixel_in};

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(2) var<storage, read> selected: array<u32>;
@group(0) @binding(3) var<storage, read> gathered: array<Gathered>;
@group(0) @binding(4) var<storage, read_write> contrasts: array<u32>;

/// Light differs much between the corners of the block that begins at a pixel.
fn contrast(at: vec2<u32>) -> bool {
    var least = F32_MAX;
    var most = 0.0;
    for (var corner = 0u; corner < 4u; corner++) {
        let x = at.x + 2u * (corner & 1u);
        let y = at.y + 2u * (corner >> 1u);
        let i = y * camera.width + x;
        if x < camera.width && y < camera.height && selected[i] != 0u {
            let light = upsample_light(gathered[i]);
            least = min(least, light);
            most = max(most, light);
        }
    }
    return most > UPSAMPLE_CONTRAST * least;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = invocation_index(group, groups, 64u, lane);
    if block >= arrayLength(&contrasts) {
        return;
    }
    var count = 0u;
    if contrast(upsample_pixel_in(block, 0u, camera.width)) {
        for (var number = 0u; number < 4u; number++) {
            count += select(0u, 1u, between_is_open(upsample_pixel_in(block, number, camera.width)));
        }
    }
    contrasts[block] = count;
}
