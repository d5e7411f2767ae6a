// A point on an emissive triangle or of the sky for the vertex of each live path, and the shadow ray towards it,
// weighted against the cosine-distributed ray by the balance heuristic (Veach 1997).
import package::emitter::{
    EMITTER_REACH, emitter_density, emitter_facing, emitter_radiance, emitter_sky_share, emitter_triangle_point
};
import package::environment::{environment_direction, environment_solid_angle_per_area};
import package::hash::{hash_hash2, hash_pcg, hash_unit};
import package::invocation::invocation_index;
import package::octahedral::octahedral_unpack;
import package::sampling::sampling_start;
import package::types::{Emitter, F32_MAX, Frame, LightSample, Ray, ReferencePath, SurfacePoint};
import package::vector::vector_dot;

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> vertices: array<SurfacePoint>;
@group(0) @binding(2) var<storage, read> paths: array<ReferencePath>;
@group(0) @binding(3) var<storage, read> emitters: array<Emitter>;
@group(0) @binding(4) var<storage, read> environment: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> sky_cumulative: array<f32>;
@group(0) @binding(6) var<storage, read_write> rays: array<Ray>;
@group(0) @binding(7) var<storage, read_write> samples: array<LightSample>;

const FRAC_1_PI: f32 = 0.31830987;

// What the vertex would see of the chosen emitter.
struct Choice {
    // Unit direction to it.
    direction: vec3<f32>,
    // Length of the shadow ray.
    reach: f32,
    // W/(m^2 sr).
    radiance: vec3<f32>,
    // Density of the choice per solid angle, 1/sr.
    density: f32,
}

// Index of the first element of the sky's table that is above `x`; the last one at most.
fn find_texel(x: f32) -> u32 {
    var low = 0u;
    var high = arrayLength(&sky_cumulative) - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if sky_cumulative[middle] > x {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    return low;
}

// Index of the first emitter whose cumulative probability is above `x`; the last one at most.
fn find_emitter(x: f32) -> u32 {
    var low = 0u;
    var high = arrayLength(&emitters) - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if emitters[middle].cumulative > x {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    return low;
}

fn choose_sky(share: f32, a: f32, b: f32, c: f32) -> Choice {
    let texel = find_texel(a);
    let side = frame.environment_side;
    let direction = environment_direction(side, texel % side, texel / side, b, c);
    let map = environment[texel];
    let density = share * map.w / environment_solid_angle_per_area(direction);
    return Choice(direction, F32_MAX, map.xyz, density);
}

fn choose_triangle(position: vec3<f32>, share: f32, a: f32, b: f32, c: f32) -> Choice {
    let chosen = emitters[find_emitter(a)];
    let at = emitter_triangle_point(b, c);
    let d = chosen.v0 + chosen.e1 * at.x + chosen.e2 * at.y - position;
    let distance = sqrt(vector_dot(d, d));
    let direction = d / max(distance, 1e-30);
    let radiance = emitter_radiance(chosen, direction);
    let cosine = emitter_facing(chosen, direction);
    let density = (1.0 - share) * emitter_density(frame, chosen.radiance, cosine, distance);
    return Choice(direction, distance * EMITTER_REACH, radiance, density);
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
    var ray = Ray(vec3<f32>(), 0.0, vec3<f32>(0.0, 0.0, 1.0), 0.0);
    var irradiance = vec3<f32>();
    let share = emitter_sky_share(frame);
    if paths[i].segment != 0u && share >= 0.0 {
        let vertex = vertices[i];
        let normal = octahedral_unpack(vertex.shading_normal);
        let which = hash_pcg(hash_hash2(paths[i].seed, 0x656d6974u));
        let first = hash_pcg(which);
        let second = hash_pcg(first);
        let third = hash_pcg(second);
        let a = hash_unit(first);
        let b = hash_unit(second);
        let c = hash_unit(third);
        var choice: Choice;
        if hash_unit(which) < share {
            choice = choose_sky(share, a, b, c);
        } else {
            choice = choose_triangle(vertex.position, share, a, b, c);
        }
        let cosine = vector_dot(normal, choice.direction);
        if cosine > 0.0 && choice.density > 0.0 {
            irradiance = choice.radiance * (cosine / (choice.density + cosine * FRAC_1_PI));
            let geometric = octahedral_unpack(vertex.geometric_normal);
            let origin = sampling_start(vertex.position, geometric, vertex.offset, 0.0, choice.direction);
            ray = Ray(origin, 0.0, choice.direction, choice.reach);
        }
    }
    rays[i] = ray;
    samples[i] = LightSample(irradiance, 0u);
}
