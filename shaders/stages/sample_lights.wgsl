// Chooses `lights_per_point` lights for each point: all of them where that many suffice, else one at random from each
// of as many equal strata of the list. One invocation per point and choice.
import package::hash::{hash_hash2, hash_hash3, hash_unit};
import package::invocation::invocation_index;
import package::octahedral::octahedral_unpack;
import package::sampling::sampling_start;
import package::surface::surface_is_surface;
import package::types::{DispatchArgs, F32_MAX, Frame, Light, LightSample, Ray, SurfacePoint};
import package::vector::{vector_dot, vector_max_element};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(3) var<storage, read> lights: array<Light>;
@group(0) @binding(4) var<storage, read_write> rays: array<Ray>;
@group(0) @binding(5) var<storage, read_write> samples: array<LightSample>;

// Share of the distance to a light that a shadow ray covers; the rest is a margin for rounding.
const REACH: f32 = 1.0 - 1.0 / 65536.0;

// What a light does at a point if nothing stands between.
struct Unshadowed {
    // W/m^2.
    irradiance: vec3<f32>,
    // Unit direction to the light.
    to: vec3<f32>,
    distance: f32,
}

fn unshadowed(light: Light, position: vec3<f32>, n: vec3<f32>) -> Unshadowed {
    if light.kind == 0u {
        let to = -light.direction;
        return Unshadowed(light.intensity * max(vector_dot(n, to), 0.0), to, F32_MAX);
    }
    let d = light.position - position;
    let squared = vector_dot(d, d);
    if squared <= 0.0 {
        return Unshadowed(vec3<f32>(), n, 0.0);
    }
    let distance = sqrt(squared);
    let to = d / distance;
    var falloff = max(vector_dot(n, to), 0.0) / squared;
    if light.kind == 2u {
        // KHR_lights_punctual: smooth between the cones, squared.
        let width = max(light.cos_inner - light.cos_outer, 1e-7);
        let share = clamp((-vector_dot(light.direction, to) - light.cos_outer) / width, 0.0, 1.0);
        falloff *= share * share;
    }
    return Unshadowed(light.intensity * falloff, to, distance);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(workgroup, groups, 64u, lane);
    if i >= batch.count {
        return;
    }
    let each = max(frame.lights_per_point, 1u);
    let point = points[i / each];
    let choice = i % each;
    var ray = Ray(vec3<f32>(), 0.0, vec3<f32>(0.0, 0.0, 1.0), 0.0);
    var irradiance = vec3<f32>();
    if surface_is_surface(point) && choice < frame.lights {
        var index = choice;
        var weight = 1.0;
        if frame.lights > each {
            let bits = bitcast<vec3<u32>>(point.position);
            let x = hash_hash3(bits.x, bits.y, bits.z);
            let u = hash_unit(hash_hash3(x, hash_hash2(frame.number, frame.seed), choice));
            let stratum = (f32(choice) + u) / f32(each) * f32(frame.lights);
            index = min(u32(stratum), frame.lights - 1u);
            weight = f32(frame.lights) / f32(each);
        }
        let arriving = unshadowed(lights[index], point.position, octahedral_unpack(point.shading_normal));
        if vector_max_element(arriving.irradiance) > 0.0 {
            let geometric = octahedral_unpack(point.geometric_normal);
            let origin = sampling_start(point.position, geometric, point.offset, 0.0, arriving.to);
            ray = Ray(origin, 0.0, arriving.to, arriving.distance * REACH);
            irradiance = arriving.irradiance * weight;
        }
    }
    rays[i] = ray;
    samples[i] = LightSample(irradiance, 0u);
}
