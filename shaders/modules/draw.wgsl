// Rays from surfaces: over the cosine lobe, or to points on the emitters in the stage's global `emitters`, where it binds
// that.
@if(emitters) import package::emitter::{emitter_facing, emitter_triangle_point};
@if(emitters) import package::hash::{hash_hash2, hash_unit};
import package::mixture::mixture_lobe_density;
@if(emitters) import package::mixture::MIXTURE_SLACK;
import package::sampling::{sampling_cosine_hemisphere, sampling_to_world};
import package::types::F32_MAX;
@if(emitters) import package::vector::vector_dot;

/// Where a ray goes.
struct Drawn {
    direction: vec3<f32>,
    t_max: f32,
    cosine: f32,
    /// As `Path.density`.
    density: f32,
}

/// A ray over the lobe about `normal`, from two numbers in `[0, 1)`.
fn draw_over_the_lobe(normal: vec3<f32>, uv: vec2<f32>, emitters_too: bool) -> Drawn {
    let local = sampling_cosine_hemisphere(uv.x, uv.y);
    let density = mixture_lobe_density(local.z, emitters_too);
    return Drawn(sampling_to_world(local, normal), F32_MAX, local.z, density);
}

/// Index of the first emitter whose cumulative probability is above `x`; the last one at most.
@if(emitters)
fn draw_find_emitter(x: f32) -> u32 {
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

/// A ray to a point of an emitter; one without length where it does not face the surface.
@if(emitters)
fn draw_to_emitter(position: vec3<f32>, normal: vec3<f32>, uv: vec2<f32>, seed: u32) -> Drawn {
    let chosen = emitters[draw_find_emitter(hash_unit(hash_hash2(seed, 0x656d6974u)))];
    let at = emitter_triangle_point(uv.x, uv.y);
    let d = chosen.v0 + chosen.e1 * at.x + chosen.e2 * at.y - position;
    let distance = sqrt(vector_dot(d, d));
    let direction = d / max(distance, 1e-30);
    let cosine = vector_dot(normal, direction);
    if cosine <= 0.0 || emitter_facing(chosen, direction) <= 0.0 {
        return Drawn(normal, 0.0, 0.0, -1.0);
    }
    return Drawn(direction, distance * (1.0 + MIXTURE_SLACK), cosine, -mixture_lobe_density(cosine, true));
}

/// Either, as `at_emitter` says; over the lobe where no emitters are bound.
@if(emitters)
fn draw_ray(position: vec3<f32>, normal: vec3<f32>, uv: vec2<f32>, seed: u32, at_emitter: bool) -> Drawn {
    if at_emitter {
        return draw_to_emitter(position, normal, uv, seed);
    }
    return draw_over_the_lobe(normal, uv, true);
}
@else
fn draw_ray(position: vec3<f32>, normal: vec3<f32>, uv: vec2<f32>, seed: u32, at_emitter: bool) -> Drawn {
    return draw_over_the_lobe(normal, uv, false);
}
