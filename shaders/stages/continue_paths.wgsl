// The next segment of each path that goes on: packed, in order, with a ray over the cosine lobe where it is.
import package::draw::draw_ray;
import package::hash::{hash_pcg, hash_unit};
import package::invocation::invocation_index;
import package::mixture::MIXTURE_TO_EMITTERS;
import package::octahedral::octahedral_unpack;
import package::sampling::sampling_start;
import package::types::{DispatchArgs, Emitter, Path, Ray, SurfacePoint};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(2) var<storage, read> paths: array<Path>;
@group(0) @binding(3) var<storage, read> goes_on: array<u32>;
@group(0) @binding(4) var<storage, read> before: array<u32>;
@if(emitters) @group(0) @binding(5) var<storage, read> emitters: array<Emitter>;
@group(0) @binding(6) var<storage, read_write> next_rays: array<Ray>;
@group(0) @binding(7) var<storage, read_write> next_paths: array<Path>;

const PATHS_PER_WORD: u32 = 32u;

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
    let word = goes_on[i / PATHS_PER_WORD];
    let bit = i % PATHS_PER_WORD;
    if (word >> bit & 1u) == 0u {
        return;
    }
    let point = points[i];
    var path = paths[i];
    let first = hash_pcg(path.seed);
    let second = hash_pcg(first);
    let third = hash_pcg(second);
    let normal = octahedral_unpack(point.shading_normal);
    let uv = vec2<f32>(hash_unit(first), hash_unit(second));
    let at_emitter = hash_unit(third) < MIXTURE_TO_EMITTERS;
    let drawn = draw_ray(point.position, normal, uv, second, at_emitter);
    let geometric = octahedral_unpack(point.geometric_normal);
    let origin = sampling_start(point.position, geometric, point.offset, 0.0, drawn.direction);
    let slot = before[i / PATHS_PER_WORD] + countOneBits(word & ((1u << bit) - 1u));
    next_rays[slot] = Ray(origin, 0.0, drawn.direction, drawn.t_max);
    path.seed = third;
    path.cosine = drawn.cosine;
    path.density = drawn.density;
    next_paths[slot] = path;
}
