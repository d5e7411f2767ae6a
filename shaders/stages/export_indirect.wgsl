// Indirect light as an image of the engine's. One invocation per pixel.
import package::half_float::half_float_rounded;
import package::lookup::lookup_complete;
import package::surface::{surface_albedo, surface_is_surface};
import package::types::{Camera, Gathered, HostGbuffer, SurfacePoint};

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> host: HostGbuffer;
@group(0) @binding(2) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(3) var<storage, read> gathered: array<Gathered>;
@group(0) @binding(4) var indirect: texture_storage_2d<rgba16float, write>;

/// The largest finite 16-bit float.
const MOST: f32 = 65504.0;
const FRAC_1_PI: f32 = 0.31830987;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= camera.width || at.y >= camera.height {
        return;
    }
    let i = at.y * camera.width + at.x;
    let point = points[i];
    var value = vec4<f32>();
    if surface_is_surface(point) {
        let g = gathered[i];
        let all = lookup_complete(g);
        let factor = select(vec3<f32>(1.0), surface_albedo(point) * FRAC_1_PI, host.radiance != 0u);
        // Light beyond the largest 16-bit float stays that.
        value = vec4<f32>(min(all * factor * host.exposure, vec3<f32>(MOST)), g.weight);
    }
    textureStore(indirect, at.xy, half_float_rounded(value));
}
