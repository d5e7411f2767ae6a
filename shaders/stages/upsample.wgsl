// Light of the pixels where none was gathered: the mean of the selected ones around them.
import package::invocation::invocation_index;
import package::surface::surface_is_surface;
import package::types::{Camera, Gathered, SurfacePoint};
import package::upsample::{upsample_around, upsample_block_of, upsample_mean};

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(2) var<storage, read> selected: array<u32>;
@group(0) @binding(3) var<storage, read> contrasts: array<u32>;
@group(0) @binding(4) var<storage, read_write> gathered: array<Gathered>;

fn gathered_at(x: u32, y: u32) -> Gathered {
    return gathered[y * camera.width + x];
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= camera.width * camera.height || selected[i] != 0u {
        return;
    }
    var found = Gathered();
    if surface_is_surface(points[i]) {
        let at = vec2<u32>(i % camera.width, i / camera.width);
        if contrasts[upsample_block_of(at, camera.width)] != 0u {
            return;
        }
        let ends = upsample_around(at);
        found = upsample_mean(
            gathered_at(ends.x, ends.y),
            gathered_at(ends.z, ends.y),
            gathered_at(ends.x, ends.w),
            gathered_at(ends.z, ends.w),
        );
    }
    gathered[i] = found;
}
