// New surfels from the G-buffer, each in the slot that its quarter of a tile claimed.
import package::affine::{affine_map_point, affine_map_transposed};
import package::hash::hash_hash3;
import package::invocation::invocation_index;
import package::lengths::{lengths_down, lengths_pack};
import package::mark::mark_of;
import package::octahedral::{octahedral_pack, octahedral_unpack};
import package::plane::plane_pack;
import package::surface::surface_is_surface;
import package::surfel::{SURFEL_AT_HIT, surfel_radius_at};
import package::types::{
    Camera, F32_MAX, Frame, GridShape, NONE, SurfacePoint, SurfelBirth, SurfelIrradiance, SurfelPose,
    SurfelSettings, Transform
};
import package::vector::{vector_dot, vector_length, vector_normalize};

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<uniform> grid: GridShape;
@group(0) @binding(3) var<uniform> settings: SurfelSettings;
@group(0) @binding(4) var<storage, read> claims: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(6) var<storage, read> transforms: array<Transform>;
@group(0) @binding(7) var<storage, read_write> births: array<SurfelBirth>;
@group(0) @binding(8) var<storage, read_write> poses: array<SurfelPose>;
@group(0) @binding(9) var<storage, read_write> irradiance: array<SurfelIrradiance>;
@if(depths) @group(0) @binding(10) var<storage, read_write> depths: array<u32>;

/// Both moments one: the depth function at the diameter everywhere.
@if(depths)
fn open_depth_function(slot: u32) {
    let texels = settings.depth_side * settings.depth_side;
    for (var texel = slot * texels; texel < (slot + 1u) * texels; texel++) {
        depths[texel] = 0xffffffffu;
    }
}
@else
fn open_depth_function(slot: u32) {}

/// Sine of the angle from which on a surface counts as rising above a surfel.
const RISES: f32 = 0.25;

/// Distance from a pixel's surface to the nearest one in the picture that rises above it, within two target radii, metres:
/// to its plane, but at most the width of a pixel less than to the pixel.
fn clearance_of(pixel: u32) -> f32 {
    let at = vec2<u32>(pixel % camera.width, pixel / camera.width);
    let reach = u32(2.0 * settings.radius_pixels);
    let first = at - min(at, vec2<u32>(reach));
    let last = min(at + reach, vec2<u32>(camera.width, camera.height) - 1u);
    let position = points[pixel].position;
    let geometric = octahedral_unpack(points[pixel].geometric_normal);
    let shading = octahedral_unpack(points[pixel].shading_normal);
    var nearest = F32_MAX;
    for (var row = first.y; row <= last.y; row++) {
        for (var column = first.x; column <= last.x; column++) {
            let point = points[row * camera.width + column];
            if !surface_is_surface(point) {
                continue;
            }
            let d = point.position - position;
            let squared = vector_dot(d, d);
            let h = min(vector_dot(d, geometric), vector_dot(d, shading));
            if h > 0.0 && h * h > RISES * RISES * squared {
                let across = abs(vector_dot(octahedral_unpack(point.geometric_normal), d));
                let pixel_width = camera.pixel_angle * vector_length(point.position - camera.eye);
                nearest = min(nearest, max(across, sqrt(squared) - pixel_width));
            }
        }
    }
    return nearest;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile = invocation_index(group, groups, 64u, lane);
    if tile >= arrayLength(&claims) {
        return;
    }
    let claim = claims[tile];
    if claim.x == NONE {
        return;
    }
    let slot = claim.x;
    let at_hit = claim.y & SURFEL_AT_HIT;
    let point = points[claim.y & ~SURFEL_AT_HIT];
    let transform = transforms[point.transform_id];
    let geometric = octahedral_unpack(point.geometric_normal);
    let is_geometric = settings.geometric_normals != 0u;
    let normal = select(octahedral_unpack(point.shading_normal), geometric, is_geometric);
    var clearance = F32_MAX;
    if at_hit == 0u {
        clearance = clearance_of(claim.y);
    }
    let local = vector_normalize(affine_map_transposed(transform.to_world, normal));
    let across = vector_normalize(affine_map_transposed(transform.to_world, geometric));
    let lengths = lengths_pack(point.offset, clearance);
    let born_at = affine_map_point(transform.to_local, point.position);
    births[slot] = SurfelBirth(born_at, point.transform_id, octahedral_pack(local), octahedral_pack(across), frame.number, lengths);
    let radius = surfel_radius_at(point.position, lengths_down(lengths), camera, grid, settings);
    let identity = hash_hash3(tile | at_hit, frame.number, frame.seed);
    // Nothing hides yet, but in this frame the depth function learns what does.
    poses[slot] = SurfelPose(point.position, radius, normal, mark_of(identity, plane_pack(geometric), false));
    irradiance[slot] = SurfelIrradiance();
    open_depth_function(slot);
}
