// What the rays of its neighbours brought, into a surfel's guide.
import package::estimator::estimator_luminance;
import package::grid::grid_cell;
import package::guide::{
    GUIDE_MOST_STEPS, GUIDE_MOST_TEXELS, GUIDE_RAYS_STEP, guide_first, guide_probability, guide_rays, guide_share,
    guide_tag, guide_texel, guide_texel_of, guide_texels, guide_total
};
import package::hash::{hash_hash2, hash_hash3, hash_pcg, hash_unit};
import package::invocation::invocation_index;
import package::mark::mark_identity;
import package::sampling::sampling_to_local;
import package::types::{Frame, GridShape, Path, Ray, SurfelPose, SurfelSettings};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> grid: GridShape;
@group(0) @binding(2) var<uniform> settings: SurfelSettings;
@group(0) @binding(3) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> entries: array<u32>;
@group(0) @binding(5) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(6) var<storage, read> spans: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read> rays: array<Ray>;
@group(0) @binding(8) var<storage, read> paths: array<Path>;
@group(0) @binding(9) var<storage, read> radiance: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read_write> guides: array<u32>;

const PI: f32 = 3.1415927;
/// Rays up to which new ones move all texels towards their mean.
const PRIOR_RAYS: u32 = 64u;
/// Least share of a new ray in a texel's average.
const BLEND: f32 = 0.05;
/// Neighbours that a surfel learns from in a frame, and surfels that it looks at to find them.
const NEIGHBOURS: u32 = 8u;
const CANDIDATES: u32 = 16u;
/// Cosine between the normals of surfels that learn from each other.
const ALIKE: f32 = 0.7;
/// Rays of a neighbour that are learned from in a frame.
const RAYS_OF_NEIGHBOUR: u32 = 32u;
/// Brightest luminance that a guide holds.
const MOST_LUMINANCE: f32 = 1e18;

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
    let pose = poses[i];
    if pose.radius <= 0.0 {
        return;
    }
    let cell = cells[grid_cell(pose.position, grid)];
    let first_word = guide_first(i);
    let texels = guide_texels();
    let known = guide_rays(i, mark_identity(pose.mark));
    var old_step = 0.0;
    var total = 0.0;
    var share = 0.0;
    if known > 0u {
        old_step = bitcast<f32>(guides[first_word] & 0xffff0000u);
        total = guide_total(i);
        share = guide_share(i, mark_identity(pose.mark), total);
    }
    // Mean squares of luminance.
    var squares: array<f32, GUIDE_MOST_TEXELS>;
    for (var t = 0u; t < texels; t++) {
        let luminance = f32(guide_texel(i, t)) * old_step;
        squares[t] = luminance * luminance;
    }
    let seed = hash_hash3(mark_identity(pose.mark), frame.number, frame.seed);
    let most = min(cell.y, CANDIDATES);
    var taught = 0u;
    var count = 0u;
    var sum = 0.0;
    for (var k = 0u; k < most && taught < NEIGHBOURS; k++) {
        let other = entries[cell.x + (hash_pcg(seed) % cell.y + k) % cell.y];
        let first = spans[other].x;
        let last = first + min(spans[other].y, RAYS_OF_NEIGHBOUR);
        let n = poses[other].normal;
        let alike = n.x * pose.normal.x + n.y * pose.normal.y + n.z * pose.normal.z > ALIKE;
        if other == i || first == last || !alike {
            continue;
        }
        for (var ray = first; ray < last; ray++) {
            let path = paths[ray];
            let local = sampling_to_local(rays[ray].direction, pose.normal);
            if path.density <= 0.0 || path.cosine <= 0.0 || local.z <= 0.0 {
                continue;
            }
            let brought = estimator_luminance(radiance[ray].xyz);
            let luminance = min(brought * (PI * path.density / path.cosine), MOST_LUMINANCE);
            let square = luminance * luminance;
            let texel = guide_texel_of(local);
            // Of rays that a texel can expect to have had, and not of those that it had, which nobody counts.
            let before = f32(known + count) * guide_probability(i, total, share, texel);
            let blend = max(1.0 / (2.0 + before), BLEND);
            squares[texel] += (square - squares[texel]) * blend;
            sum += square;
            count++;
        }
        taught++;
    }
    if count == 0u {
        return;
    }
    let learned = known + count;
    if known < PRIOR_RAYS {
        let mean = sum / f32(count);
        let part = f32(count) / f32(learned);
        for (var t = 0u; t < texels; t++) {
            squares[t] += (mean - squares[t]) * part;
        }
    }
    var brightest = 0.0;
    for (var t = 0u; t < texels; t++) {
        squares[t] = sqrt(max(squares[t], 0.0));
        brightest = max(brightest, squares[t]);
    }
    brightest = min(brightest, MOST_LUMINANCE);
    // The step is rounded up, so that the brightest texel still fits.
    let bits = (bitcast<u32>(brightest / 255.0) + 0xffffu) & 0xffff0000u;
    let step = bitcast<f32>(bits);
    var scale = min((learned + GUIDE_RAYS_STEP - 1u) / GUIDE_RAYS_STEP, GUIDE_MOST_STEPS);
    scale |= guide_tag(mark_identity(pose.mark)) << 10u;
    let is_lit = brightest > 0.0 && step > 0.0;
    if is_lit {
        scale |= bits;
    }
    guides[first_word] = scale;
    for (var t = 0u; t < texels; t += 4u) {
        var word = 0u;
        for (var k = 0u; k < 4u && is_lit; k++) {
            let value = min(u32(squares[t + k] / step + hash_unit(hash_hash2(seed, t + k))), 255u);
            word |= value << (k * 8u);
        }
        guides[first_word + 1u + t / 4u] = word;
    }
}
