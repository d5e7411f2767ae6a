// Every pixel's light from that of the selected ones: its own, or the mean of those around it; and where light differs much.
import package::invocation::invocation_index;
import package::surface::surface_is_surface;
import package::types::{Camera, F32_MAX, Gathered, SurfacePoint};
import package::upsample::{UPSAMPLE_CONTRAST, upsample_around, upsample_block_of, upsample_light, upsample_mean};

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(2) var<storage, read> selected: array<u32>;
@group(0) @binding(3) var<storage, read> scanned: array<u32>;
@group(0) @binding(4) var<storage, read> packed: array<Gathered>;
@group(0) @binding(5) var<storage, read_write> gathered: array<Gathered>;
@group(0) @binding(6) var<storage, read_write> contrasts: array<u32>;

fn packed_at(x: u32, y: u32) -> Gathered {
    return packed[scanned[y * camera.width + x]];
}

/// Light differs much between the corners of the block of 2x2 pixels that begins at one: those of its pixels with even
/// coordinates, and of the next ones.
fn contrast(at: vec2<u32>) -> bool {
    var least = F32_MAX;
    var most = 0.0;
    for (var corner = 0u; corner < 4u; corner++) {
        let x = at.x + 2u * (corner & 1u);
        let y = at.y + 2u * (corner >> 1u);
        if x < camera.width && y < camera.height && selected[y * camera.width + x] != 0u {
            let light = upsample_light(packed_at(x, y));
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
    let i = invocation_index(group, groups, 64u, lane);
    if i >= camera.width * camera.height {
        return;
    }
    var found = Gathered();
    if selected[i] != 0u {
        found = packed[scanned[i]];
    } else if surface_is_surface(points[i]) {
        let ends = upsample_around(vec2<u32>(i % camera.width, i / camera.width));
        found = upsample_mean(
            packed_at(ends.x, ends.y),
            packed_at(ends.z, ends.y),
            packed_at(ends.x, ends.w),
            packed_at(ends.z, ends.w),
        );
    }
    gathered[i] = found;
    let at = vec2<u32>(i % camera.width, i / camera.width);
    if all(at % 2u == vec2<u32>(0u)) {
        contrasts[upsample_block_of(at, camera.width)] = select(0u, 1u, contrast(at));
    }
}
