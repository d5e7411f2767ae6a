// Rays over each surfel's cosine lobe, from its own shifted low-discrepancy sequence; where the stage binds `emitters`, a
// share of them to points on those.
import package::draw::draw_ray;
import package::hash::{hash_hash2, hash_hash3};
import package::invocation::invocation_index;
import package::mixture::mixture_goes_to_emitter;
import package::sampling::{sampling_r2, sampling_start};
import package::types::{Emitter, Frame, Path, Ray, SurfelBirth, SurfelIrradiance, SurfelPose, SurfelSettings};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> settings: SurfelSettings;
@group(0) @binding(2) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(3) var<storage, read> births: array<SurfelBirth>;
@group(0) @binding(4) var<storage, read> irradiance: array<SurfelIrradiance>;
@group(0) @binding(5) var<storage, read> offsets: array<u32>;
@if(emitters) @group(0) @binding(6) var<storage, read> emitters: array<Emitter>;
@group(0) @binding(7) var<storage, read_write> rays: array<Ray>;
@group(0) @binding(8) var<storage, read_write> paths: array<Path>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= arrayLength(&poses) {
        return;
    }
    let first = offsets[i];
    let last = offsets[i + 1u];
    let pose = poses[i];
    let surfel = hash_hash2(pose.identity, frame.seed);
    let shift = vec2<u32>(hash_hash2(surfel, 0u), hash_hash2(surfel, 1u));
    for (var ray = first; ray < last; ray++) {
        let index = irradiance[i].samples + (ray - first);
        let seed = hash_hash3(surfel, frame.number, ray - first);
        let at_emitter = mixture_goes_to_emitter(index, hash_hash2(surfel, 2u));
        let drawn = draw_ray(pose.position, pose.normal, sampling_r2(index, shift), seed, at_emitter);
        let origin = sampling_start(pose.position, pose.normal, births[i].offset, drawn.direction);
        rays[ray] = Ray(origin, 0.0, drawn.direction, drawn.t_max);
        paths[ray] = Path(vec3<f32>(1.0), ray, seed, settings.continuations, drawn.cosine, drawn.density);
    }
}
