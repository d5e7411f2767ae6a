// Surfels follow the surfaces that they were born on, and their radius follows the camera.
import package::affine::{affine_map_point, affine_map_transposed};
import package::invocation::invocation_index;
import package::lengths::{lengths_down, lengths_pack, lengths_up};
@if(depths) import package::lookup::{LOOKUP_CLOSE, LOOKUP_RADIUS_STEPS, lookup_is_known, lookup_rescaled};
import package::mark::{mark_identity, mark_of};
import package::octahedral::octahedral_unpack;
import package::plane::plane_pack;
import package::recycling::{RECYCLING_CHOSEN, recycling_one_more};
import package::surfel::{SURFEL_LEARNS_FOR, SURFEL_LEARNS_UP_TO, SURFEL_SHRINKS_TO, surfel_radius_at};
import package::types::{
    Camera, Frame, GridShape, SurfelBirth, SurfelPose, SurfelSettings, Transform
};
import package::vector::vector_normalize;

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<uniform> grid: GridShape;
@group(0) @binding(3) var<uniform> settings: SurfelSettings;
@group(0) @binding(4) var<storage, read> transforms: array<Transform>;
@group(0) @binding(5) var<storage, read_write> births: array<SurfelBirth>;
@group(0) @binding(6) var<storage, read_write> poses: array<SurfelPose>;
@group(0) @binding(7) var<storage, read_write> unseen: array<u32>;
@if(depths) @group(0) @binding(8) var<storage, read_write> depths: array<u32>;
@group(0) @binding(9) var<storage, read_write> gone: array<u32>;

/// The depth function follows the radius, over twice which its distances are.
@if(depths)
fn rescale_depths(surfel: u32, shrinks: f32) {
    let squared = shrinks * shrinks;
    let texels = settings.depth_side * settings.depth_side;
    for (var texel = surfel * texels; texel < (surfel + 1u) * texels; texel++) {
        depths[texel] = lookup_rescaled(depths[texel], shrinks, squared);
    }
}
@else
fn rescale_depths(surfel: u32, shrinks: f32) {}

/// Whether a surfel has learned that surfaces are so close that its irradiance says little of places a radius away.
@if(depths)
fn is_crowded(surfel: u32) -> bool {
    var lacks = 0u;
    let texels = settings.depth_side * settings.depth_side;
    for (var texel = surfel * texels; texel < (surfel + 1u) * texels; texel++) {
        if lookup_is_known(depths[texel]) {
            lacks += LOOKUP_RADIUS_STEPS - min(depths[texel] & 0xffffu, LOOKUP_RADIUS_STEPS);
        }
    }
    return lacks > texels * LOOKUP_CLOSE;
}
@else
fn is_crowded(surfel: u32) -> bool {
    return false;
}

/// Whether the depth function hides nothing within the radius: in no direction is the mean distance shorter.
@if(depths)
fn is_open(surfel: u32) -> bool {
    let texels = settings.depth_side * settings.depth_side;
    for (var texel = surfel * texels; texel < (surfel + 1u) * texels; texel++) {
        if (depths[texel] & 0xffffu) < LOOKUP_RADIUS_STEPS {
            return false;
        }
    }
    return true;
}
@else
fn is_open(surfel: u32) -> bool {
    return true;
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
    let pose = poses[i];
    if pose.radius <= 0.0 {
        gone[i] = 0u;
        return;
    }
    let birth = births[i];
    if unseen[i] == RECYCLING_CHOSEN || birth.transform_id >= arrayLength(&transforms) {
        gone[i] = 1u;
        return;
    }
    gone[i] = 0u;
    unseen[i] = recycling_one_more(unseen[i]);
    let transform = transforms[birth.transform_id];
    let position = affine_map_point(transform.to_world, birth.position);
    let normal = vector_normalize(affine_map_transposed(transform.to_local, octahedral_unpack(birth.normal)));
    let across = vector_normalize(affine_map_transposed(transform.to_local, octahedral_unpack(birth.plane)));
    var clearance = lengths_down(birth.lengths);
    let open = surfel_radius_at(position, clearance, camera, grid, settings);
    var born = birth.frame;
    if open > SURFEL_LEARNS_UP_TO * pose.radius && frame.number - born < SURFEL_LEARNS_FOR {
        born = frame.number - SURFEL_LEARNS_FOR;
        births[i].frame = born;
    }
    if frame.number - born < SURFEL_LEARNS_FOR && is_crowded(i) {
        clearance = min(clearance, SURFEL_SHRINKS_TO * pose.radius);
        let lengths = lengths_pack(lengths_up(birth.lengths), clearance);
        births[i].lengths = lengths;
        clearance = lengths_down(lengths);
    }
    let radius = surfel_radius_at(position, clearance, camera, grid, settings);
    if radius != pose.radius {
        rescale_depths(i, pose.radius / radius);
    }
    poses[i] = SurfelPose(position, radius, normal, mark_of(mark_identity(pose.mark), plane_pack(across), is_open(i)));
}
