// The pixels that the surfels light themselves: those with even coordinates, and those at edges.
import package::invocation::invocation_index;
import package::surface::surface_is_surface;
import package::types::{Camera, SurfacePoint};
import package::upsample::{upsample_around, upsample_continuous, upsample_tolerance};

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(2) var<storage, read_write> selected: array<u32>;

fn sees(here: SurfacePoint, x: u32, y: u32, tolerance: f32) -> bool {
    return upsample_continuous(here, points[y * camera.width + x], tolerance);
}

/// The pixel lies between selected ones that see its surface.
fn between(here: SurfacePoint, at: vec2<u32>) -> bool {
    let ends = upsample_around(at);
    if all(ends.xy == ends.zw) || ends.z >= camera.width || ends.w >= camera.height {
        return false;
    }
    let tolerance = upsample_tolerance(here, camera);
    if !sees(here, ends.x, ends.y, tolerance) || !sees(here, ends.z, ends.w, tolerance) {
        return false;
    }
    return any(ends.xy == ends.zw) || (sees(here, ends.z, ends.y, tolerance) && sees(here, ends.x, ends.w, tolerance));
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= arrayLength(&points) {
        return;
    }
    var found = 0u;
    // There is no picture yet in a frame that nobody described.
    if i < camera.width * camera.height {
        let here = points[i];
        let at = vec2<u32>(i % camera.width, i / camera.width);
        found = select(0u, 1u, surface_is_surface(here) && !between(here, at));
    }
    selected[i] = found;
}
