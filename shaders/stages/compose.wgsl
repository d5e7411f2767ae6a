// The picture: indirect irradiance of each pixel, and its radiance.
import package::direct::direct_irradiance;
import package::sky::sky_radiance;
import package::invocation::invocation_index;
import package::lookup::lookup_complete;
import package::surface::{surface_albedo, surface_is_surface};
import package::types::{DispatchArgs, Frame, Gathered, Ray, SurfacePoint};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<storage, read> rays: array<Ray>;
@group(0) @binding(3) var<storage, read> points: array<SurfacePoint>;
@if(direct) @group(0) @binding(4) var<storage, read> direct: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> gathered: array<Gathered>;
@if(environment) @group(0) @binding(6) var<storage, read> environment: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> irradiance: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> color: array<vec4<f32>>;

const FRAC_1_PI: f32 = 0.31830987;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= batch.count {
        return;
    }
    let point = points[i];
    if !surface_is_surface(point) {
        let sky = sky_radiance(frame.environment_side, rays[i].direction);
        irradiance[i] = vec4<f32>(0.0);
        color[i] = vec4<f32>(sky, 0.0);
        return;
    }
    let indirect = lookup_complete(gathered[i]);
    let all = indirect + direct_irradiance(i);
    let radiance = point.emission + surface_albedo(point) * FRAC_1_PI * all;
    irradiance[i] = vec4<f32>(indirect, gathered[i].weight);
    color[i] = vec4<f32>(radiance, 1.0);
}
