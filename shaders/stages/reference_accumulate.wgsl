// What a segment found, weighted by the balance heuristic, and whether its path goes on: Russian roulette by the
// largest albedo. A finished path is one sample of its pixel.
import package::direct::direct_irradiance;
import package::emitter::{emitter_density, emitter_sky_share};
import package::environment::{environment_solid_angle_per_area, environment_texel};
import package::estimator::estimator_luminance;
import package::hash::{hash_pcg, hash_unit};
import package::invocation::invocation_index;
import package::octahedral::octahedral_unpack;
import package::surface::{SURFACE_EMITTER, surface_albedo, surface_is_surface};
import package::types::{Frame, LightSample, Ray, ReferencePath, SurfacePoint};
import package::vector::{vector_dot, vector_max_element};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> rays: array<Ray>;
@group(0) @binding(2) var<storage, read> points: array<SurfacePoint>;
@if(direct) @group(0) @binding(3) var<storage, read> direct: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> emitter_samples: array<LightSample>;
@group(0) @binding(5) var<storage, read> emitter_visible: array<u32>;
@group(0) @binding(6) var<storage, read> environment: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> vertices: array<SurfacePoint>;
@group(0) @binding(8) var<storage, read_write> paths: array<ReferencePath>;

const PI: f32 = 3.1415927;
const FRAC_1_PI: f32 = 0.31830987;
/// Largest probability of going on: bounds the length of paths between white walls. In a closed room, a path that goes on less
/// often than light does counts more with each segment, and beyond an albedo of the root of this its variance has no bound.
const MOST_SURVIVAL: f32 = 0.99;

// What the segment met.
struct Met {
    // Radiance against the segment, W/(m^2 sr).
    radiance: vec3<f32>,
    // Density with which emitter sampling draws it, 1/sr.
    density: f32,
}

fn meet(point: SurfacePoint, origin: vec3<f32>, direction: vec3<f32>) -> Met {
    let share = emitter_sky_share(frame);
    if surface_is_surface(point) {
        var density = 0.0;
        if (point.albedo_b_flags & SURFACE_EMITTER) != 0u && share >= 0.0 {
            let d = point.position - origin;
            let facing = -vector_dot(octahedral_unpack(point.geometric_normal), direction);
            density = (1.0 - share) * emitter_density(frame, point.emission, facing, sqrt(vector_dot(d, d)));
        }
        return Met(point.emission, density);
    }
    let texel = environment_texel(frame.environment_side, direction);
    return Met(texel.xyz, max(share, 0.0) * texel.w / environment_solid_angle_per_area(direction));
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= arrayLength(&paths) {
        return;
    }
    var path = paths[i];
    if path.segment == 0u {
        return;
    }
    let vertex = vertices[i];
    // `scale` turns irradiance at this vertex into irradiance at the pixel.
    var arriving = vec3<f32>();
    if emitter_visible[i] != 0u {
        arriving += emitter_samples[i].irradiance;
    }
    if path.segment > 1u {
        arriving += direct_irradiance(i);
    }
    let direction = rays[i].direction;
    let point = points[i];
    let met = meet(point, vertex.position, direction);
    let cosine = max(vector_dot(octahedral_unpack(vertex.shading_normal), direction), 0.0);
    let own = cosine * FRAC_1_PI;
    var weight = 1.0;
    if own > 0.0 {
        weight = own / (own + met.density);
    }
    path.sample += path.scale * (arriving + met.radiance * (PI * weight));
    path.segment += 1u;
    path.segments += 1u;
    var ends = true;
    if surface_is_surface(point) {
        let albedo = surface_albedo(point);
        let survival = min(vector_max_element(albedo), MOST_SURVIVAL);
        path.seed = hash_pcg(path.seed);
        if hash_unit(path.seed) < survival {
            // The ray's own factor is pi (irradiance over radiance); the surface's is albedo over pi.
            path.scale = path.scale * albedo / survival;
            vertices[i] = point;
            ends = false;
        }
    }
    if ends {
        let luminance = estimator_luminance(path.sample);
        path.sum += path.sample;
        path.sum_squared += luminance * luminance;
        path.largest = max(path.largest, luminance);
        path.segment = 0u;
        path.done += 1u;
    }
    paths[i] = path;
}
