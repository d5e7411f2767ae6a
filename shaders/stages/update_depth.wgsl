// Distances of rays into the depth function of the surfels that they began on.
import package::invocation::invocation_index;
import package::lookup::{
    LOOKUP_FARTHEST, LOOKUP_MOMENT_SCALE, LOOKUP_RADIUS_STEPS, LOOKUP_UNKNOWN, lookup_guess, lookup_is_known,
    lookup_moments, lookup_pack_moments
};
import package::octahedral::octahedral_hemisphere_encode;
import package::plane::plane_unpack;
import package::sampling::sampling_to_local;
import package::types::{Hit, Ray, SurfelIrradiance, SurfelPose, SurfelSettings};
import package::vector::vector_dot;

@group(0) @binding(0) var<uniform> settings: SurfelSettings;
@group(0) @binding(1) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(2) var<storage, read> irradiance: array<SurfelIrradiance>;
@group(0) @binding(3) var<storage, read> spans: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> rays: array<Ray>;
@group(0) @binding(5) var<storage, read> hits: array<Hit>;
@if(places) @group(0) @binding(6) var<storage, read> places: array<u32>;
@group(0) @binding(7) var<storage, read_write> depths: array<u32>;

/// Row or column of the depth function for a coordinate in `[0, 1]`.
fn depth_index(x: f32) -> u32 {
    return min(u32(max(x * f32(settings.depth_side), 0.0)), settings.depth_side - 1u);
}

/// Rays after which a texel's share of a new distance has halved from all.
const DEPTH_SETTLES: f32 = 32.0;

/// Where a ray was traced.
@if(places)
fn place_of(ray: u32) -> u32 {
    return places[ray];
}
@else
fn place_of(ray: u32) -> u32 {
    return ray;
}

/// The distance of a ray into the depth function of its surfel, which has had `samples` before.
fn update_depth(surfel: u32, ray: u32, pose: SurfelPose, samples: u32) {
    let direction = rays[ray].direction;
    // One that could not reach the emitter it was drawn for went nowhere; one that goes below the surface tells nothing of what
    // stands on it.
    if rays[ray].t_max <= 0.0 || vector_dot(direction, plane_unpack(pose.mark)) < 0.0 {
        return;
    }
    let diameter = 2.0 * pose.radius;
    let local = sampling_to_local(direction, pose.normal);
    let uv = octahedral_hemisphere_encode(vec3<f32>(local.x, local.y, max(local.z, 0.0)));
    let texel = (surfel * settings.depth_side + depth_index(uv.y)) * settings.depth_side + depth_index(uv.x);
    // Compared before it is divided: the distance of a miss over the diameter would overflow.
    var t = LOOKUP_FARTHEST;
    let distance = hits[place_of(ray)].t;
    if distance < diameter {
        t = min(distance / diameter, LOOKUP_FARTHEST);
    }
    let blend = max(settings.depth_blend, DEPTH_SETTLES / (DEPTH_SETTLES + f32(samples)));
    let before = depths[texel];
    var learned = vec2<f32>(t, t * t);
    if lookup_is_known(before) {
        let old = lookup_moments(before);
        learned = old + (learned - old) * blend;
    }
    depths[texel] = lookup_pack_moments(max(learned, vec2<f32>(0.0, LOOKUP_MOMENT_SCALE)));
}

/// The least mean distance, in steps, that a ray has found beside a texel: a sixteenth of the texels' number away, rows and columns together; that of
/// the radius at most.
fn nearest_beside(surfel: u32, row: u32, column: u32) -> u32 {
    let side = settings.depth_side;
    let reach = max(side * side / 16u, 1u);
    var nearest = LOOKUP_RADIUS_STEPS;
    for (var y = row - min(row, reach); y <= min(row + reach, side - 1u); y++) {
        let along = reach - (max(y, row) - min(y, row));
        for (var x = column - min(column, along); x <= min(column + along, side - 1u); x++) {
            let other = depths[(surfel * side + y) * side + x];
            if lookup_is_known(other) {
                nearest = min(nearest, other & 0xffffu);
            }
        }
    }
    return nearest;
}

/// Where no ray of a young surfel has been, it takes surfaces to be as close as the closest that it found beside; at
/// last, to be far.
fn guess_depths(surfel: u32, is_last: bool) {
    let side = settings.depth_side;
    for (var row = 0u; row < side; row++) {
        for (var column = 0u; column < side; column++) {
            let texel = (surfel * side + row) * side + column;
            if lookup_is_known(depths[texel]) {
                continue;
            }
            depths[texel] = select(lookup_guess(nearest_beside(surfel, row, column)), LOOKUP_UNKNOWN, is_last);
        }
    }
}

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
    let span = spans[i];
    let pose = poses[i];
    let before = irradiance[i].drawn;
    for (var k = 0u; k < span.y; k++) {
        update_depth(i, span.x + k, pose, before + k);
    }
    let guesses_for = settings.depth_side * settings.depth_side * settings.depth_side * settings.depth_side;
    if span.y > 0u && before < guesses_for {
        guess_depths(i, before + span.y >= guesses_for);
    }
}
