// What a surfel's rays brought, into its guide.
import package::estimator::estimator_luminance;
import package::guide::{GUIDE_TEXELS, guide_texel, guide_texel_of};
import package::hash::{hash_hash2, hash_hash3, hash_unit};
import package::invocation::invocation_index;
import package::sampling::sampling_to_local;
import package::types::{Frame, Path, Ray, SurfelGuide, SurfelIrradiance, SurfelPose};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(2) var<storage, read> offsets: array<u32>;
@group(0) @binding(3) var<storage, read> rays: array<Ray>;
@group(0) @binding(4) var<storage, read> paths: array<Path>;
@group(0) @binding(5) var<storage, read> radiance: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> irradiance: array<SurfelIrradiance>;
@group(0) @binding(7) var<storage, read_write> guides: array<SurfelGuide>;

const PI: f32 = 3.1415927;
/// Least share of a new ray in a texel's average.
const BLEND: f32 = 0.05;
/// Brightest luminance that a guide holds.
const MOST_LUMINANCE: f32 = 1e30;

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
    if first == last {
        return;
    }
    let pose = poses[i];
    // Before its first rays are integrated, a surfel's guide is that of the one that had the slot before.
    let scale = select(guides[i].scale, 0u, irradiance[i].samples == 0u);
    let old_step = bitcast<f32>(scale & 0xffff0000u);
    var known = scale & 0xffffu;
    var luminances: array<f32, GUIDE_TEXELS>;
    for (var t = 0u; t < GUIDE_TEXELS; t++) {
        luminances[t] = f32(guide_texel(i, t)) * old_step;
    }
    for (var ray = first; ray < last; ray++) {
        let path = paths[ray];
        if path.density <= 0.0 || path.cosine <= 0.0 {
            continue;
        }
        let brought = estimator_luminance(radiance[ray].xyz);
        let luminance = brought * (path.density * PI / path.cosine);
        let texel = guide_texel_of(sampling_to_local(rays[ray].direction, pose.normal));
        let blend = max(1.0 / (1.0 + f32(known) / f32(GUIDE_TEXELS)), BLEND);
        luminances[texel] += (luminance - luminances[texel]) * blend;
        known++;
    }
    var brightest = 0.0;
    for (var t = 0u; t < GUIDE_TEXELS; t++) {
        brightest = max(brightest, luminances[t]);
    }
    brightest = min(brightest, MOST_LUMINANCE);
    // The step is rounded up, so that the brightest texel still fits.
    let bits = (bitcast<u32>(brightest / 255.0) + 0xffffu) & 0xffff0000u;
    let step = bitcast<f32>(bits);
    var packed: SurfelGuide;
    packed.scale = min(known, 0xffffu);
    if brightest > 0.0 && step > 0.0 {
        packed.scale |= bits;
        let seed = hash_hash3(pose.identity, frame.number, frame.seed);
        for (var t = 0u; t < GUIDE_TEXELS; t++) {
            let value = min(u32(luminances[t] / step + hash_unit(hash_hash2(seed, t))), 255u);
            packed.texels[t / 4u] |= value << (t % 4u * 8u);
        }
    }
    guides[i] = packed;
}
