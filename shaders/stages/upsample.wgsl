// Every pixel's light from that of the selected ones: its own, or the mean of those around it.
import package::between::between_is_open;
import package::invocation::invocation_index;
import package::surface::surface_is_surface;
import package::types::{Camera, Gathered, SurfacePoint};
import package::upsample::{upsample_around, upsample_block_of, upsample_mean, upsample_pixel_in};

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(2) var<storage, read> selected: array<u32>;
@group(0) @binding(3) var<storage, read> scanned: array<u32>;
@group(0) @binding(4) var<storage, read> packed: array<Gathered>;
@group(0) @binding(5) var<storage, read> contrasts: array<u32>;
@group(0) @binding(6) var<storage, read> contrasts_scanned: array<u32>;
@group(0) @binding(7) var<storage, read> contrasts_packed: array<Gathered>;
@group(0) @binding(8) var<storage, read_write> gathered: array<Gathered>;

fn packed_at(x: u32, y: u32) -> Gathered {
    return packed[scanned[y * camera.width + x]];
}

/// What was gathered at a pixel of a block with contrasts.
fn in_contrast(block: u32, at: vec2<u32>) -> Gathered {
    var slot = contrasts_scanned[block];
    let own = (at.x & 1u) + 2u * (at.y & 1u);
    for (var number = 0u; number < own; number++) {
        slot += select(0u, 1u, between_is_open(upsample_pixel_in(block, number, camera.width)));
    }
    return contrasts_packed[slot];
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= camera.width * camera.height {
        return;
    }
    var found = Gathered();
    if selected[i] != 0u {
        found = packed[scanned[i]];
    } else if surface_is_surface(points[i]) {
        let at = vec2<u32>(i % camera.width, i / camera.width);
        let block = upsample_block_of(at, camera.width);
        if contrasts[block] != 0u {
            found = in_contrast(block, at);
        } else {
            let ends = upsample_around(at);
            found = upsample_mean(
                packed_at(ends.x, ends.y),
                packed_at(ends.z, ends.y),
                packed_at(ends.x, ends.w),
                packed_at(ends.z, ends.w),
            );
        }
    }
    gathered[i] = found;
}
