// Rays over each surfel's cosine lobe, from its own shifted low-discrepancy sequence; where the stage binds `emitters`, a
// share of them to points on those.
import package::draw::{Drawn, draw_ray};
@if(guides) import package::guide::{guide_density, guide_draw, guide_share, guide_total};
import package::hash::{hash_hash2, hash_hash3};
import package::invocation::invocation_index;
import package::lengths::lengths_up;
import package::mark::mark_identity;
import package::mixture::mixture_goes_to_emitter;
@if(guides) import package::mixture::{mixture_follow_guide, mixture_guided_density};
import package::plane::{PLANE_OFF, plane_unpack};
import package::sampling::{sampling_r2, sampling_start};
@if(guides) import package::sampling::{sampling_cosine_hemisphere, sampling_to_local, sampling_to_world};
import package::types::{
    Emitter, Frame, Path, Ray, SurfelBirth, SurfelIrradiance, SurfelPose, SurfelSettings
};
@if(guides) import package::types::F32_MAX;
import package::vector::vector_normalize;

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> settings: SurfelSettings;
@group(0) @binding(2) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(3) var<storage, read> births: array<SurfelBirth>;
@group(0) @binding(4) var<storage, read> irradiance: array<SurfelIrradiance>;
@group(0) @binding(5) var<storage, read> spans: array<vec2<u32>>;
@if(emitters) @group(0) @binding(6) var<storage, read> emitters: array<Emitter>;
@if(guides) @group(0) @binding(7) var<storage, read> guides: array<u32>;
@group(0) @binding(8) var<storage, read_write> rays: array<Ray>;
@group(0) @binding(9) var<storage, read_write> paths: array<Path>;

/// What is known of a surfel's guide: its sum, and the share of rays that follow it.
struct Guide {
    total: f32,
    share: f32,
}

@if(guides)
fn find_guide(surfel: u32, identity: u32) -> Guide {
    let total = guide_total(surfel);
    return Guide(total, guide_share(surfel, identity, total));
}
@else
fn find_guide(surfel: u32, identity: u32) -> Guide {
    return Guide(0.0, 0.0);
}

/// `emitters` is bound.
@if(emitters)
const HAS_EMITTERS: bool = true;
@else
const HAS_EMITTERS: bool = false;

@if(guides)
fn density_of(slot: u32, guide: Guide, local: vec3<f32>, cosine: f32) -> f32 {
    return mixture_guided_density(cosine, guide_density(slot, guide.total, local), guide.share, HAS_EMITTERS);
}

/// A ray of the surfel in a slot.
@if(guides)
fn draw_guided(
    slot: u32,
    pose: SurfelPose,
    uv: vec2<f32>,
    seed: u32,
    at_emitter: bool,
    guide: Guide,
) -> Drawn {
    if guide.share <= 0.0 {
        return draw_ray(pose.position, pose.normal, uv, seed, at_emitter);
    }
    if HAS_EMITTERS && at_emitter {
        var drawn = draw_ray(pose.position, pose.normal, uv, seed, true);
        if drawn.cosine > 0.0 {
            let local = sampling_to_local(drawn.direction, pose.normal);
            drawn.density = -density_of(slot, guide, local, drawn.cosine);
        }
        return drawn;
    }
    let choice = mixture_follow_guide(uv.x, guide.share);
    var local: vec3<f32>;
    if choice.guided {
        local = guide_draw(slot, vec2<f32>(choice.left, uv.y));
    } else {
        local = sampling_cosine_hemisphere(choice.left, uv.y);
    }
    let density = density_of(slot, guide, local, local.z);
    return Drawn(sampling_to_world(local, pose.normal), F32_MAX, local.z, density);
}
@else
fn draw_guided(
    slot: u32,
    pose: SurfelPose,
    uv: vec2<f32>,
    seed: u32,
    at_emitter: bool,
    guide: Guide,
) -> Drawn {
    return draw_ray(pose.position, pose.normal, uv, seed, at_emitter);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= settings.capacity {
        return;
    }
    let span = spans[i];
    let pose = poses[i];
    let surfel = hash_hash2(mark_identity(pose.mark), frame.seed);
    let shift = vec2<u32>(hash_hash2(surfel, 0u), hash_hash2(surfel, 1u));
    let guide = find_guide(i, mark_identity(pose.mark));
    // What goes below the surface, where the normal leans away from it, would meet that at once from above.
    let across = vector_normalize(plane_unpack(pose.mark));
    let offset = lengths_up(births[i].lengths);
    for (var k = 0u; k < span.y; k++) {
        let ray = span.x + k;
        let index = irradiance[i].drawn + k;
        let seed = hash_hash3(surfel, frame.number, k);
        let at_emitter = mixture_goes_to_emitter(index, hash_hash2(surfel, 2u));
        let drawn = draw_guided(i, pose, sampling_r2(index, shift), seed, at_emitter, guide);
        let origin = sampling_start(pose.position, across, offset, PLANE_OFF, drawn.direction);
        rays[ray] = Ray(origin, 0.0, drawn.direction, drawn.t_max);
        paths[ray] = Path(vec3<f32>(1.0), ray, seed, i, drawn.cosine, drawn.density);
    }
}
